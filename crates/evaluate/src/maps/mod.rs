//! How right the map of a flight is, against the mine that it went through.
//!
//! A *place* is a junction or a dead end of the mine; distances to it are in widths of its widest passage. A dead end that is
//! seen from the place before it, within 1.34 widths of its narrowest passage, is a part of that place: by the definition of
//! `here` no way leads to it. A place that keeps two ways is then a part of a passage. Up to 1.81 widths of its widest passage
//! the dead end is a *bay*: the three looks of `here` differ. A junction of two ways and a bay may be on the map or not, and one
//! of more ways with the bay or without; either is right. A visit of the
//! map belongs to the place that is nearest in its middle, if that is within 1.6 widths. A place was *flown through* if
//! the vehicle came within 0.4 widths, of a dead end within one, as it turns back before the face; the place in which a flight
//! begins is not, as half of it was never flown.
//!
//! - **Nodes**: those of the map and the places flown through are matched one to one, so that the time at which both are
//!   visited (within a width) is longest. Precision, recall and F1 count pairs with such a time.
//! - **Over-count**: nodes of the map over places flown through.
//! - **Same place**: of all pairs of visits that belong to a place, those that the map takes to be to one node, against
//!   those that are: precision and recall. A **false merge** is a node whose visits belong to two places, or partly to
//!   none.
//! - **Degree**: share of the matched nodes with the true number of ways.
//! - **Passages**: those flown from place to place that the map has, and those of the map that are not there. Of several
//!   between the same two places, the one nearest in length counts. **Length**: error of the length of right ones, relative.
//!   **Loops**: those of the passages flown; more are false.
//! - **Exact**: each place flown through is one node, each passage flown between two of them one passage, none mixes two
//!   places, and none is of no place. Where a flight begins or ends, a place may be found that was not flown through.

mod baselines;
mod differences;
mod truth;

use std::collections::BTreeSet;

use crosscut_flight::{Map, loops_in};
use serde::Serialize;

use crate::Proportion;
use crate::assignment::best_matching;

pub use baselines::{Counts, Stay, every_change, within_radius};
pub use truth::{MapTruth, TruePassage, TruePlace, WhereAt};

/// Widths within which a place is visited, a junction was flown through, and a visit of the map belongs to it.
const VISITED: f64 = 1.0;
const THROUGH: f64 = 0.4;
const BELONGS: f64 = 1.6;

/// The figures of maps, over any number of flights. The module's page defines them.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct MapFigures {
    /// Flights whose map is exact.
    pub exact: Proportion,
    /// Nodes with a place, of the nodes.
    pub precision: Proportion,
    /// Places flown through that have a node, of those flown through.
    pub recall: Proportion,
    /// Pairs of visits to one place, of those to one node.
    pub same_precision: Proportion,
    /// Pairs of visits to one node, of those to one place.
    pub same_recall: Proportion,
    /// Nodes that mix two places, or one with none.
    pub false_merges: u64,
    /// Matched nodes with the true number of ways; no cases for baselines, which have no ways.
    pub degree: Proportion,
    /// Passages flown that the map has, of those flown; no cases for baselines.
    pub passages: Proportion,
    /// Passages of the map that the mine does not have.
    pub false_passages: u64,
    /// Loops of the map, of those flown.
    pub loops: Proportion,
    /// Loops of the map beyond those flown.
    pub false_loops: u64,
    /// Relative errors of the lengths of right passages.
    pub length_errors: Vec<f64>,
}

impl MapFigures {
    /// Judges the map of a flight.
    pub fn of(map: &Map, truth: &MapTruth) -> Self {
        let visits: Vec<Vec<[u64; 2]>> = map.nodes.iter().map(|node| node.visits.clone()).collect();
        let truth = &truth.seen_by(&visits);
        let mut figures = Self::of_visits_seen(&visits, truth);
        let through = truth.flown_through();
        let matched = matched(&visits, &through, truth);
        for &(node, place) in &matched {
            figures.degree.count(truth.has_ways(place, map.nodes[node].ways.len()));
        }
        let named = truth.named(map);
        for (passage, right) in map.passages.iter().zip(&named.passages) {
            let Some(right) = *right else {
                figures.false_passages += 1;
                continue;
            };
            let length_m = truth.passages[right].length_m;
            figures.length_errors.push((passage.length_m - length_m).abs() / length_m);
        }
        let found: BTreeSet<usize> = named.passages.iter().copied().flatten().collect();
        let flown = truth.flown_passages();
        for passage in &flown {
            figures.passages.count(found.contains(passage));
        }
        let loops = loops_in(flown.iter().map(|&passage| truth.passages[passage].ends));
        figures.loops = Proportion { hits: map.loops().min(loops) as u64, of: loops as u64 };
        figures.false_loops = map.loops().saturating_sub(loops) as u64;
        let places: BTreeSet<usize> = (0..map.nodes.len()).filter_map(|node| named.place(node)).collect();
        let is_exact = figures.false_merges == 0
            && places.len() == map.nodes.len()
            && through.is_subset(&places)
            && map.passages.len() == found.len()
            && flown.is_subset(&found);
        figures.exact.count(is_exact);
        figures
    }

    /// Judges visits alone, by node: a way of counting that has no ways and no passages.
    pub fn of_visits(visits: &[Vec<[u64; 2]>], truth: &MapTruth) -> Self {
        Self::of_visits_seen(visits, &truth.seen_by(visits))
    }

    /// The same against the mine as these visits saw it.
    fn of_visits_seen(visits: &[Vec<[u64; 2]>], truth: &MapTruth) -> Self {
        let mut figures = Self::default();
        let through = truth.flown_through();
        let matched = matched(visits, &through, truth).len() as u64;
        figures.precision = Proportion { hits: matched, of: visits.len() as u64 };
        figures.recall = Proportion { hits: matched, of: through.len() as u64 };
        let all: Vec<(usize, Option<usize>)> = (0..visits.len())
            .flat_map(|node| visits[node].iter().map(move |visit| (node, truth.place_of(*visit))))
            .collect();
        for (at, (node, place)) in all.iter().enumerate() {
            for (other_node, other_place) in &all[..at] {
                if place.is_none() || other_place.is_none() {
                    continue;
                }
                let (is_found, is_true) = (node == other_node, place == other_place);
                if is_found {
                    figures.same_precision.count(is_true);
                }
                if is_true {
                    figures.same_recall.count(is_found);
                }
            }
        }
        figures.false_merges = visits.iter().filter(|visits| truth.places_of(visits).len() > 1).count() as u64;
        figures
    }

    /// Adds the figures of other flights.
    pub fn merge(&mut self, other: &Self) {
        let pairs = [
            (&mut self.exact, other.exact),
            (&mut self.precision, other.precision),
            (&mut self.recall, other.recall),
            (&mut self.same_precision, other.same_precision),
            (&mut self.same_recall, other.same_recall),
            (&mut self.degree, other.degree),
            (&mut self.passages, other.passages),
            (&mut self.loops, other.loops),
        ];
        pairs.into_iter().for_each(|(sum, of)| sum.merge(of));
        self.false_merges += other.false_merges;
        self.false_passages += other.false_passages;
        self.false_loops += other.false_loops;
        self.length_errors.extend(&other.length_errors);
    }

    /// The harmonic mean of precision and recall; `None` without a node or a place.
    pub fn f1(&self) -> Option<f64> {
        let both = self.precision.of + self.recall.of;
        (both > 0).then(|| 2.0 * self.precision.hits as f64 / both as f64)
    }

    /// Nodes over places flown through; `None` without a place.
    pub fn over_count(&self) -> Option<f64> {
        (self.recall.of > 0).then(|| self.precision.of as f64 / self.recall.of as f64)
    }
}

/// Nodes and the places that they are, one to one.
fn matched(visits: &[Vec<[u64; 2]>], through: &BTreeSet<usize>, truth: &MapTruth) -> Vec<(usize, usize)> {
    let through: Vec<usize> = through.iter().copied().collect();
    let stays: Vec<Vec<[u64; 2]>> = through.iter().map(|&place| truth.visits_of(place)).collect();
    let shared_ns = |node: usize, place: usize| -> f64 {
        let pairs = visits[node].iter().flat_map(|visit| stays[place].iter().map(move |stay| (visit, stay)));
        let shared = pairs.map(|(visit, stay)| (visit[1].min(stay[1]) + 1).saturating_sub(visit[0].max(stay[0])));
        shared.sum::<u64>() as f64
    };
    let pairs = best_matching(visits.len(), through.len(), shared_ns);
    let meet = pairs.into_iter().filter(|&(node, place)| shared_ns(node, place) > 0.0);
    meet.map(|(node, place)| (node, through[place])).collect()
}

fn ordered(a: usize, b: usize) -> [usize; 2] {
    [a.min(b), a.max(b)]
}
