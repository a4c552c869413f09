//! What a flight went through.

use std::collections::BTreeSet;

use crosscut_messages::{TruthMap, TruthPose};
use serde::{Deserialize, Serialize};

use super::{BELONGS, THROUGH, VISITED, ordered};

/// The mine of a flight, and where each revolution was taken.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MapTruth {
    /// Junctions and dead ends, by number.
    pub places: Vec<TruePlace>,
    /// Passages between two of them.
    pub passages: Vec<TruePassage>,
    /// Each revolution of the flight, in order.
    pub at: Vec<WhereAt>,
}

/// A junction or a dead end.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TruePlace {
    /// Where it is, metres.
    pub position_m: [f64; 2],
    /// Number of its ways.
    pub ways: usize,
    /// Width of its widest passage, metres.
    pub width_m: f64,
}

/// A passage between two places.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TruePassage {
    /// The places at its ends.
    pub ends: [usize; 2],
    /// Length of its centreline, metres.
    pub length_m: f64,
}

/// Where a revolution was taken.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct WhereAt {
    /// Stamp of the revolution.
    pub stamp_ns: u64,
    /// In the frame of the places, metres.
    pub position_m: [f64; 2],
}

impl From<&TruthMap> for MapTruth {
    /// The mine, without revolutions.
    fn from(map: &TruthMap) -> Self {
        let place = |node: &crosscut_messages::TruthNode| TruePlace {
            position_m: [node.x_m, node.y_m],
            ways: node.ways.len(),
            width_m: node.ways.iter().map(|way| way.width_m).fold(0.0, f64::max),
        };
        let passage =
            |edge: &crosscut_messages::TruthEdge| TruePassage { ends: [edge.from, edge.to], length_m: edge.length_m };
        Self {
            places: map.nodes.iter().map(place).collect(),
            passages: map.edges.iter().map(passage).collect(),
            at: Vec::new(),
        }
    }
}

impl MapTruth {
    /// Adds the next revolution of the flight.
    pub fn add(&mut self, stamp_ns: u64, pose: &TruthPose) {
        self.at.push(WhereAt { stamp_ns, position_m: [pose.x_m, pose.y_m] });
    }

    /// The nearest place and how many of its widths it is away.
    fn nearest(&self, at: &WhereAt) -> Option<(usize, f64)> {
        let widths = |place: &TruePlace| {
            let [x_m, y_m] = [0, 1].map(|axis| place.position_m[axis] - at.position_m[axis]);
            x_m.hypot(y_m) / place.width_m
        };
        let places = self.places.iter().map(widths).enumerate();
        places.min_by(|a, b| a.1.total_cmp(&b.1))
    }

    fn within(&self, at: &WhereAt, widths: f64) -> Option<usize> {
        self.nearest(at).filter(|(_, off)| *off < widths).map(|(place, _)| place)
    }

    /// The places flown through, in order, without the one in which the flight begins.
    fn route(&self) -> Vec<usize> {
        let began_in = self.at.first().and_then(|at| self.within(at, THROUGH));
        let after = self.at.iter().skip_while(|at| began_in.is_some() && self.within(at, THROUGH) == began_in);
        let mut route: Vec<usize> = after.filter_map(|at| self.within(at, THROUGH)).collect();
        route.dedup();
        route
    }

    pub(super) fn flown_through(&self) -> BTreeSet<usize> {
        self.route().into_iter().collect()
    }

    /// The passages flown from end to end. A place passed by too far off is not on the route, and those beside it are then
    /// joined by none.
    pub(super) fn flown_passages(&self) -> BTreeSet<[usize; 2]> {
        let pairs: BTreeSet<_> = self.route().windows(2).map(|pair| ordered(pair[0], pair[1])).collect();
        pairs.into_iter().filter(|ends| self.length_m(*ends).is_some()).collect()
    }

    /// First and last stamp of each stay within a width of a place.
    pub(super) fn visits_of(&self, place: usize) -> Vec<[u64; 2]> {
        let is_there: Vec<bool> = self.at.iter().map(|at| self.within(at, VISITED) == Some(place)).collect();
        let stays = is_there.chunk_by(|a, b| a == b).scan(0, |next, stay| {
            let from = *next;
            *next += stay.len();
            Some((stay[0], from, *next - 1))
        });
        stays.filter(|(there, ..)| *there).map(|(_, from, to)| [from, to].map(|at| self.at[at].stamp_ns)).collect()
    }

    /// The place that a visit belongs to.
    pub(super) fn place_of(&self, [from_ns, to_ns]: [u64; 2]) -> Option<usize> {
        let from = self.at.partition_point(|at| at.stamp_ns < from_ns);
        let to = self.at.partition_point(|at| at.stamp_ns <= to_ns);
        self.at.get(from..to).and_then(|during| during.get(during.len() / 2)).and_then(|at| self.within(at, BELONGS))
    }

    /// The place nearest in the middle of a visit, and its distance in widths.
    pub(super) fn nearest_during(&self, [from_ns, to_ns]: [u64; 2]) -> Option<(usize, f64)> {
        let during: Vec<&WhereAt> = self.at.iter().filter(|at| (from_ns..=to_ns).contains(&at.stamp_ns)).collect();
        during.get(during.len() / 2).and_then(|at| self.nearest(at))
    }

    pub(super) fn places_of(&self, visits: &[[u64; 2]]) -> BTreeSet<Option<usize>> {
        visits.iter().map(|visit| self.place_of(*visit)).collect()
    }

    /// Length of the shortest passage between two places.
    pub(super) fn length_m(&self, ends: [usize; 2]) -> Option<f64> {
        let joins = self.passages.iter().filter(|passage| ordered(passage.ends[0], passage.ends[1]) == ends);
        joins.map(|passage| passage.length_m).min_by(f64::total_cmp)
    }
}
