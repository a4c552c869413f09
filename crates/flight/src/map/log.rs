//! What a flight has shown of its places: visits, what was flown between them, and which of them are to one place. A
//! log only grows; places, ways and passages are derived from the log.

use nalgebra::{Isometry2, Point2, Vector2};

use super::Decided;
use super::outline::Fit;
use super::travelled::Travelled;
use super::visit::Visit;
use crate::pose_graph::information;
use crate::{Constraint, PoseGraph};

/// Where an anchor lies in its place, standard deviation.
const ANCHOR_M: f64 = 0.1;

/// Standard deviation of the position of a stretch whose place is unknown.
const UNKNOWN_M: f64 = 1000.0;

/// Standard deviation of the heading of a stretch whose place is unknown.
const UNKNOWN_RAD: f64 = 3.0;

/// What a flight has shown of its places.
#[derive(Clone, Debug, Default)]
pub(super) struct Log {
    /// Visits, in order.
    pub(super) visits: Vec<Visit>,
    /// How the vehicle left each visit. The last leg is under way, or led to no visit.
    pub(super) legs: Vec<Leg>,
    /// Visits that were taken to be to one place.
    pub(super) links: Vec<Link>,
    /// Visits that look alike and were not taken to be to one place.
    pub(super) refusals: Vec<Link>,
    /// Each visit's anchor, and what was measured between them. Poses are corrected, measurements are not.
    pub(super) graph: PoseGraph,
    /// How well each edge of the graph is known.
    pub(super) known: Vec<Known>,
    /// The poses that follow do not go with those before.
    pub(super) is_cut: bool,
    /// The stamp at which each stretch begins.
    pub(super) stretches_from_ns: Vec<u64>,
}

/// How the vehicle left a visit, and how it came to the next one.
#[derive(Clone, Debug, Default)]
pub(super) struct Leg {
    /// The visit ended because the vehicle left.
    pub(super) has_left: bool,
    /// Where the vehicle was first beyond the look, in the frame of the anchor: a wide place may be no node any more
    /// while the vehicle still is in its middle.
    pub(super) beyond_m: Option<Vector2<f64>>,
    /// Mean width of what was flown through.
    pub(super) width_m: Option<f64>,
    /// Places along the leg, in the frame of the anchor.
    pub(super) via_m: Vec<Point2<f64>>,
    /// Its length, if it led to the next visit.
    pub(super) length_m: Option<f64>,
    /// The next visit is a part of the same stay.
    pub(super) is_stay: bool,
}

/// A decision on two visits: the earlier one, and the one that was compared with that.
#[derive(Clone, Debug)]
pub(super) struct Link {
    pub(super) visits: [usize; 2],
    /// With the node's number as it was then.
    pub(super) decided: Decided,
}

/// How well an edge of the graph is known.
#[derive(Clone, Copy, Debug)]
pub(super) struct Known {
    /// Not so between two stretches.
    pub(super) is_measured: bool,
    /// Standard deviation of where the edge leads; `None` if that is not known.
    pub(super) sd_m: Option<f64>,
    /// Variance of the heading there.
    pub(super) heading_rad2: f64,
}

/// Standard deviation of a visit's anchor as seen from that of the visit before.
pub(super) fn flown_sd_m(from: &Visit, to: &Visit) -> Option<f64> {
    let end = Point2::from(to.anchor.translation.vector);
    to.doubts[0].since(&from.doubts[1])?.sd_m(end).map(|sd_m| sd_m.hypot(ANCHOR_M))
}

impl Log {
    /// The latest visit, if how poses lie to it is known.
    pub(super) fn last(&self) -> Option<usize> {
        self.visits.len().checked_sub(1).filter(|_| !self.is_cut)
    }

    /// Where a tracked pose is by the latest visit.
    pub(super) fn placed(&self, tracked: &Isometry2<f64>) -> Isometry2<f64> {
        self.last().map_or(*tracked, |last| self.graph.poses[last] * self.visits[last].anchor.inv_mul(tracked))
    }

    /// By how much a visit is turned as seen from another one.
    pub(super) fn turned_rad(&self, from: usize, visit: usize) -> f64 {
        self.graph.poses[from].inv_mul(&self.graph.poses[visit]).rotation.angle()
    }

    /// Adds a visit.
    pub(super) fn visit(&mut self, visit: Visit, has_left: bool) {
        let (number, anchor) = (self.visits.len(), self.placed(&visit.anchor));
        let (edge, known) = match (self.last(), self.graph.poses.last()) {
            (Some(last), _) => {
                let last = &self.visits[last];
                let way_m = (visit.reached_at_m - last.left_at_m).max(0.0);
                let information = information(0.1 + 0.03 * way_m, 0.02 + 0.001 * way_m);
                let heading_rad2 = visit.doubts[0].since(&last.doubts[1]).map_or(0.0, |since| since.heading_rad2());
                let known = Known { is_measured: true, sd_m: flown_sd_m(last, &visit), heading_rad2 };
                (Some((last.anchor.inv_mul(&visit.anchor), information)), known)
            }
            // Where the stretch lies is open, until one of its places is recognised.
            (None, before) => {
                let edge = before.map(|before| (before.inv_mul(&anchor), information(UNKNOWN_M, UNKNOWN_RAD)));
                (edge, Known { is_measured: false, sd_m: None, heading_rad2: 0.0 })
            }
        };
        if let Some((measured, information)) = edge {
            self.graph.edges.push(Constraint { from: number - 1, to: number, measured, information });
            self.known.push(known);
        }
        self.graph.poses.push(anchor);
        self.visits.push(visit);
        self.legs.push(Leg { has_left, ..Leg::default() });
        self.is_cut = false;
    }

    /// Corrects all poses: the second visit was where `fit` says, as seen from the first.
    pub(super) fn fit(&mut self, [from, to]: [usize; 2], fit: &Fit) {
        self.graph.edges.push(Constraint { from, to, measured: fit.pose, information: information(0.1, 0.02) });
        self.known.push(Known { is_measured: true, sd_m: Some(0.0), heading_rad2: 0.0 });
        // Every pose is joined to the one before, so that the edges determine all of them.
        self.graph.solve().ok();
    }

    /// Where the vehicle is now, after it left the latest visit.
    pub(super) fn flies(&mut self, place_m: Point2<f64>, way: &Travelled) {
        let Some(last) = self.last() else { return };
        let (visit, leg) = (&self.visits[last], &mut self.legs[last]);
        let from_anchor = (visit.anchor.inverse() * place_m).coords;
        if leg.beyond_m.is_none() && from_anchor.norm() >= visit.look_m {
            (leg.beyond_m, leg.width_m) = (Some(from_anchor), way.width_m());
        }
    }

    /// The leg from a visit to the latest one has ended there.
    pub(super) fn reach(&mut self, from: usize, way: &Travelled) {
        let [before, visit] = [&self.visits[from], &self.visits[from + 1]];
        let along_m = way.between(before, visit).map(|place_m| before.anchor.inverse() * place_m);
        let leg = &mut self.legs[from];
        leg.via_m = along_m.collect();
        leg.width_m = way.width_m();
        leg.length_m = Some(visit.reached_at_m - before.left_at_m);
    }
}
