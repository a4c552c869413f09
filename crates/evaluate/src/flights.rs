//! What following a flight adds to the answers for single scans: the place, the steady answer, and the map.
//!
//! - **Here right**: of the revolutions of a kind of place, those whose `here` has its kind and its number of ways;
//!   likewise for the steady answer. Between two kinds of place nothing is counted.
//! - **Count right**: revolutions whose count is the true number of walls in view; likewise for the steady answer.
//! - **Flicker**: of the revolutions whose true count has been the same for half a second, those whose count differs from
//!   the revolution before. A steady answer may be that late.
//! - **Map**: the figures of [`maps`](crate::maps), beside those of two plain ways to count.

use std::collections::BTreeMap;

use crosscut_flight::{FlightAnswer, Here, HereKind, Map};
use crosscut_messages::{Truth, TruthKind, TruthMap};
use crosscut_stage::Frame;
use serde::Serialize;

use crate::Proportion;
use crate::maps::{Counts, MapFigures, MapTruth, WhereAt, every_change, within_radius};

/// The radius of the baseline that takes all places within it to be one, metres.
pub const RADIUS_M: f64 = 8.0;

/// A change of an answer within this time after a change of the true count is not flicker.
const LATE_NS: u64 = 500_000_000;

/// The figures of flights, over any number of them. The module's page defines them.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct FlightFigures {
    /// Right places of single scans, by kind of place.
    pub here: BTreeMap<TruthKind, Proportion>,
    /// Right places of the steady answer.
    pub steady_here: BTreeMap<TruthKind, Proportion>,
    /// Right counts of single scans.
    pub count: Proportion,
    /// Right counts of the steady answer.
    pub steady_count: Proportion,
    /// Counts of single scans that flicker.
    pub flicker: Proportion,
    /// Steady counts that flicker.
    pub steady_flicker: Proportion,
    /// The map.
    pub map: MapFigures,
    /// Every change of the count is a new junction.
    pub every_change: MapFigures,
    /// All stays in junctions and dead ends of the steady place within [`RADIUS_M`] of each other, by the pose, are one.
    pub radius: MapFigures,
}

impl FlightFigures {
    /// Adds the figures of other flights.
    pub fn merge(&mut self, other: &Self) {
        for (sum, of) in [(&mut self.here, &other.here), (&mut self.steady_here, &other.steady_here)] {
            of.iter().for_each(|(kind, of)| sum.entry(*kind).or_default().merge(*of));
        }
        self.count.merge(other.count);
        self.steady_count.merge(other.steady_count);
        self.flicker.merge(other.flicker);
        self.steady_flicker.merge(other.steady_flicker);
        self.map.merge(&other.map);
        self.every_change.merge(&other.every_change);
        self.radius.merge(&other.radius);
    }
}

/// Collects the figures of one flight.
#[derive(Clone, Debug)]
pub struct FlightScore {
    figures: FlightFigures,
    truth: MapTruth,
    counts: Counts,
    /// Of the ways of the steady place.
    ways: Counts,
    /// Single and steady count of the revolution before.
    before: Option<[Option<usize>; 2]>,
    /// The true count, and since when it is that.
    walls: Option<(u32, u64)>,
}

impl FlightScore {
    /// Of a flight through this mine.
    pub fn new(mine: &TruthMap) -> Self {
        Self {
            figures: FlightFigures::default(),
            truth: MapTruth::from(mine),
            counts: Counts::default(),
            ways: Counts::default(),
            before: None,
            walls: None,
        }
    }

    /// Adds the next revolution, which the flight was followed to.
    pub fn add(&mut self, frame: &Frame, truth: &Truth) {
        let stamp_ns = frame.revolution.stamp_ns;
        if let Some(pose) = &truth.pose {
            self.truth.add(stamp_ns, pose);
        }
        let flown = FlightAnswer::of(frame);
        if let Some(tracked) = flown.pose {
            let at = WhereAt { stamp_ns, position_m: tracked.translation.vector.into() };
            self.counts.add(frame.junction.junctions, at);
            let here = flown.steady_here();
            let is_node = |here: &&Here| here.node().is_some();
            self.ways.add(here.filter(is_node).map_or(2, |here| here.ways.len()), at);
        }
        let figures = &mut self.figures;
        if let Some(true_place) = truth.here {
            let is_right = |here: Option<&Here>| {
                here.is_some_and(|here| {
                    kind(here.kind) == true_place.kind && here.ways.len() == true_place.ways as usize
                })
            };
            figures.here.entry(true_place.kind).or_default().count(is_right(flown.here.as_ref()));
            figures.steady_here.entry(true_place.kind).or_default().count(is_right(flown.steady_here()));
        }
        let walls = truth.walls as usize;
        let (single, steady) = (frame.junction.junctions, flown.steady.as_ref().map(|steady| steady.junctions));
        figures.count.count(single == walls);
        figures.steady_count.count(steady == Some(walls));
        let since = self.walls.filter(|(before, _)| *before == truth.walls).map_or(stamp_ns, |(_, since_ns)| since_ns);
        self.walls = Some((truth.walls, since));
        let now = [Some(single), steady];
        let before = self.before.replace(now).filter(|_| stamp_ns.saturating_sub(since) >= LATE_NS);
        if let Some(before) = before {
            figures.flicker.count(before[0] != now[0]);
            figures.steady_flicker.count(before[1].is_some() && before[1] != now[1]);
        }
    }

    /// The figures, with those of the map of the flight.
    pub fn figures(mut self, map: &Map) -> FlightFigures {
        self.figures.map = MapFigures::of(map, &self.truth);
        self.figures.every_change = MapFigures::of_visits(&every_change(&self.counts.stays()), &self.truth);
        self.figures.radius = MapFigures::of_visits(&within_radius(&self.ways.stays(), RADIUS_M), &self.truth);
        self.figures
    }
}

fn kind(of: HereKind) -> TruthKind {
    match of {
        HereKind::Junction => TruthKind::Junction,
        HereKind::Passage => TruthKind::Passage,
        HereKind::DeadEnd => TruthKind::DeadEnd,
        HereKind::Chamber => TruthKind::Chamber,
    }
}

#[cfg(test)]
mod tests {
    use crosscut_flight::Steady;
    use crosscut_messages::TruthPlace;

    use super::*;

    fn frame(count: usize, steady: usize, here: HereKind) -> Frame {
        let here = Some(Here { kind: here, look_m: 5.0, ways: Vec::new(), is_middle: true, confidence: 0.9 });
        let mut frame = Frame::default();
        frame.junction.junctions = count;
        let steady = Some(Steady { junctions: steady, here: None, openings: Vec::new(), closed_rad: Vec::new() });
        FlightAnswer { pose: None, doubt: None, here, steady }.put(&mut frame);
        frame
    }

    #[test]
    fn a_change_of_the_count_is_flicker_only_if_the_truth_has_not_changed_for_half_a_second() {
        let mut score = FlightScore::new(&TruthMap::default());
        let answers = [(2, 2, 2), (2, 3, 2), (2, 2, 2), (3, 3, 2), (3, 4, 2), (3, 3, 3), (3, 3, 4)];
        for (at, (walls, single, steady)) in (0..).zip(answers) {
            let mut frame = frame(single, steady, HereKind::Passage);
            frame.revolution.stamp_ns = at * 250_000_000;
            score.add(&frame, &Truth { walls, ..Truth::default() });
        }
        // The third of two walls, and the third and fourth of three.
        let figures = score.figures(&Map::default());
        assert_eq!((figures.flicker.hits, figures.flicker.of), (2, 3));
        assert_eq!((figures.steady_flicker.hits, figures.steady_flicker.of), (2, 3));
        assert_eq!((figures.count.hits, figures.steady_count.hits), (5, 4));
    }

    #[test]
    fn a_place_is_right_by_kind_and_ways_and_close_calls_are_left_out() {
        let mut score = FlightScore::new(&TruthMap::default());
        let place = |ways| Some(TruthPlace { kind: TruthKind::Chamber, ways });
        for here in [place(0), place(1), None] {
            score.add(&frame(2, 2, HereKind::Chamber), &Truth { here, ..Truth::default() });
        }
        let figures = score.figures(&Map::default());
        assert_eq!(figures.here[&TruthKind::Chamber], Proportion { hits: 1, of: 2 });
        assert_eq!(figures.steady_here[&TruthKind::Chamber], Proportion { hits: 0, of: 2 });
        let mut twice = figures.clone();
        twice.merge(&figures);
        assert_eq!(twice.here[&TruthKind::Chamber], Proportion { hits: 2, of: 4 });
    }
}
