//! From frames to visits, and from visits to the log: which of them are to one place, and what lies between.

use crosscut_stage::{Frame, PoseDoubt};
use nalgebra::{Isometry2, Point2};

use super::Map;
use super::derived::Derived;
use super::legs::flown_to;
use super::log::Log;
use super::passed::Passed;
use super::reconsider::reconsider;
use super::stay::is_still_at;
use super::stretch::Guesses;
use super::travelled::Travelled;
use super::visit::{LEFT_M, Moment, OpenVisit};
use crate::line_points::line_points;
use crate::{FlightAnswer, HereKind, PoseGraph};

/// Makes the map of a flight from its frames, in order.
#[derive(Clone, Debug, Default)]
pub struct Mapper {
    pub(super) log: Log,
    open: Option<OpenVisit>,
    /// A visit to a junction that has ended, until the vehicle is beyond what was seen of the place; and where it left to.
    left: Option<(OpenVisit, Isometry2<f64>)>,
    way: Travelled,
    passed: Passed,
    guesses: Guesses,
    /// Doubt of the latest pose.
    doubt: PoseDoubt,
}

/// Where the vehicle is on the map.
#[derive(Clone, Debug)]
pub struct Located {
    /// The map.
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
        let doubt = flown.doubt.unwrap_or_default();
        if doubt.stretch != self.doubt.stretch {
            self.end_stretch();
        }
        if doubt.stretch != self.doubt.stretch || self.log.stretches_from_ns.is_empty() {
            self.log.stretches_from_ns.push(frame.revolution.stamp_ns);
        }
        self.doubt = doubt;
        self.way.add(pose);
        let lines = || {
            let mut points = Vec::new();
            line_points(&frame.revolution.points_m, 1, &mut points);
            points
        };
        self.passed.add(pose, lines);
        let now = Moment { stamp_ns: frame.revolution.stamp_ns, pose, doubt, way_m: self.way.way_m };
        self.log.flies(now.place_m(), &self.way);
        let node = steady.node();
        let mut follows = false;
        if let Some(open) = self.open.take_if(|open| open.has_ended(&now, node)) {
            follows = node == Some(open.kind());
            if node.is_none() && open.is_known_at(&now) && open.kind() == HereKind::Junction {
                self.left = Some((open, pose));
            } else {
                self.end_visit(open, Some(pose));
            }
        }
        let is_behind =
            |(open, _): &mut (OpenVisit, _)| node.is_some() || !open.is_known_at(&now) || open.is_behind(&pose);
        if let Some((open, left_to)) = self.left.take_if(is_behind) {
            self.end_visit(open, Some(left_to));
        }
        let Some(seen) = &flown.here else { return };
        if let Some(node) = node {
            let last = self.log.last().filter(|_| follows);
            let follows = last.map(|last| Point2::from(self.log.visits[last].anchor.translation.vector));
            let came_from = self.way.came_from();
            self.open.get_or_insert_with(|| OpenVisit::new(node, now, came_from, follows)).add(now, seen, lines);
        } else if let Some(width_m) = seen.ways.iter().map(|way| way.width_m).min_by(f64::total_cmp) {
            self.way.add_width(width_m);
        }
    }

    /// The map up to now. A visit that has not ended counts.
    pub fn map(&self) -> Map {
        Derived::of(&self.ended()).map
    }

    /// Whether the vehicle is in a node, and has been there long enough for it to be believed.
    pub fn is_in_node(&self) -> bool {
        self.open.as_ref().is_some_and(OpenVisit::is_believed)
    }

    /// Where the vehicle is on the map up to now; `None` before the first node. It compares the place with those that
    /// are known, which takes longer than a revolution: ask when it matters.
    pub fn located(&self) -> Option<Located> {
        let log = self.ended();
        let last = log.last()?;
        let Derived { map, node_of, .. } = Derived::of(&log);
        let correction = log.graph.poses[last] * log.visits[last].anchor.inverse();
        Some(Located { map, node: node_of[last], correction, visits: log.graph.poses })
    }

    /// Standard deviation of a pose as tracked now, as seen from where the flight began, by the best way over the
    /// places that were visited since; `None` if that is not known.
    pub fn from_start_sd_m(&self, tracked: &Isometry2<f64>) -> Option<f64> {
        let place_m = Point2::from(tracked.translation.vector);
        let Some(last) = self.log.last() else { return self.doubt.from_start_sd_m(place_m) };
        let [first, latest] = [0, last].map(|visit| &self.log.visits[visit]);
        let first_sd_m = first.doubts[0].from_start_sd_m(Point2::from(first.anchor.translation.vector))?;
        let between_m = flown_to(&self.log, last).first()?.sd_m?;
        Some(first_sd_m + between_m + self.doubt.since(&latest.doubts[1])?.sd_m(place_m)?)
    }

    /// The visits up to now as a pose graph: their poses in the map's frame, and what was measured between them.
    pub fn pose_graph(&self) -> PoseGraph {
        self.ended().graph
    }

    /// The log as it were if the visits that have not ended had.
    fn ended(&self) -> Log {
        let mut ended = self.clone();
        ended.end_visits();
        ended.log
    }

    fn end_visits(&mut self) {
        if let Some((open, left_to)) = self.left.take() {
            self.end_visit(open, Some(left_to));
        }
        if let Some(open) = self.open.take() {
            self.end_visit(open, None);
        }
    }

    /// How the poses that follow lie to those before is not known: the vehicle came to the next place by no way that
    /// is.
    fn end_stretch(&mut self) {
        self.end_visits();
        self.log.is_cut = true;
        self.guesses = Guesses::default();
        self.way.begin_again();
        self.passed.clear();
    }

    /// Ends a visit, and decides to which place it was. `left_to`: where the vehicle is now, if it has left.
    fn end_visit(&mut self, open: OpenVisit, left_to: Option<Isometry2<f64>>) {
        let Some(mut visit) = open.end(left_to) else { return };
        let last = self.log.last();
        // A flight may begin at the face of a dead end.
        if left_to.is_some() && last.is_some() && visit.passes_through_the_end() {
            return;
        }
        let known = Derived::of(&self.log);
        let kind_of = |node: usize| known.map.nodes[node].kind;
        let stayed = last.map(|last| known.node_of[last]);
        let stayed = stayed.filter(|&node| is_still_at(&self.log, kind_of(node), &visit, &self.way));
        // From a part of a junction, the rest of it may be out of view: it looks like a dead end.
        let is_part = |node: usize| kind_of(node) == HereKind::Junction && visit.kind == HereKind::DeadEnd;
        if stayed.is_some_and(is_part) {
            return;
        }
        if left_to.is_some() && stayed.is_none() && self.passed.is_a_pocket(&visit, self.way.width_m()) {
            return;
        }
        visit.has_come = self.way.began_m(&visit) > visit.came_from.coords.norm() + LEFT_M;
        let (kind, number) = (visit.kind, self.log.visits.len());
        self.log.visit(visit, left_to.is_some());
        // Of a new node, this is one stay: it is no rival of the place that both may be.
        let new = stayed.filter(|&node| known.is_new(node));
        let seen_again = self.guesses.recognise(&mut self.log, &known, new);
        if let Some(last) = last {
            self.log.legs[last].is_stay = match seen_again {
                // The first part of this stay was not recognised.
                Some(node) => new.is_some_and(|stayed| stayed != node),
                None => new.is_some() || stayed.is_some_and(|node| kind_of(node) == kind),
            };
        }
        if seen_again.is_some() {
            reconsider(&mut self.log);
        }
        if let Some(last) = last {
            self.log.reach(last, &self.way);
        }
        self.way.begin_at(&self.log.visits[number]);
    }
}
