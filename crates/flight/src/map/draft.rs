//! The map as far as it is known, with what is kept to continue it.

use std::collections::BTreeMap;
use std::sync::Arc;

use crosscut_stage::{PoseDoubt, wrap_angle_rad};
use nalgebra::{Isometry2, Point2};

use super::Map;
use super::legs::Leg;
use super::outline::Walls;
use super::travelled::Travelled;
use super::visit::Visit;
use crate::{HereKind, PoseGraph};

/// Where an anchor lies in its place, standard deviation.
const ANCHOR_M: f64 = 0.1;

/// The map as far as it is known, with what is kept to continue it.
#[derive(Clone, Debug, Default)]
pub(super) struct Draft {
    pub(super) map: Map,
    /// Each visit's anchor, and what was measured between them. Poses are corrected, measurements are not.
    pub(super) graph: PoseGraph,
    /// How each edge of the graph was flown.
    pub(super) flown: Vec<Leg>,
    /// What is kept of each node to recognise it.
    pub(super) places: Vec<NodeMemory>,
    /// Of each passage: the visit from which it was entered first, and places along it in the frame of that anchor.
    pub(super) courses: Vec<(usize, Vec<Point2<f64>>)>,
    pub(super) last: Option<Departure>,
    pub(super) way: Travelled,
    /// Doubt of the pose when the visit that ended last, or is open, began.
    pub(super) began_doubt: PoseDoubt,
    /// Where visits of this stretch to which no known way led may have been.
    pub(super) guesses: Vec<Guess>,
    /// Visits of this stretch that were not compared with all places.
    pub(super) strays: Vec<Stray>,
}

/// What is kept of a node to recognise it.
#[derive(Clone, Debug)]
pub(super) struct NodeMemory {
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
    pub(super) was_taken: bool,
    /// The vehicle was beyond the look since: the way is certain.
    pub(super) is_settled: bool,
    pub(super) has_middle: bool,
    pub(super) visit: usize,
    pub(super) look_m: f64,
    /// The anchor as it was tracked.
    pub(super) tracked: Isometry2<f64>,
    /// The way of the flight there.
    pub(super) at_m: f64,
    pub(super) left_ns: u64,
    pub(super) doubt: PoseDoubt,
    /// Where its ways begin, as they were tracked.
    pub(super) mouths_m: Vec<Point2<f64>>,
}

/// Where a stretch lies if a visit of it was to a node.
#[derive(Clone, Copy, Debug)]
pub(super) struct Guess {
    pub(super) node: usize,
    /// The number of the node's [group](super::legs::groups): how the places of two groups lie to each other is not known, so that
    /// they do not agree.
    pub(super) group: u32,
    /// Brings tracked poses into the map's frame.
    pub(super) stretch: Isometry2<f64>,
}

/// A visit to a place that was not recognised, as it is compared with places of other groups.
#[derive(Clone, Debug)]
pub(super) struct Stray {
    pub(super) kind: HereKind,
    pub(super) anchor: Isometry2<f64>,
    pub(super) bearings_rad: Vec<f64>,
    pub(super) walls: Arc<Walls>,
}

impl Draft {
    /// Standard deviation of a visit's anchor as seen from that of the last one.
    pub(super) fn flown_sd_m(&self, last: &Departure, visit: &Visit) -> Option<f64> {
        let end = Point2::from(visit.anchor.translation.vector);
        self.began_doubt.since(&last.doubt)?.sd_m(end).map(|sd_m| sd_m.hypot(ANCHOR_M))
    }
}

/// The way nearest to a direction.
pub(super) fn nearest_way(ways_rad: &[f64], direction_rad: f64) -> Option<usize> {
    let off_rad = |way: &usize| wrap_angle_rad(ways_rad[*way] - direction_rad).abs();
    (0..ways_rad.len()).min_by(|a, b| off_rad(a).total_cmp(&off_rad(b)))
}
