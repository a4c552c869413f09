//! The odds that a vehicle can pass at a gap: a sum of terms, one for each measurement. They show how doubtful the
//! decision of the rules is, and forbid openings that are too doubtful.
//!
//! ```text
//! ln(p / (1 - p)) = c + Σ f_i(x_i)
//! ```
//! No f_i falls: more of a measurement never speaks against an opening.

use crosscut_stage::Measured;

use super::gap::{BUMP_HIDES_BUMPS_AT_CORNER, BUMP_HIDES_M, Gap};
use super::rules::PLAIN_BUMPS;
use super::terms::{CONSTANT, TERMS};
use super::verdict::{DOOR, Decision};

/// An opening at which something is seen has at least these odds: 3 of 10 gaps like it are openings.
const LEAST_ODDS: f64 = 3.0 / 7.0;
/// A door in which nothing is seen has at least these odds: 1 of 10 gaps like it is an opening. A patch of lost beams may be as
/// wide as a door.
const LEAST_DOOR_ODDS: f64 = 1.0 / 9.0;
/// The reason where the odds leave no opening.
const UNLIKELY: &str = "a wall that closes it may be hidden";

/// The names of the measurements at a gap, in the order of the terms.
pub const MEASURES: [&str; 12] =
    ["room", "reach", "face", "dark", "chord", "lost", "bumps", "doorway", "near_far", "range", "span", "ratio"];

/// The measurements at a gap.
pub type Measures = [f64; MEASURES.len()];

/// Ratios of lengths are limited to this and its inverse.
const MOST: f64 = 100.0;

/// f_i: straight from knot to knot, level below the first and above the last.
pub(super) struct Term {
    /// The measurements at the knots, ascending.
    pub(super) at: &'static [f64],
    /// The log odds there.
    pub(super) log_odds: &'static [f64],
}

impl Term {
    fn log_odds(&self, x: f64) -> f64 {
        let next = self.at.partition_point(|&knot| knot <= x);
        match next.checked_sub(1) {
            None => self.log_odds[0],
            Some(last) if next == self.at.len() => self.log_odds[last],
            Some(before) => {
                let share = (x - self.at[before]) / (self.at[next] - self.at[before]);
                self.log_odds[before] + share * (self.log_odds[next] - self.log_odds[before])
            }
        }
    }
}

/// p(a vehicle can pass) at a gap where this is measured.
pub(super) fn p(measures: &Measures) -> f64 {
    1.0 / (1.0 + (-log_odds(measures)).exp())
}

/// p / (1 - p).
pub(super) fn odds(measures: &Measures) -> f64 {
    log_odds(measures).exp()
}

fn log_odds(measures: &Measures) -> f64 {
    CONSTANT + TERMS.iter().zip(measures).map(|(term, &x)| term.log_odds(x)).sum::<f64>()
}

impl Gap<'_> {
    /// Measures a gap, at which this is decided, for its odds. Of two equally near ends neither is the nearer one, and
    /// the mean of both views counts.
    pub(super) fn measures(&self, decision: Decision) -> Measures {
        let one = self.measures_from_nearer(decision);
        let Some(other) = self.by_other_end() else { return one };
        let other = other.measures_from_nearer(other.decide_by_rules());
        std::array::from_fn(|at| f64::midpoint(one[at], other[at]))
    }

    /// The decision; none for an opening if the odds that all measurements together give it are below [`LEAST_ODDS`], or
    /// below [`LEAST_DOOR_ODDS`] at a door in which nothing is seen. The odds are then the room, so the gap keeps its doubt.
    /// Elsewhere in the dark the rules decide alone: no measurement shows how the hidden wall runs.
    pub(super) fn limited_by_odds(&self, decision: Decision) -> Decision {
        let is_door = decision.reason == DOOR;
        if (self.is_dark && !is_door) || !decision.is_opening() || self.context.thresholds.disabled.odds {
            return decision;
        }
        let least = if is_door { LEAST_DOOR_ODDS } else { LEAST_ODDS };
        let odds = odds(&self.measures(decision));
        let percent = |odds: f64| 100.0 * odds / (1.0 + odds);
        let measured = || Measured {
            what: "the share of openings among gaps that measure like this is",
            value: percent(odds),
            against: "an opening has at least",
            limit: percent(least),
            unit: "%",
        };
        if odds < least {
            Decision { room_ratio: odds, reason: UNLIKELY, measured: Some(measured()), ..decision }
        } else {
            decision
        }
    }

    /// What is measured from the nearer end. Ratios of lengths are logarithms, angles radians.
    fn measures_from_nearer(&self, decision: Decision) -> Measures {
        let (context, size_m, passage_m) = (self.context, self.context.scan.size_m, self.context.passage_m());
        let ratio = |length_m: f64, to_m: f64| (length_m / to_m).clamp(1.0 / MOST, MOST).ln();
        let beams = |beams: u32| f64::from(beams + 1);
        [
            ratio(self.step_m(), self.shadow_m(BUMP_HIDES_M, BUMP_HIDES_BUMPS_AT_CORNER)),
            ratio(self.chord_m(), self.next_m()),
            self.face_turn_rad(),
            self.dark_rad() * self.near_m / size_m,
            ratio(self.chord_m(), passage_m),
            (beams(self.dark_beams) / beams(context.lost.in_a_row)).ln(),
            ratio(self.clear_m, context.with_bumps_m(passage_m, PLAIN_BUMPS)),
            self.behind_doorway_m().map_or(0.0, |behind_m| behind_m.max(0.0) / passage_m),
            self.near_m / self.far_m,
            self.near_m / size_m,
            self.near_span_rad(),
            ratio(decision.ratio_by_rules, 1.0),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_term_falls() {
        for (term, name) in TERMS.iter().zip(MEASURES) {
            assert_eq!(term.at.len(), term.log_odds.len(), "{name}");
            assert!(term.at.is_sorted_by(|a, b| a < b) && term.log_odds.is_sorted(), "{name}");
        }
    }

    #[test]
    fn terms_are_straight_between_knots_and_level_beyond_them() {
        let term = Term { at: &[0.0, 1.0, 3.0], log_odds: &[0.0, 2.0, 4.0] };
        assert_eq!([-9.0, 0.0, 0.5, 1.0, 2.0, 3.0, 9.0].map(|x| term.log_odds(x)), [0.0, 0.0, 1.0, 2.0, 3.0, 4.0, 4.0]);
    }
}
