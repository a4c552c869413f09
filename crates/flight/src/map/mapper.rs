//! From visits to nodes: which visits are to one place, and what lies between.

use std::f64::consts::PI;

use nalgebra::{Isometry2, Matrix3, Point2, Vector3};

use crosscut_stage::{Frame, HereKind, Way, wrap_angle_rad};

use crate::line_points::line_points;
use crate::{Edge, PoseGraph};

use super::outline::{Fit, Walls};
use super::travelled::Travelled;
use super::visit::{OpenVisit, Visit};
use super::{Map, Merge, Node, NodeWay, Passage};

/// Poses are known to within this, and a share of the way since the place was seen.
const DRIFT_M: f64 = 2.5;
const DRIFT_SHARE: f64 = 0.06;

/// Headings are known to within this, and by this much less for each metre of the way since.
const DRIFT_RAD: f64 = 0.15;
const DRIFT_RAD_PER_M: f64 = 0.003;

/// The directions of the ways of one place agree to within this.
const WAYS_APART_RAD: f64 = 0.6;

/// Outlines of one place lie on each other by this share of their line points, and by this much better than on any other place.
const LEAST_SHARE: f64 = 0.72;
const LEAST_LEAD: f64 = 0.08;

/// Two fits on one node that differ by less are the same.
const SAME_M: f64 = 1.5;
const SAME_RAD: f64 = 0.4;

/// A visit has ended once the vehicle has moved this far in a passage: the place may be in doubt in between.
const LEFT_M: f64 = 2.0;

/// Between two visits of one node, a passage is longer than this.
const TURN_M: f64 = 8.0;

/// Two visits in a row are one stay if they are nearer to each other than this many looks, and the way is no longer
/// than WANDERS of them.
const NEAR_LOOKS: f64 = 1.2;
const WANDERS: f64 = 1.5;

/// Makes the map of a flight from its frames, in order.
#[derive(Clone, Debug, Default)]
pub struct Mapper {
    map: Map,
    open: Option<OpenVisit>,
    /// Each visit's anchor, and what was measured between them. Poses are corrected, measurements are not.
    graph: PoseGraph,
    /// What is kept of each node to recognise it.
    places: Vec<Place>,
    /// Of each passage: the visit from which it was entered first, and places along it in the frame of that anchor.
    courses: Vec<(usize, Vec<Point2<f64>>)>,
    last: Option<Departure>,
    way: Travelled,
    /// When the vehicle was last in a node, and the way then.
    in_node_ns: u64,
    in_node_at_m: f64,
}

/// Where the vehicle is on the map.
#[derive(Clone, Debug)]
pub struct Located {
    /// The map; its passages have no courses.
    pub map: Map,
    /// The node that the vehicle is in, or was in last.
    pub node: usize,
    /// The vehicle is in that node, and was there long enough for it to be believed.
    pub is_there: bool,
    /// Brings poses as they are tracked now into the frame of the map.
    pub correction: Isometry2<f64>,
}

/// What is kept of a node to recognise it.
#[derive(Clone, Debug)]
struct Place {
    walls: Walls,
    /// Directions of its ways in the frame of its first visit.
    ways_rad: Vec<f64>,
    first_visit: usize,
    /// The way at the last visit, metres since the start.
    seen_at_m: f64,
}

/// How the vehicle left the last node.
#[derive(Clone, Copy, Debug)]
struct Departure {
    node: usize,
    way: usize,
    visit: usize,
    look_m: f64,
    /// The anchor as it was tracked.
    tracked: Isometry2<f64>,
    at_m: f64,
    left_ns: u64,
}

/// A place that a visit may be to.
struct Candidate {
    node: usize,
    fit: Fit,
}

impl Mapper {
    /// Takes the next frame, with its pose and its steady place. A frame without a pose is passed over.
    pub fn add(&mut self, frame: &Frame) {
        let (Some(pose), Some(steady)) = (frame.pose, frame.steady.as_ref().and_then(|steady| steady.here.as_ref()))
        else {
            return;
        };
        let now_ns = frame.revolution.stamp_ns;
        self.way.add(pose);
        let is_node = matches!(steady.kind, HereKind::Junction | HereKind::DeadEnd);
        let has_ended = |open: &OpenVisit| match is_node {
            true => open.kind() != steady.kind,
            false => self.way.way_m - self.in_node_at_m > LEFT_M,
        };
        if self.open.as_ref().is_some_and(has_ended) {
            self.end_visit(self.in_node_ns, true);
        }
        let Some(seen) = &frame.here else { return };
        if is_node {
            (self.in_node_ns, self.in_node_at_m) = (now_ns, self.way.way_m);
            let open = self.open.get_or_insert_with(|| OpenVisit::new(steady.kind, now_ns));
            open.add(pose, seen, || {
                let mut points = Vec::new();
                line_points(&frame.revolution.points_m, &mut points);
                points
            });
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

    /// Where the vehicle is on the map up to now; `None` before the first node.
    pub fn located(&self) -> Option<Located> {
        let ended = self.ended();
        let last = ended.last?;
        Some(Located {
            node: last.node,
            is_there: ended.graph.poses.len() > self.graph.poses.len(),
            correction: ended.graph.poses[last.visit] * last.tracked.inverse(),
            map: ended.map,
        })
    }

    /// The visits up to now as a pose graph: their poses in the map's frame, and what was measured between them.
    pub fn pose_graph(&self) -> PoseGraph {
        self.ended().graph
    }

    fn ended(&self) -> Self {
        let mut ended = self.clone();
        ended.end_visit(self.in_node_ns, false);
        ended
    }

    /// Ends the visit that is open, if there is any; `left`: the vehicle is no longer there.
    fn end_visit(&mut self, last_ns: u64, left: bool) {
        let Some(visit) = self.open.take().and_then(|open| open.end(last_ns)) else { return };
        // A flight may begin at the face of a dead end.
        if left && self.last.is_some() && visit.passes_through_the_end() {
            return;
        }
        let predicted = match (&self.last, self.graph.poses.last()) {
            (Some(last), Some(corrected)) => corrected * last.tracked.inv_mul(&visit.anchor),
            _ => visit.anchor,
        };
        let walls = Walls::new(&visit.outline);
        let number = self.graph.poses.len();
        self.graph.poses.push(predicted);
        if let Some(last) = self.last {
            let way_m = self.way.way_m - last.at_m;
            let measured = last.tracked.inv_mul(&visit.anchor);
            let information = information(0.1 + 0.03 * way_m, 0.02 + 0.001 * way_m);
            self.graph.edges.push(Edge { from: last.visit, to: number, measured, information });
        }
        let found = self.recognise(&visit, &walls, &predicted);
        let stayed = self.last.filter(|last| found.is_none() && self.is_still_at(last, &visit, &predicted));
        let (node, turned_rad) = match (&found, stayed) {
            (Some((candidate, _)), _) => (candidate.node, candidate.fit.pose.rotation.angle()),
            (None, Some(Departure { node, .. })) => {
                let first = self.graph.poses[self.places[node].first_visit];
                (node, first.inv_mul(&predicted).rotation.angle())
            }
            (None, None) => (self.add_node(&visit, walls, number), 0.0),
        };
        if let Some((candidate, runner_up)) = found {
            self.merge(&visit, &candidate, runner_up, number);
        }
        self.places[node].seen_at_m = self.way.way_m;
        self.map.nodes[node].visits.push(visit.time_ns);
        self.connect(&visit, node, turned_rad, number, left);
    }

    /// Whether the vehicle is still at the node that it left last: a place is what lies within the look, and the two looks
    /// are of much the same space.
    fn is_still_at(&self, last: &Departure, visit: &Visit, predicted: &Isometry2<f64>) -> bool {
        let apart = self.graph.poses[last.visit].inv_mul(predicted);
        let look_m = last.look_m.min(visit.look_m);
        let is_alike = self.map.nodes[last.node].kind == visit.kind;
        is_alike
            && apart.translation.vector.norm() < NEAR_LOOKS * look_m
            && self.way.way_m - last.at_m < WANDERS * look_m
    }

    fn add_node(&mut self, visit: &Visit, walls: Walls, number: usize) -> usize {
        let way =
            |way: &Way| NodeWay { bearing_rad: way.bearing_rad, width_m: way.width_m, taken: false, passage: None };
        self.map.nodes.push(Node {
            kind: visit.kind,
            position_m: Point2::origin(),
            ways: visit.ways.iter().map(way).collect(),
            visits: Vec::new(),
        });
        self.places.push(Place {
            walls,
            ways_rad: visit.ways.iter().map(|way| way.bearing_rad).collect(),
            first_visit: number,
            seen_at_m: 0.0,
        });
        self.place_nodes();
        self.map.nodes.len() - 1
    }

    /// The node that a visit is to, and the share of the runner-up; `None` if it is to none, or if two are alike.
    fn recognise(&self, visit: &Visit, walls: &Walls, predicted: &Isometry2<f64>) -> Option<(Candidate, Option<f64>)> {
        let mut candidates: Vec<Candidate> = Vec::new();
        for (node, place) in self.places.iter().enumerate() {
            let known = &self.map.nodes[node];
            if known.kind != visit.kind {
                continue;
            }
            let since_m = self.way.way_m - place.seen_at_m;
            let apart = self.graph.poses[place.first_visit].inv_mul(predicted);
            if apart.translation.vector.norm() > DRIFT_M + DRIFT_SHARE * since_m {
                continue;
            }
            let yaw_off_rad = (DRIFT_RAD + DRIFT_RAD_PER_M * since_m).min(PI);
            // A way may have been missed on one of the visits: then the walls alone tell.
            let predicted_rad = apart.rotation.angle();
            let is_likely = |yaw_rad: &f64| wrap_angle_rad(yaw_rad - predicted_rad).abs() <= yaw_off_rad;
            let turns = (0..visit.ways.len()).filter_map(|shift| turn_rad(visit, &place.ways_rad, shift));
            for yaw_rad in turns.filter(is_likely).chain([predicted_rad]) {
                candidates.extend(place.walls.fit(walls, yaw_rad).map(|fit| Candidate { node, fit }));
            }
        }
        candidates.sort_by(|a, b| b.fit.share.total_cmp(&a.fit.share));
        let mut candidates = candidates.into_iter();
        let best = candidates.next().filter(|best| best.fit.share >= LEAST_SHARE)?;
        let runner_up = candidates.find(|other| other.is_elsewhere(&best)).map(|other| other.fit.share);
        let leads = runner_up.is_none_or(|share| best.fit.share - share >= LEAST_LEAD);
        leads.then_some((best, runner_up))
    }

    /// Takes a visit to be to a known node, and corrects all poses by it.
    fn merge(&mut self, visit: &Visit, candidate: &Candidate, runner_up: Option<f64>, number: usize) {
        let Candidate { node, fit, .. } = candidate;
        let from = self.places[*node].first_visit;
        let before = self.graph.poses[number];
        self.graph.edges.push(Edge { from, to: number, measured: fit.pose, information: information(0.1, 0.02) });
        // Every pose is joined to the one before, so that the edges determine all of them.
        self.graph.solve().ok();
        self.place_nodes();
        let off_m = (before.translation.vector - self.graph.poses[number].translation.vector).norm();
        let second = runner_up.map_or_else(String::new, |share| format!(", on the next likely place by {share:.2}"));
        self.map.merges.push(Merge {
            node: *node,
            at_ns: visit.time_ns[1],
            score: fit.share,
            runner_up,
            why: format!(
                "its walls lie on those of node {node} by {:.2}{second}; the drift was {off_m:.1} m",
                fit.share
            ),
        });
    }

    /// Nodes lie where their first visit does, and their ways as they were seen then.
    fn place_nodes(&mut self) {
        for (node, place) in self.map.nodes.iter_mut().zip(&self.places) {
            let pose = self.graph.poses[place.first_visit];
            node.position_m = Point2::from(pose.translation.vector);
            for (way, &bearing_rad) in node.ways.iter_mut().zip(&place.ways_rad) {
                way.bearing_rad = wrap_angle_rad(bearing_rad + pose.rotation.angle());
            }
        }
    }

    /// Notes the way by which the vehicle came, the passage that it came through, and the way by which it leaves.
    fn connect(&mut self, visit: &Visit, node: usize, turned_rad: f64, number: usize, left: bool) {
        let ways_rad = &self.places[node].ways_rad;
        let way_of = |place_m: Point2<f64>| {
            let direction_rad = visit.ways[visit.way_to(place_m)].bearing_rad + turned_rad;
            let off_rad = |way: &usize| wrap_angle_rad(ways_rad[*way] - direction_rad).abs();
            (0..ways_rad.len()).min_by(|a, b| off_rad(a).total_cmp(&off_rad(b))).unwrap_or(0)
        };
        let (came_by, leaves_by) = (way_of(visit.came_from), way_of(visit.left_to));
        // A flight may begin within its first node.
        let began_m = self.way.via_m.first().map_or(0.0, |place_m| (visit.anchor.inverse() * place_m).coords.norm());
        if self.last.is_some() || began_m > visit.came_from.coords.norm() + LEFT_M {
            self.map.nodes[node].ways[came_by].taken = true;
        }
        if let Some(last) = self.last {
            let [from, to] = [(last.node, last.way), (node, came_by)];
            let known = [from, to].map(|(node, way)| self.map.nodes[node].ways[way].passage);
            let is_turn = from.0 == to.0 && self.way.way_m - last.at_m < TURN_M.max(WANDERS * visit.look_m);
            if known == [None, None] && from != to && !is_turn {
                let passage = self.map.passages.len();
                let length_m = self.way.way_m - last.at_m;
                let width_m = self.way.widths_m[0] / self.way.widths_m[1].max(1.0);
                let stretch_ns = [last.left_ns, visit.time_ns[0]];
                let (from_node, to_node, via_m) = (from.0, to.0, Vec::new());
                self.map.passages.push(Passage { from: from_node, to: to_node, length_m, width_m, stretch_ns, via_m });
                let to_anchor = last.tracked.inverse();
                let via_m = self.way.via_m.iter().map(|place_m| to_anchor * place_m).collect();
                self.courses.push((last.visit, via_m));
                for (node, way) in [from, to] {
                    self.map.nodes[node].ways[way].passage = Some(passage);
                }
            }
        }
        self.map.nodes[node].ways[leaves_by].taken |= left;
        self.way.widths_m = [0.0; 2];
        self.way.via_m.clear();
        let (look_m, tracked) = (visit.look_m, visit.anchor);
        let (at_m, left_ns) = (self.way.way_m, visit.time_ns[1]);
        self.last = Some(Departure { node, way: leaves_by, visit: number, look_m, tracked, at_m, left_ns });
    }
}

impl Candidate {
    /// It is another place than `other`, or the same one turned.
    fn is_elsewhere(&self, other: &Self) -> bool {
        let apart = self.fit.pose.inv_mul(&other.fit.pose);
        let is_same = apart.rotation.angle().abs() < SAME_RAD && apart.translation.vector.norm() < SAME_M;
        self.node != other.node || !is_same
    }
}

/// The turn that brings the ways of a visit onto those of a node, way i onto way i + `shift`; `None` if they do not
/// agree.
fn turn_rad(visit: &Visit, ways_rad: &[f64], shift: usize) -> Option<f64> {
    let ways = visit.ways.len();
    if ways != ways_rad.len() {
        return None;
    }
    let off_rad = |i: usize| ways_rad[(i + shift) % ways] - visit.ways[i].bearing_rad;
    let first_rad = off_rad(0);
    let mean_rad = first_rad + (0..ways).map(|i| wrap_angle_rad(off_rad(i) - first_rad)).sum::<f64>() / ways as f64;
    let agree = (0..ways).all(|i| wrap_angle_rad(off_rad(i) - mean_rad).abs() <= WAYS_APART_RAD);
    agree.then(|| wrap_angle_rad(mean_rad))
}

/// Information of a measurement with these standard deviations.
fn information(deviation_m: f64, deviation_rad: f64) -> Matrix3<f64> {
    let of = |deviation: f64| 1.0 / (deviation * deviation);
    Matrix3::from_diagonal(&Vector3::new(of(deviation_m), of(deviation_m), of(deviation_rad)))
}
