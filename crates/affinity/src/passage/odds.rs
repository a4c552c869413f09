//! The odds that a vehicle can pass at a gap: a sum of terms, one for each measurement. They show how doubtful the
//! decision of the rules is, and forbid openings that are too doubtful.
//!
//! ```text
//! ln(p / (1 - p)) = c + Σ f_i(x_i)
//! ```
//! No f_i falls: more of a measurement never speaks against an opening.

use super::gap::{BUMP_HIDES_BUMPS_AT_CORNER, BUMP_HIDES_M, Gap};
use super::rules::PLAIN_BUMPS;
use super::terms::{CONSTANT, TERMS};

/// The names of the measurements at a gap, in the order of the terms.
pub const MEASURES: [&str; 12] =
    ["room", "reach", "face", "dark", "chord", "lost", "bumps", "doorway", "near_far", "range", "span", "ratio"];

/// The measurements at a gap.
pub type Measures = [f64; MEASURES.len()];

/// Ratios of lengths are limited to this and its inverse.
const MOST: f64 = 100.0;

/// p(a vehicle can pass) at a gap where this is measured.
pub(super) fn p(measures: &Measures) -> f64 {
    1.0 / (1.0 + (-log_odds(measures)).exp())
}

/// p / (1 - p).
pub(super) fn odds(measures: &Measures) -> f64 {
    log_odds(measures).exp()
}

fn log_odds(measures: &Measures) -> f64 {
    CONSTANT + TERMS.iter().zip(measures).map(|(term, &x)| term_log_odds(*term, x)).sum::<f64>()
}

/// f_i(x): straight from knot to knot, level below the first and above the last.
fn term_log_odds((knots, log_odds): (&[f64], &[f64]), x: f64) -> f64 {
    let next = knots.partition_point(|&knot| knot <= x);
    match next.checked_sub(1) {
        None => log_odds[0],
        Some(last) if next == knots.len() => log_odds[last],
        Some(before) => {
            let share = (x - knots[before]) / (knots[next] - knots[before]);
            log_odds[before] + share * (log_odds[next] - log_odds[before])
        }
    }
}

impl Gap<'_> {
    /// The measurements from the nearer end, with the room ratio that the rules find. Ratios of lengths are logarithms,
    /// angles radians.
    pub(super) fn measures(&self, ratio_by_rules: f64) -> Measures {
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
            ratio(ratio_by_rules, 1.0),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_term_falls() {
        assert_eq!(TERMS.len(), MEASURES.len(), "`lab/make odds` fits a term for each measurement");
        for ((knots, log_odds), name) in TERMS.iter().zip(MEASURES) {
            assert_eq!(knots.len(), log_odds.len(), "{name}");
            assert!(knots.is_sorted_by(|a, b| a < b) && log_odds.is_sorted(), "{name}");
        }
    }

    #[test]
    fn terms_are_straight_between_knots_and_level_beyond_them() {
        let term: (&[f64], &[f64]) = (&[0.0, 1.0, 3.0], &[0.0, 2.0, 4.0]);
        let at = [-9.0, 0.0, 0.5, 1.0, 2.0, 3.0, 9.0].map(|x| term_log_odds(term, x));
        assert_eq!(at, [0.0, 0.0, 1.0, 2.0, 3.0, 4.0, 4.0]);
    }
}
