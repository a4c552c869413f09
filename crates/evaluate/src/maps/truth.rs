//! What a flight went through.

use std::collections::BTreeSet;

use crosscut_flight::Map;
use crosscut_messages::{TruthMap, TruthPose};
use serde::{Deserialize, Serialize};

use super::{BELONGS, THROUGH, VISITED, ordered};

/// The look at a place, 1.5 widths, and the twentieth by which a way leads farther.
const POCKET_WIDTHS: f64 = 1.5 * 1.05;

/// The shortest and the longest of the three looks that a place is judged in, of that.
const LOOKS: [f64; 2] = [0.85, 1.15];

/// The mine of a flight, and where each revolution was taken.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MapTruth {
    /// Junctions and dead ends, by number.
    pub places: Vec<TruePlace>,
    /// Passages between two of them.
    pub passages: Vec<TruePassage>,
    /// Each revolution of the flight, in order.
    pub at: Vec<WhereAt>,
    /// Bays, as indices of `passages`: dead ends so near to the place before them that the looks at it differ.
    #[serde(default)]
    pub bays: Vec<usize>,
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
    /// Width of its narrowest passage, metres.
    pub narrowest_m: f64,
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
    /// The mine as a flight shows it, without revolutions. A dead end that every look at the place before it sees is a part of
    /// that place, and a place that keeps two ways is a part of a passage.
    fn from(map: &TruthMap) -> Self {
        let place = |node: &crosscut_messages::TruthNode| TruePlace {
            position_m: [node.x_m, node.y_m],
            ways: node.ways.len(),
            width_m: node.ways.iter().map(|way| way.width_m).fold(0.0, f64::max),
            narrowest_m: node.ways.iter().map(|way| way.width_m).fold(f64::INFINITY, f64::min),
        };
        let passage =
            |edge: &crosscut_messages::TruthEdge| TruePassage { ends: [edge.from, edge.to], length_m: edge.length_m };
        let places: Vec<TruePlace> = map.nodes.iter().map(place).collect();
        let passages: Vec<TruePassage> = map.edges.iter().map(passage).collect();
        let nearer = |passage: &TruePassage, [narrowest, widest]: [f64; 2]| {
            pocket(&places, passage).is_some_and(|(_, before)| {
                let TruePlace { width_m, narrowest_m, .. } = places[before];
                passage.length_m < POCKET_WIDTHS * f64::max(narrowest * narrowest_m, widest * width_m)
            })
        };
        let [shortest, longest] = LOOKS;
        // The local width of a place lies between those of its passages.
        let is_pocket = |at: usize| nearer(&passages[at], [shortest, 0.0]);
        let is_bay = |at: usize| nearer(&passages[at], [0.0, longest]);
        let all = 0..passages.len();
        let (pockets, others): (Vec<usize>, Vec<usize>) = all.partition(|&at| is_pocket(at));
        let bays = others.into_iter().filter(|&at| is_bay(at)).collect();
        Self { places, passages, at: Vec::new(), bays }.without(&pockets)
    }
}

/// The dead end of a passage to one, and the place before it.
fn pocket(places: &[TruePlace], passage: &TruePassage) -> Option<(usize, usize)> {
    let [a, b] = passage.ends;
    [(a, b), (b, a)].into_iter().find(|&(end, before)| places[end].ways == 1 && places[before].ways > 1)
}

impl MapTruth {
    /// The mine as these visits saw it, by node: a bay is a way where they have a node at the place before it, and else a part
    /// of a passage. Beside three other ways it is one.
    pub(super) fn seen_by(&self, visits: &[Vec<[u64; 2]>]) -> Self {
        if self.bays.is_empty() {
            return self.clone();
        }
        let found: BTreeSet<Option<usize>> = visits.iter().flat_map(|visits| self.places_of(visits)).collect();
        let is_unseen = |bay: &&usize| {
            let before = pocket(&self.places, &self.passages[**bay]).map(|(_, before)| before);
            before.is_some_and(|before| self.places[before].ways == 3) && !found.contains(&before)
        };
        let unseen: Vec<usize> = self.bays.iter().filter(is_unseen).copied().collect();
        self.without(&unseen)
    }

    /// Whether a place has this number of ways, those to bays counted or not.
    pub(super) fn has_ways(&self, place: usize, ways: usize) -> bool {
        let bays = self.bays.iter().filter(|&&bay| self.passages[bay].ends.contains(&place)).count();
        let all = self.places[place].ways;
        (all - bays.min(all)..=all).contains(&ways)
    }

    /// Without passages to dead ends, which are parts of the places before them. The passages of places that keep two ways are
    /// joined.
    fn without(&self, pockets: &[usize]) -> Self {
        let mut places = self.places.clone();
        let mut is_place = vec![true; places.len()];
        for &at in pockets {
            if let Some((end, before)) = pocket(&places, &self.passages[at]) {
                is_place[end] = false;
                places[before].ways -= 1;
            }
        }
        let is_left = |at: &usize| !pockets.contains(at);
        // Each with the bay that it is, as a passage through a bend is none.
        let left = (0..self.passages.len()).filter(is_left);
        let mut passages: Vec<(TruePassage, bool)> =
            left.map(|at| (self.passages[at], self.bays.contains(&at))).collect();
        let is_bend = |place: &usize| is_place[*place] && places[*place].ways == 2;
        let bends: Vec<usize> = (0..places.len()).filter(is_bend).collect();
        for bend in bends {
            let at: Vec<usize> = (0..passages.len()).filter(|&at| passages[at].0.ends.contains(&bend)).collect();
            let &[first, second] = &at[..] else { continue };
            let (second, _) = passages.swap_remove(second);
            let other = |passage: &TruePassage| passage.ends[usize::from(passage.ends[0] == bend)];
            let first = &mut passages[first];
            let ends = [other(&first.0), other(&second)];
            *first = (TruePassage { ends, length_m: first.0.length_m + second.length_m }, false);
            is_place[bend] = false;
        }
        let number: Vec<usize> = is_place
            .iter()
            .scan(0, |next, &is_place| Some(std::mem::replace(next, *next + usize::from(is_place))))
            .collect();
        passages.iter_mut().for_each(|(passage, _)| passage.ends = passage.ends.map(|end| number[end]));
        let bays = (0..passages.len()).filter(|&at| passages[at].1).collect();
        let passages = passages.into_iter().map(|(passage, _)| passage).collect();
        let places =
            places.into_iter().zip(is_place).filter(|(_, is_place)| *is_place).map(|(place, _)| place).collect();
        Self { places, passages, at: self.at.clone(), bays }
    }
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
        let off_m = |place: &TruePlace| {
            let [x_m, y_m] = [0, 1].map(|axis| place.position_m[axis] - at.position_m[axis]);
            x_m.hypot(y_m)
        };
        let places = self.places.iter().map(off_m).enumerate();
        let (place, off_m) = places.min_by(|a, b| a.1.total_cmp(&b.1))?;
        Some((place, off_m / self.places[place].width_m))
    }

    fn within(&self, at: &WhereAt, widths: f64) -> Option<usize> {
        self.nearest(at).filter(|(_, off)| *off < widths).map(|(place, _)| place)
    }

    /// The place that is flown through here. A vehicle turns back before the face of a dead end.
    fn through(&self, at: &WhereAt) -> Option<usize> {
        let within = |place: usize| if self.places[place].ways == 1 { VISITED } else { THROUGH };
        self.nearest(at).filter(|(place, off)| *off < within(*place)).map(|(place, _)| place)
    }

    /// The places flown through, in order, without the one in which the flight begins, each with the way from the one before.
    fn route(&self) -> Vec<(usize, f64)> {
        let began_in = self.at.first().and_then(|at| self.through(at));
        let after = self.at.iter().skip_while(|at| began_in.is_some() && self.through(at) == began_in);
        let (mut route, mut way_m, mut before) = (Vec::<(usize, f64)>::new(), 0.0, None::<[f64; 2]>);
        for at in after {
            let [x_m, y_m] = at.position_m;
            way_m += before
                .replace(at.position_m)
                .map_or(0.0, |[from_x_m, from_y_m]| (x_m - from_x_m).hypot(y_m - from_y_m));
            match self.through(at) {
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
