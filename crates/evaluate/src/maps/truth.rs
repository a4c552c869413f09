//! What a flight went through.

use std::collections::BTreeSet;

use crosscut_flight::Map;
use crosscut_messages::{TruthMap, TruthPose};
use serde::{Deserialize, Serialize};

use super::{BELONGS, THROUGH, VISITED, ordered};

/// The look at a place, 1.5 local widths, and the twentieth by which a way leads farther.
const POCKET_WIDTHS: f64 = 1.5 * 1.05;

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
    /// The mine as a flight shows it, without revolutions. A dead end that is seen from the place before it is a part of that
    /// place, and a place that keeps two ways is a part of a passage.
    fn from(map: &TruthMap) -> Self {
        let place = |node: &crosscut_messages::TruthNode| TruePlace {
            position_m: [node.x_m, node.y_m],
            ways: node.ways.len(),
            width_m: node.ways.iter().map(|way| way.width_m).fold(0.0, f64::max),
        };
        let passage =
            |edge: &crosscut_messages::TruthEdge| TruePassage { ends: [edge.from, edge.to], length_m: edge.length_m };
        let mut places: Vec<TruePlace> = map.nodes.iter().map(place).collect();
        let mut passages: Vec<TruePassage> = map.edges.iter().map(passage).collect();
        let is_place = leave_out_pockets(&mut places, &mut passages);
        let number: Vec<usize> = is_place
            .iter()
            .scan(0, |next, &is_place| Some(std::mem::replace(next, *next + usize::from(is_place))))
            .collect();
        passages.iter_mut().for_each(|passage| passage.ends = passage.ends.map(|end| number[end]));
        let places =
            places.into_iter().zip(is_place).filter(|(_, is_place)| *is_place).map(|(place, _)| place).collect();
        Self { places, passages, at: Vec::new() }
    }
}

/// Leaves out dead ends in sight of the place before them, and joins the passages of places that keep two ways. Returns
/// which places are left.
fn leave_out_pockets(places: &mut [TruePlace], passages: &mut Vec<TruePassage>) -> Vec<bool> {
    let mut is_place = vec![true; places.len()];
    passages.retain(|&TruePassage { ends: [a, b], length_m }| {
        let is_pocket = |end: usize, before: usize| {
            places[end].ways == 1 && places[before].ways > 1 && length_m < POCKET_WIDTHS * places[before].width_m
        };
        let pocket = [(a, b), (b, a)].into_iter().find(|&(end, before)| is_pocket(end, before));
        if let Some((end, before)) = pocket {
            is_place[end] = false;
            places[before].ways -= 1;
        }
        pocket.is_none()
    });
    for bend in (0..places.len()).filter(|&place| places[place].ways == 2) {
        let at: Vec<usize> = (0..passages.len()).filter(|&at| passages[at].ends.contains(&bend)).collect();
        let &[first, second] = &at[..] else { continue };
        let second = passages.swap_remove(second);
        let other = |passage: &TruePassage| passage.ends[usize::from(passage.ends[0] == bend)];
        let first = &mut passages[first];
        *first = TruePassage { ends: [other(first), other(&second)], length_m: first.length_m + second.length_m };
        is_place[bend] = false;
    }
    is_place
}

/// Which places and passages of the mine those of a map are.
pub(super) struct Named {
    /// For each node, the places that its visits belong to; more than one if they are mixed up.
    pub(super) places: Vec<BTreeSet<Option<usize>>>,
    /// For each passage of the map.
    pub(super) passages: Vec<Option<usize>>,
}

impl Named {
    /// The place of a node; of several that are mixed up, one.
    pub(super) fn place(&self, node: usize) -> Option<usize> {
        self.places[node].iter().next().copied().flatten()
    }
}

impl MapTruth {
    /// Which places and passages those of a map are, each passage once.
    pub(super) fn named(&self, map: &Map) -> Named {
        let places = map.nodes.iter().map(|node| self.places_of(&node.visits)).collect();
        let mut named = Named { places, passages: Vec::new() };
        let mut taken = BTreeSet::new();
        for passage in &map.passages {
            let ends = named.place(passage.from).zip(named.place(passage.to));
            let right = ends.and_then(|(from, to)| self.passage(ordered(from, to), passage.length_m, &taken));
            taken.extend(right);
            named.passages.push(right);
        }
        named
    }

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

    /// The places flown through, in order, without the one in which the flight begins, each with the way from the one before.
    fn route(&self) -> Vec<(usize, f64)> {
        let began_in = self.at.first().and_then(|at| self.within(at, THROUGH));
        let after = self.at.iter().skip_while(|at| began_in.is_some() && self.within(at, THROUGH) == began_in);
        let (mut route, mut way_m, mut before) = (Vec::<(usize, f64)>::new(), 0.0, None::<[f64; 2]>);
        for at in after {
            let [x_m, y_m] = at.position_m;
            way_m += before
                .replace(at.position_m)
                .map_or(0.0, |[from_x_m, from_y_m]| (x_m - from_x_m).hypot(y_m - from_y_m));
            match self.within(at, THROUGH) {
                Some(place) if route.last().is_none_or(|(last, _)| *last != place) => {
                    route.push((place, std::mem::take(&mut way_m)));
                }
                Some(_) => way_m = 0.0,
                None => {}
            }
        }
        route
    }

    pub(super) fn flown_through(&self) -> BTreeSet<usize> {
        self.route().into_iter().map(|(place, _)| place).collect()
    }

    /// The passages flown from end to end. A place passed by too far off is not on the route, and those beside it are then
    /// joined by none.
    pub(super) fn flown_passages(&self) -> BTreeSet<usize> {
        let legs = self.route();
        let legs = legs.windows(2).map(|pair| (ordered(pair[0].0, pair[1].0), pair[1].1));
        legs.filter_map(|(ends, way_m)| self.passage(ends, way_m, &BTreeSet::new())).collect()
    }

    /// Of the passages between two places that are not taken, the one whose length is nearest to this one.
    fn passage(&self, ends: [usize; 2], length_m: f64, taken: &BTreeSet<usize>) -> Option<usize> {
        let joins = |at: &usize| ordered(self.passages[*at].ends[0], self.passages[*at].ends[1]) == ends;
        let off_m = |at: &usize| (self.passages[*at].length_m - length_m).abs();
        let free = (0..self.passages.len()).filter(|at| joins(at) && !taken.contains(at));
        free.min_by(|a, b| off_m(a).total_cmp(&off_m(b)))
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
    pub(super) fn place_of(&self, visit: [u64; 2]) -> Option<usize> {
        self.nearest_during(visit).filter(|(_, widths)| *widths < BELONGS).map(|(place, _)| place)
    }

    /// The place nearest in the middle of a visit, and its distance in widths.
    pub(super) fn nearest_during(&self, [from_ns, to_ns]: [u64; 2]) -> Option<(usize, f64)> {
        let from = self.at.partition_point(|at| at.stamp_ns < from_ns);
        let to = self.at.partition_point(|at| at.stamp_ns <= to_ns);
        self.at.get(from..to).and_then(|during| during.get(during.len() / 2)).and_then(|at| self.nearest(at))
    }

    pub(super) fn places_of(&self, visits: &[[u64; 2]]) -> BTreeSet<Option<usize>> {
        visits.iter().map(|visit| self.place_of(*visit)).collect()
    }
}
