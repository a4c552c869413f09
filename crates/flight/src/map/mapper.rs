//! From visits to nodes: which visits are to one place, and what lies between.

use std::collections::BTreeMap;
use std::sync::Arc;

use crosscut_stage::{Frame, PoseDoubt, wrap_angle_rad};
use nalgebra::{Isometry2, Matrix3, Point2, Vector3};

use super::Map;
use super::agreed::{Guess, Stray};
use super::flown::Flown;
use super::outline::Walls;
use super::passed::Passed;
use super::travelled::Travelled;
use super::visit::{OpenVisit, Visit};
use crate::line_points::line_points;
use crate::{Edge, FlightAnswer, HereKind, PoseGraph};

/// A visit has ended once the vehicle has moved this far in a passage: the place may be in doubt in between. One to a
/// dead end, only once it is certain by which side the vehicle leaves.
const LEFT_M: f64 = 1.0;
const LEFT_DEAD_END_M: f64 = 5.0;

/// Where an anchor lies in its place, standard deviation.
const ANCHOR_M: f64 = 0.1;

/// How little is known of where a stretch lies (standard deviations).
const UNKNOWN_M: f64 = 1000.0;
const UNKNOWN_RAD: f64 = 3.0;

/// Makes the map of a flight from its frames, in order.
#[derive(Clone, Debug, Default)]
pub struct Mapper {
    pub(super) map: Map,
    open: Option<OpenVisit>,
    /// A visit that has ended at a place that was seen from its edge alone, until the vehicle is beyond it; and where the vehicle
    /// left to.
    passing: Option<(OpenVisit, Isometry2<f64>)>,
    pub(super) passed: Passed,
    /// Each visit's anchor, and what was measured between them. Poses are corrected, measurements are not.
    pub(super) graph: PoseGraph,
    /// How each edge of the graph was flown.
    pub(super) flown: Vec<Flown>,
    /// What is kept of each node to recognise it.
    pub(super) places: Vec<Place>,
    /// Standard deviation of the first visit as seen from where the flight began; `None` if that is not known.
    first_sd_m: Option<f64>,
    /// Of each passage: the visit from which it was entered first, and places along it in the frame of that anchor.
    pub(super) courses: Vec<(usize, Vec<Point2<f64>>)>,
    pub(super) last: Option<Departure>,
    pub(super) way: Travelled,
    /// When the vehicle was last in a node, and the way then.
    in_node_ns: u64,
    in_node_at_m: f64,
    /// Of the pose, when the visit that is open began, and when the vehicle was in a node last.
    began_doubt: PoseDoubt,
    in_node_doubt: PoseDoubt,
    /// Of the latest pose.
    doubt: PoseDoubt,
    /// Where visits of this stretch to which no known way led may have been, and those that were not compared with all places.
    pub(super) guesses: Vec<Guess>,
    pub(super) strays: Vec<Stray>,
}

/// Where the vehicle is on the map.
#[derive(Clone, Debug)]
pub struct Located {
    /// The map; its passages have no courses.
    pub map: Map,
    /// The node that the vehicle is in, or was in last.
    pub node: usize,
    /// Brings poses as they are tracked now into the frame of the map.
    pub correction: Isometry2<f64>,
    /// Where the visits were, for places that are [`Anchored`](super::Anchored) to them.
    pub visits: Vec<Isometry2<f64>>,
}

/// What is kept of a node to recognise it.
#[derive(Clone, Debug)]
pub(super) struct Place {
    /// As its first visit saw them.
    pub(super) walls: Arc<Walls>,
    /// Directions of its ways in the frame of its first visit.
    pub(super) ways_rad: Vec<f64>,
    pub(super) first_visit: usize,
    /// The belief in each number of ways, summed over its visits.
    pub(super) belief: BTreeMap<usize, f64>,
}

/// How the vehicle left the last node.
#[derive(Clone, Debug)]
pub(super) struct Departure {
    pub(super) node: usize,
    pub(super) way: usize,
    /// The way had been taken before.
    was_taken: bool,
    /// The vehicle was beyond the look since: the way is certain.
    is_settled: bool,
    pub(super) has_middle: bool,
    pub(super) visit: usize,
    pub(super) look_m: f64,
    /// The anchor as it was tracked.
    pub(super) tracked: Isometry2<f64>,
    /// The way of the flight there.
    pub(super) at_m: f64,
    pub(super) left_ns: u64,
    doubt: PoseDoubt,
    /// Where its ways begin, as they were tracked.
    pub(super) mouths_m: Vec<Point2<f64>>,
}

impl Mapper {
    /// Takes the next frame, with its pose and its steady place. A frame without a pose is passed over.
    pub fn add(&mut self, frame: &Frame) {
        let flown = FlightAnswer::of(frame);
        let (Some(pose), Some(steady)) = (flown.pose, flown.steady_here()) else {
            return;
        };
        let (now_ns, doubt) = (frame.revolution.stamp_ns, flown.doubt.unwrap_or_default());
        if doubt.stretch != self.doubt.stretch {
            self.end_stretch();
        }
        self.doubt = doubt;
        self.way.add(pose);
        let lines = || {
            let mut points = Vec::new();
            line_points(&frame.revolution.points_m, 1, &mut points);
            points
        };
        self.passed.add(pose, lines);
        self.settle(Point2::from(pose.translation.vector));
        let node = steady.node();
        let place_m = Point2::from(pose.translation.vector);
        let is_known = self.doubt.since(&self.in_node_doubt).is_some_and(|since| since.sd_m(place_m).is_some());
        let has_ended = |open: &OpenVisit| match (node, open.kind()) {
            (Some(node), kind) if kind != node => true,
            (Some(_), kind) => {
                kind == HereKind::Junction
                    && (open.has_left_the_middle(self.way.way_m) || open.has_turned_back(&place_m))
            }
            (None, _) if !is_known => true,
            (None, HereKind::DeadEnd) => self.way.way_m - self.in_node_at_m > LEFT_DEAD_END_M,
            (None, _) => self.way.way_m - self.in_node_at_m > LEFT_M,
        };
        let follows =
            node.is_some() && self.open.as_ref().is_some_and(|open| Some(open.kind()) == node && has_ended(open));
        if self.open.as_ref().is_some_and(has_ended) {
            let is_of_its_edge = |open: &mut OpenVisit| open.kind() == HereKind::Junction && !open.has_middle();
            let passing = self.open.take_if(|open| node.is_none() && is_known && is_of_its_edge(open));
            self.passing = passing.map(|open| (open, pose));
            self.end_visit(self.in_node_ns, Some(pose));
        }
        let is_behind = |(open, _): &(OpenVisit, _)| node.is_some() || !is_known || open.is_behind(&pose);
        if self.passing.as_ref().is_some_and(is_behind) {
            self.end_passing();
        }
        let Some(seen) = &flown.here else { return };
        if let Some(node) = node {
            (self.in_node_ns, self.in_node_at_m) = (now_ns, self.way.way_m);
            self.in_node_doubt = doubt;
            if self.open.is_none() {
                self.began_doubt = doubt;
            }
            let came_from = self.way.came_from();
            let last_m = self.last.as_ref().map(|last| Point2::from(last.tracked.translation.vector));
            let follows = last_m.filter(|_| follows);
            let open = self.open.get_or_insert_with(|| OpenVisit::new(node, now_ns, came_from, follows));
            open.add(now_ns, pose, self.way.way_m, seen, lines);
        } else if let Some(width_m) = seen.ways.iter().map(|way| way.width_m).min_by(f64::total_cmp) {
            self.way.widths_m = [self.way.widths_m[0] + width_m, self.way.widths_m[1] + 1.0];
        }
    }

    /// The map up to now. A visit that has not ended counts.
    pub fn map(&self) -> Map {
        let mut ended = self.ended();
        for (passage, (visit, via_m)) in ended.map.passages.iter_mut().zip(&ended.courses) {
            passage.via_m = via_m.iter().map(|place_m| ended.graph.poses[*visit] * place_m).collect();
        }
        ended.map
    }

    /// Whether the vehicle is in a node, and has been there long enough for it to be believed.
    pub fn is_in_node(&self) -> bool {
        self.open.as_ref().is_some_and(OpenVisit::is_believed)
    }

    /// Where the vehicle is on the map up to now; `None` before the first node. It compares the place with those that are
    /// known, which takes longer than a revolution: ask when it matters.
    pub fn located(&self) -> Option<Located> {
        let ended = self.ended();
        let last = ended.last?;
        Some(Located {
            node: last.node,
            correction: ended.graph.poses[last.visit] * last.tracked.inverse(),
            visits: ended.graph.poses,
            map: ended.map,
        })
    }

    /// Standard deviation of a pose as tracked now, as seen from where the flight began, by the best way over the places that
    /// were visited since; `None` if that is not known.
    pub fn from_start_sd_m(&self, tracked: &Isometry2<f64>) -> Option<f64> {
        let place_m = Point2::from(tracked.translation.vector);
        let Some(last) = &self.last else { return self.doubt.from_start_sd_m(place_m) };
        let between_m = self.flown_to(last.visit).first()?.sd_m?;
        Some(self.first_sd_m? + between_m + self.doubt.since(&last.doubt)?.sd_m(place_m)?)
    }

    /// The visits up to now as a pose graph: their poses in the map's frame, and what was measured between them.
    pub fn pose_graph(&self) -> PoseGraph {
        self.ended().graph
    }

    fn ended(&self) -> Self {
        let mut ended = self.clone();
        ended.end_passing();
        ended.end_visit(self.in_node_ns, None);
        ended
    }

    /// How the poses that follow lie to those before is not known: the vehicle came to the next place by no way that is.
    fn end_stretch(&mut self) {
        self.end_passing();
        self.end_visit(self.in_node_ns, None);
        self.last = None;
        self.guesses.clear();
        self.strays.clear();
        self.way.begin_again();
        self.passed.clear();
    }

    /// Ends the visit to the place that the vehicle is passing, if there is any.
    fn end_passing(&mut self) {
        if let Some((open, left_to)) = self.passing.take() {
            let open = self.open.replace(open);
            self.end_visit(self.in_node_ns, Some(left_to));
            self.open = open;
        }
    }

    /// Ends the visit that is open, if there is any. `left_to`: where the vehicle is now, if it has left.
    fn end_visit(&mut self, last_ns: u64, left_to: Option<Isometry2<f64>>) {
        let Some(visit) = self.open.take().and_then(|open| open.end(last_ns, left_to)) else { return };
        // A flight may begin at the face of a dead end.
        if left_to.is_some() && self.last.is_some() && visit.passes_through_the_end() {
            return;
        }
        let predicted = match (&self.last, self.graph.poses.last()) {
            (Some(last), Some(corrected)) => corrected * last.tracked.inv_mul(&visit.anchor),
            _ => visit.anchor,
        };
        let stayed = self.last.as_ref().filter(|last| self.is_still_at(last, &visit, &predicted)).map(|last| last.node);
        // From a part of a junction, the rest of it may be out of view: it looks like a dead end.
        if stayed.is_some_and(|last| self.map.nodes[last].kind == HereKind::Junction && visit.kind == HereKind::DeadEnd)
        {
            return;
        }
        if left_to.is_some() && stayed.is_none() && self.is_a_pocket(&visit) {
            return;
        }
        let walls = Arc::new(Walls::new(&visit.outline));
        let number = self.graph.poses.len();
        self.graph.poses.push(predicted);
        if number == 0 {
            self.first_sd_m = self.began_doubt.from_start_sd_m(Point2::from(visit.anchor.translation.vector));
        }
        if let Some(last) = &self.last {
            let way_m = visit.reached_at_m - last.at_m;
            let measured = last.tracked.inv_mul(&visit.anchor);
            let information = information(0.1 + 0.03 * way_m.max(0.0), 0.02 + 0.001 * way_m.max(0.0));
            self.graph.edges.push(Edge { from: last.visit, to: number, measured, information });
            let heading_rad2 = self.began_doubt.since(&last.doubt).map_or(0.0, |since| since.heading_rad2());
            self.flown.push(Flown { is_measured: true, sd_m: self.flown_sd_m(last, &visit), heading_rad2 });
        } else if let Some(before) = number.checked_sub(1) {
            // Where the stretch lies is open, until one of its places is recognised.
            let measured = self.graph.poses[before].inv_mul(&predicted);
            let information = information(UNKNOWN_M, UNKNOWN_RAD);
            self.graph.edges.push(Edge { from: before, to: number, measured, information });
            self.flown.push(Flown { is_measured: false, sd_m: None, heading_rad2: 0.0 });
        }
        // Of a new node, this is one stay: it is no rival of the place that both may be.
        let found = self.recognise(&visit, &walls, &predicted, stayed.filter(|&last| self.is_new(last)));
        let node = match (found, stayed) {
            (Some((candidate, runner_up)), _) => {
                let node = self.merge(&visit, &candidate, runner_up, number);
                let node = match stayed.filter(|&last| last != node && self.is_new(last)) {
                    // The first part of this stay was not recognised.
                    Some(last) => self.absorb(last, node),
                    None => node,
                };
                self.reconsider(node)
            }
            (None, Some(node)) if self.map.nodes[node].kind == visit.kind => node,
            (None, Some(end)) if self.is_new(end) => {
                let node = self.add_node(&visit, walls, number);
                self.absorb(end, node)
            }
            (None, _) => self.add_node(&visit, walls, number),
        };
        let [first, this] = [self.places[node].first_visit, number].map(|visit| self.graph.poses[visit]);
        let turned_rad = first.inv_mul(&this).rotation.angle();
        self.map.nodes[node].visits.push(visit.time_ns);
        self.count_ways(node, &visit, turned_rad);
        self.connect(&visit, node, turned_rad, number, left_to.is_some());
    }

    /// Standard deviation of a visit's anchor as seen from that of the last one.
    pub(super) fn flown_sd_m(&self, last: &Departure, visit: &Visit) -> Option<f64> {
        let end = Point2::from(visit.anchor.translation.vector);
        self.began_doubt.since(&last.doubt)?.sd_m(end).map(|sd_m| sd_m.hypot(ANCHOR_M))
    }

    /// Notes the way by which the vehicle came, the passage that it came through, and the way by which it leaves.
    fn connect(&mut self, visit: &Visit, node: usize, turned_rad: f64, number: usize, left: bool) {
        // A flight may begin within its first node.
        let began_m = self.way.via.first().map_or(0.0, |(_, place_m)| (visit.anchor.inverse() * place_m).coords.norm());
        match self.last.take() {
            // The vehicle never left, or turned at once: of this stay, neither the end before nor this beginning is in a way.
            Some(last) if last.node == node && (!last.is_settled || Self::only_turned(&last, visit, node)) => {
                self.map.nodes[node].ways[last.way].taken = last.was_taken;
            }
            Some(last) => {
                let came_by = self.flown_way(node, visit.direction_rad(visit.came_from) + turned_rad);
                self.map.nodes[node].ways[came_by].taken = true;
                self.join(&last, visit, (node, came_by));
            }
            None if began_m > visit.came_from.coords.norm() + LEFT_M => {
                let came_by = self.flown_way(node, visit.direction_rad(visit.came_from) + turned_rad);
                self.map.nodes[node].ways[came_by].taken = true;
            }
            None => {}
        }
        let leaves_rad = visit.direction_rad(visit.left_to) + turned_rad;
        let leaves_by = nearest_way(&self.places[node].ways_rad, leaves_rad).unwrap_or(0);
        let was_taken = self.map.nodes[node].ways[leaves_by].taken;
        self.map.nodes[node].ways[leaves_by].taken |= left;
        self.way.widths_m = [0.0; 2];
        self.way.via.retain(|(way_m, _)| *way_m >= visit.left_at_m);
        let (look_m, tracked) = (visit.look_m, visit.anchor);
        let (at_m, left_ns) = (visit.left_at_m, visit.time_ns[1]);
        let (way, is_settled) = (leaves_by, false);
        let (doubt, mouths_m) = (self.in_node_doubt, visit.mouths_m());
        self.last = Some(Departure {
            node,
            way,
            was_taken,
            is_settled,
            has_middle: visit.has_middle,
            visit: number,
            look_m,
            tracked,
            at_m,
            left_ns,
            doubt,
            mouths_m,
        });
    }

    /// The way that the vehicle left the last node by is the one through which it gets beyond the look. A wide place may be
    /// no node any more while the vehicle still is in its middle.
    fn settle(&mut self, place_m: Point2<f64>) {
        let Some(last) = self.last.as_mut().filter(|last| !last.is_settled) else { return };
        let from_anchor = (last.tracked.inverse() * place_m).coords;
        if from_anchor.norm() < last.look_m {
            return;
        }
        last.is_settled = true;
        let node = last.node;
        let [first, this] = [self.places[node].first_visit, last.visit].map(|visit| self.graph.poses[visit]);
        let out = first.inv_mul(&this) * from_anchor;
        let way = self.flown_way(node, out.y.atan2(out.x));
        let ways = &mut self.map.nodes[node].ways;
        if let Some(last) = self.last.as_mut().filter(|last| last.way != way) {
            ways[last.way].taken = last.was_taken;
            ways[way].taken = true;
            last.way = way;
        }
    }
}

/// The way nearest to a direction.
pub(super) fn nearest_way(ways_rad: &[f64], direction_rad: f64) -> Option<usize> {
    let off_rad = |way: &usize| wrap_angle_rad(ways_rad[*way] - direction_rad).abs();
    (0..ways_rad.len()).min_by(|a, b| off_rad(a).total_cmp(&off_rad(b)))
}

/// Information of a measurement with these standard deviations.
pub(super) fn information(deviation_m: f64, deviation_rad: f64) -> Matrix3<f64> {
    let of = |deviation: f64| 1.0 / (deviation * deviation);
    Matrix3::from_diagonal(&Vector3::new(of(deviation_m), of(deviation_m), of(deviation_rad)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::{Node, NodeWay};

    /// Whether the way ahead of a junction counts as taken: the vehicle left by it, and was in the junction again this much of the
    /// way later.
    fn is_taken_after(way_m: f64) -> bool {
        let ways_rad = vec![0.0, 1.6, 3.1];
        let way = |&bearing_rad: &f64| NodeWay { bearing_rad, width_m: 4.0, taken: bearing_rad == 0.0, passage: None };
        let ways = ways_rad.iter().map(way).collect();
        let (position_m, tracked) = (Point2::origin(), Isometry2::identity());
        let mut mapper = Mapper::default();
        mapper.map.nodes = vec![Node { kind: HereKind::Junction, position_m, ways, visits: vec![[0, 1], [2, 3]] }];
        let (walls, belief) = (Arc::new(Walls::new(&[])), BTreeMap::new());
        mapper.places = vec![Place { walls, ways_rad: ways_rad.clone(), first_visit: 0, belief }];
        mapper.graph.poses = vec![tracked; 2];
        mapper.last = Some(Departure {
            node: 0,
            way: 0,
            was_taken: false,
            is_settled: true,
            has_middle: false,
            visit: 0,
            look_m: 5.0,
            tracked,
            at_m: 10.0,
            left_ns: 1,
            doubt: PoseDoubt::default(),
            mouths_m: Vec::new(),
        });
        let seen = |bearing_rad| crate::Way { bearing_rad, width_m: 4.0, opening: None };
        let visit = Visit {
            kind: HereKind::Junction,
            has_middle: false,
            time_ns: [2, 3],
            anchor: tracked,
            ways: ways_rad.into_iter().map(seen).collect(),
            look_m: 5.0,
            outline: Vec::new(),
            reached_at_m: 10.0 + way_m,
            left_at_m: 10.0 + way_m,
            belief: 10.0,
            came_from: Point2::new(-3.0, 0.0),
            left_to: Point2::new(0.0, 3.0),
        };
        mapper.connect(&visit, 0, 0.0, 1, true);
        mapper.map.nodes[0].ways[0].taken
    }

    #[test]
    fn a_way_is_not_taken_by_turning_at_once() {
        assert!(!is_taken_after(6.0));
        assert!(is_taken_after(40.0));
    }
}
