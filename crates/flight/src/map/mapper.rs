//! From visits to nodes: which visits are to one place, and what lies between.

use std::sync::Arc;

use crosscut_stage::{Frame, PoseDoubt};
use nalgebra::{Isometry2, Point2};

use super::Map;
use super::draft::{Departure, Draft, nearest_way};
use super::legs::{Leg, flown_to};
use super::outline::Walls;
use super::passed::Passed;
use super::visit::{OpenVisit, Visit};
use crate::line_points::line_points;
use crate::pose_graph::information;
use crate::{Constraint, FlightAnswer, HereKind, PoseGraph};

/// A visit to a junction has ended once the vehicle has moved this far in a passage: the place may be in doubt in between.
const LEFT_M: f64 = 1.0;

/// A visit to a dead end has ended once the vehicle has moved this far in a passage: then the side by which it leaves is certain.
const LEFT_DEAD_END_M: f64 = 5.0;

/// Standard deviation of the position of a stretch whose place is unknown.
const UNKNOWN_M: f64 = 1000.0;

/// Standard deviation of the heading of a stretch whose place is unknown.
const UNKNOWN_RAD: f64 = 3.0;

/// Makes the map of a flight from its frames, in order.
#[derive(Clone, Debug, Default)]
pub struct Mapper {
    pub(super) draft: Draft,
    open: Option<OpenVisit>,
    /// A visit that has ended at a place that was seen from its edge alone, until the vehicle is beyond it; and where the vehicle
    /// left to.
    seen_from_edge: Option<(OpenVisit, Isometry2<f64>)>,
    passed: Passed,
    /// Standard deviation of the first visit as seen from where the flight began; `None` if that is not known.
    first_sd_m: Option<f64>,
    /// When the vehicle was last in a node.
    in_node_ns: u64,
    /// The way of the flight when the vehicle was last in a node.
    in_node_at_m: f64,
    /// Doubt of the pose when the vehicle was last in a node.
    in_node_doubt: PoseDoubt,
    /// Doubt of the latest pose.
    doubt: PoseDoubt,
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
        self.draft.way.add(pose);
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
                    && (open.has_left_the_middle(self.draft.way.way_m) || open.has_turned_back(&place_m))
            }
            (None, _) if !is_known => true,
            (None, HereKind::DeadEnd) => self.draft.way.way_m - self.in_node_at_m > LEFT_DEAD_END_M,
            (None, _) => self.draft.way.way_m - self.in_node_at_m > LEFT_M,
        };
        let follows =
            node.is_some() && self.open.as_ref().is_some_and(|open| Some(open.kind()) == node && has_ended(open));
        if self.open.as_ref().is_some_and(has_ended) {
            let is_of_its_edge = |open: &mut OpenVisit| open.kind() == HereKind::Junction && !open.has_middle();
            let at_edge = self.open.take_if(|open| node.is_none() && is_known && is_of_its_edge(open));
            self.seen_from_edge = at_edge.map(|open| (open, pose));
            self.end_visit(self.in_node_ns, Some(pose));
        }
        let is_behind = |(open, _): &(OpenVisit, _)| node.is_some() || !is_known || open.is_behind(&pose);
        if self.seen_from_edge.as_ref().is_some_and(is_behind) {
            self.end_seen_from_edge();
        }
        let Some(seen) = &flown.here else { return };
        if let Some(node) = node {
            (self.in_node_ns, self.in_node_at_m) = (now_ns, self.draft.way.way_m);
            self.in_node_doubt = doubt;
            if self.open.is_none() {
                self.draft.began_doubt = doubt;
            }
            let came_from = self.draft.way.came_from();
            let last_m = self.draft.last.as_ref().map(|last| Point2::from(last.tracked.translation.vector));
            let follows = last_m.filter(|_| follows);
            let open = self.open.get_or_insert_with(|| OpenVisit::new(node, now_ns, came_from, follows));
            open.add(now_ns, pose, self.draft.way.way_m, seen, lines);
        } else if let Some(width_m) = seen.ways.iter().map(|way| way.width_m).min_by(f64::total_cmp) {
            self.draft.way.widths_m = [self.draft.way.widths_m[0] + width_m, self.draft.way.widths_m[1] + 1.0];
        }
    }

    /// The map up to now. A visit that has not ended counts.
    pub fn map(&self) -> Map {
        let mut ended = self.ended();
        for (passage, (visit, via_m)) in ended.draft.map.passages.iter_mut().zip(&ended.draft.courses) {
            passage.via_m = via_m.iter().map(|place_m| ended.draft.graph.poses[*visit] * place_m).collect();
        }
        ended.draft.map
    }

    /// Whether the vehicle is in a node, and has been there long enough for it to be believed.
    pub fn is_in_node(&self) -> bool {
        self.open.as_ref().is_some_and(OpenVisit::is_believed)
    }

    /// Where the vehicle is on the map up to now; `None` before the first node. It compares the place with those that are
    /// known, which takes longer than a revolution: ask when it matters.
    pub fn located(&self) -> Option<Located> {
        let ended = self.ended();
        let last = ended.draft.last?;
        Some(Located {
            node: last.node,
            correction: ended.draft.graph.poses[last.visit] * last.tracked.inverse(),
            visits: ended.draft.graph.poses,
            map: ended.draft.map,
        })
    }

    /// Standard deviation of a pose as tracked now, as seen from where the flight began, by the best way over the places that
    /// were visited since; `None` if that is not known.
    pub fn from_start_sd_m(&self, tracked: &Isometry2<f64>) -> Option<f64> {
        let place_m = Point2::from(tracked.translation.vector);
        let Some(last) = &self.draft.last else { return self.doubt.from_start_sd_m(place_m) };
        let between_m = flown_to(&self.draft.graph, &self.draft.flown, last.visit).first()?.sd_m?;
        Some(self.first_sd_m? + between_m + self.doubt.since(&last.doubt)?.sd_m(place_m)?)
    }

    /// The visits up to now as a pose graph: their poses in the map's frame, and what was measured between them.
    pub fn pose_graph(&self) -> PoseGraph {
        self.ended().draft.graph
    }

    fn ended(&self) -> Self {
        let mut ended = self.clone();
        ended.end_seen_from_edge();
        ended.end_visit(self.in_node_ns, None);
        ended
    }

    /// How the poses that follow lie to those before is not known: the vehicle came to the next place by no way that is.
    fn end_stretch(&mut self) {
        self.end_seen_from_edge();
        self.end_visit(self.in_node_ns, None);
        self.draft.last = None;
        self.draft.guesses.clear();
        self.draft.strays.clear();
        self.draft.way.begin_again();
        self.passed.clear();
    }

    /// Ends the visit to the place that the vehicle is passing, if there is any.
    fn end_seen_from_edge(&mut self) {
        if let Some((open, left_to)) = self.seen_from_edge.take() {
            let open = self.open.replace(open);
            self.end_visit(self.in_node_ns, Some(left_to));
            self.open = open;
        }
    }

    /// Ends the visit that is open, if there is any. `left_to`: where the vehicle is now, if it has left.
    fn end_visit(&mut self, last_ns: u64, left_to: Option<Isometry2<f64>>) {
        let Some(visit) = self.open.take().and_then(|open| open.end(last_ns, left_to)) else { return };
        // A flight may begin at the face of a dead end.
        if left_to.is_some() && self.draft.last.is_some() && visit.passes_through_the_end() {
            return;
        }
        let predicted = match (&self.draft.last, self.draft.graph.poses.last()) {
            (Some(last), Some(corrected)) => corrected * last.tracked.inv_mul(&visit.anchor),
            _ => visit.anchor,
        };
        let stayed = self
            .draft
            .last
            .as_ref()
            .filter(|last| self.draft.is_still_at(last, &visit, &predicted))
            .map(|last| last.node);
        // From a part of a junction, the rest of it may be out of view: it looks like a dead end.
        if stayed.is_some_and(|last| {
            self.draft.map.nodes[last].kind == HereKind::Junction && visit.kind == HereKind::DeadEnd
        }) {
            return;
        }
        if left_to.is_some() && stayed.is_none() && self.passed.is_a_pocket(&visit, self.draft.way.width_m()) {
            return;
        }
        let walls = Arc::new(Walls::new(&visit.outline));
        let number = self.draft.graph.poses.len();
        self.draft.graph.poses.push(predicted);
        if number == 0 {
            self.first_sd_m = self.draft.began_doubt.from_start_sd_m(Point2::from(visit.anchor.translation.vector));
        }
        if let Some(last) = &self.draft.last {
            let way_m = visit.reached_at_m - last.at_m;
            let measured = last.tracked.inv_mul(&visit.anchor);
            let information = information(0.1 + 0.03 * way_m.max(0.0), 0.02 + 0.001 * way_m.max(0.0));
            self.draft.graph.edges.push(Constraint { from: last.visit, to: number, measured, information });
            let heading_rad2 = self.draft.began_doubt.since(&last.doubt).map_or(0.0, |since| since.heading_rad2());
            self.draft.flown.push(Leg { is_measured: true, sd_m: self.draft.flown_sd_m(last, &visit), heading_rad2 });
        } else if let Some(before) = number.checked_sub(1) {
            // Where the stretch lies is open, until one of its places is recognised.
            let measured = self.draft.graph.poses[before].inv_mul(&predicted);
            let information = information(UNKNOWN_M, UNKNOWN_RAD);
            self.draft.graph.edges.push(Constraint { from: before, to: number, measured, information });
            self.draft.flown.push(Leg { is_measured: false, sd_m: None, heading_rad2: 0.0 });
        }
        // Of a new node, this is one stay: it is no rival of the place that both may be.
        let found = self.draft.recognise(&visit, &walls, &predicted, stayed.filter(|&last| self.draft.is_new(last)));
        let node = match (found, stayed) {
            (Some((candidate, runner_up)), _) => {
                let node = self.draft.merge(&visit, &candidate, runner_up, number);
                let node = match stayed.filter(|&last| last != node && self.draft.is_new(last)) {
                    // The first part of this stay was not recognised.
                    Some(last) => self.draft.absorb(last, node),
                    None => node,
                };
                self.draft.reconsider(node)
            }
            (None, Some(node)) if self.draft.map.nodes[node].kind == visit.kind => node,
            (None, Some(end)) if self.draft.is_new(end) => {
                let node = self.draft.add_node(&visit, walls, number);
                self.draft.absorb(end, node)
            }
            (None, _) => self.draft.add_node(&visit, walls, number),
        };
        let [first, this] = [self.draft.places[node].first_visit, number].map(|visit| self.draft.graph.poses[visit]);
        let turned_rad = first.inv_mul(&this).rotation.angle();
        self.draft.map.nodes[node].visits.push(visit.time_ns);
        self.draft.count_ways(node, &visit, turned_rad);
        self.connect(&visit, node, turned_rad, number, left_to.is_some());
    }

    /// Notes the way by which the vehicle came, the passage that it came through, and the way by which it leaves.
    fn connect(&mut self, visit: &Visit, node: usize, turned_rad: f64, number: usize, left: bool) {
        // A flight may begin within its first node.
        let began_m =
            self.draft.way.via.first().map_or(0.0, |(_, place_m)| (visit.anchor.inverse() * place_m).coords.norm());
        match self.draft.last.take() {
            // The vehicle never left, or turned at once: of this stay, neither the end before nor this beginning is in a way.
            Some(last) if last.node == node && (!last.is_settled || Draft::only_turned(&last, visit, node)) => {
                self.draft.map.nodes[node].ways[last.way].taken = last.was_taken;
            }
            Some(last) => {
                let came_by = self.draft.flown_way(node, visit.direction_rad(visit.came_from) + turned_rad);
                self.draft.map.nodes[node].ways[came_by].taken = true;
                self.draft.join(&last, visit, (node, came_by));
            }
            None if began_m > visit.came_from.coords.norm() + LEFT_M => {
                let came_by = self.draft.flown_way(node, visit.direction_rad(visit.came_from) + turned_rad);
                self.draft.map.nodes[node].ways[came_by].taken = true;
            }
            None => {}
        }
        let leaves_rad = visit.direction_rad(visit.left_to) + turned_rad;
        let leaves_by = nearest_way(&self.draft.places[node].ways_rad, leaves_rad).unwrap_or(0);
        let was_taken = self.draft.map.nodes[node].ways[leaves_by].taken;
        self.draft.map.nodes[node].ways[leaves_by].taken |= left;
        self.draft.way.widths_m = [0.0; 2];
        self.draft.way.via.retain(|(way_m, _)| *way_m >= visit.left_at_m);
        let (look_m, tracked) = (visit.look_m, visit.anchor);
        let (at_m, left_ns) = (visit.left_at_m, visit.time_ns[1]);
        let (way, is_settled) = (leaves_by, false);
        let (doubt, mouths_m) = (self.in_node_doubt, visit.mouths_m());
        self.draft.last = Some(Departure {
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
        let Some(last) = self.draft.last.as_mut().filter(|last| !last.is_settled) else { return };
        let from_anchor = (last.tracked.inverse() * place_m).coords;
        if from_anchor.norm() < last.look_m {
            return;
        }
        last.is_settled = true;
        let node = last.node;
        let [first, this] =
            [self.draft.places[node].first_visit, last.visit].map(|visit| self.draft.graph.poses[visit]);
        let out = first.inv_mul(&this) * from_anchor;
        let way = self.draft.flown_way(node, out.y.atan2(out.x));
        let ways = &mut self.draft.map.nodes[node].ways;
        if let Some(last) = self.draft.last.as_mut().filter(|last| last.way != way) {
            ways[last.way].taken = last.was_taken;
            ways[way].taken = true;
            last.way = way;
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::map::draft::NodeMemory;
    use crate::map::{Node, NodeWay};

    /// Whether the way ahead of a junction counts as taken: the vehicle left by it, and was in the junction again this much of the
    /// way later.
    fn is_taken_after(way_m: f64) -> bool {
        let ways_rad = vec![0.0, 1.6, 3.1];
        let way = |&bearing_rad: &f64| NodeWay { bearing_rad, width_m: 4.0, taken: bearing_rad == 0.0, passage: None };
        let ways = ways_rad.iter().map(way).collect();
        let (position_m, tracked) = (Point2::origin(), Isometry2::identity());
        let mut mapper = Mapper::default();
        mapper.draft.map.nodes =
            vec![Node { kind: HereKind::Junction, position_m, ways, visits: vec![[0, 1], [2, 3]] }];
        let (walls, belief) = (Arc::new(Walls::new(&[])), BTreeMap::new());
        mapper.draft.places = vec![NodeMemory { walls, ways_rad: ways_rad.clone(), first_visit: 0, belief }];
        mapper.draft.graph.poses = vec![tracked; 2];
        mapper.draft.last = Some(Departure {
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
        mapper.draft.map.nodes[0].ways[0].taken
    }

    #[test]
    fn a_way_is_not_taken_by_turning_at_once() {
        assert!(!is_taken_after(6.0));
        assert!(is_taken_after(40.0));
    }
}
