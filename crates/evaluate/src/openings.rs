//! The comparison of reported openings with true ones.

use crosscut_messages::TruthOpening;
use crosscut_report::OpeningLine;
use crosscut_stage::{Known, wrap_angle_rad};

use crate::assignment::best_matching;

/// Openings match only if their bearings differ by at most this, rad (15°).
pub const SAME_OPENING_RAD: f64 = std::f64::consts::PI / 12.0;

/// The openings of one revolution: their numbers, and the matched ones.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OpeningsScore {
    /// Number of true openings.
    pub truth: usize,
    /// Number of reported openings.
    pub reported: usize,
    /// The matched openings.
    pub matched: Vec<MatchedOpening>,
    /// Number of reported openings that are seen through.
    pub seen: usize,
}

/// The errors of a reported opening that matches a true one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MatchedOpening {
    /// Absolute difference of the bearings, rad.
    pub bearing_error_rad: f64,
    /// |reported - true| / true width; `None` if the true width is 0.
    pub width_error: Option<f64>,
    /// The reported one is seen through.
    pub is_seen: bool,
}

fn is_seen(opening: &OpeningLine) -> bool {
    opening.known == Known::Seen.as_str()
}

/// Matches openings one-to-one: as many as possible, and then with the smallest sum of bearing errors.
pub(crate) fn score(truth: &[TruthOpening], reported: &[OpeningLine]) -> OpeningsScore {
    let error_rad = |t: usize, r: usize| wrap_angle_rad(reported[r].bearing_rad - truth[t].bearing_rad).abs();
    // The sum of all rewards for small errors is less than 1, the weight of one more pair.
    let pairs_at_most = truth.len().min(reported.len()) as f64;
    let weight = |t: usize, r: usize| {
        let closeness = 1.0 - error_rad(t, r) / SAME_OPENING_RAD;
        if closeness >= 0.0 { 1.0 + closeness / (pairs_at_most + 1.0) } else { 0.0 }
    };
    let pairs = best_matching(truth.len(), reported.len(), weight);
    let matched = pairs.into_iter().filter(|&(t, r)| weight(t, r) > 0.0).map(|(t, r)| {
        let true_width_m = truth[t].width_m;
        MatchedOpening {
            is_seen: is_seen(&reported[r]),
            bearing_error_rad: error_rad(t, r),
            width_error: (true_width_m > 0.0).then(|| (reported[r].width_m - true_width_m).abs() / true_width_m),
        }
    });
    let seen = reported.iter().filter(|opening| is_seen(opening)).count();
    OpeningsScore { truth: truth.len(), reported: reported.len(), matched: matched.collect(), seen }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scored(truth_deg: &[f64], reported_deg: &[f64]) -> OpeningsScore {
        let truth: Vec<_> =
            truth_deg.iter().map(|b| TruthOpening { bearing_rad: b.to_radians(), width_m: 4.0 }).collect();
        let reported: Vec<_> = reported_deg
            .iter()
            .map(|b| OpeningLine {
                known: "judged".to_owned(),
                bearing_rad: b.to_radians(),
                width_m: 3.0,
                range_m: 5.0,
                walls: [0, 1],
                evidence: String::new(),
                p: None,
                cut_by_view: false,
            })
            .collect();
        score(&truth, &reported)
    }

    fn errors_deg(score: &OpeningsScore) -> Vec<f64> {
        score.matched.iter().map(|m| (m.bearing_error_rad.to_degrees() * 1e6).round() / 1e6).collect()
    }

    #[test]
    fn one_opening_is_matched_once_and_only_within_15_degrees() {
        assert_eq!(errors_deg(&scored(&[0.0], &[14.9, -3.0])), [3.0]);
        assert_eq!(errors_deg(&scored(&[0.0], &[15.1])), [0.0; 0]);
        assert_eq!(errors_deg(&scored(&[0.0, 90.0], &[5.0])), [5.0]);
    }

    #[test]
    fn two_pairs_are_better_than_one_closer_pair() {
        // 10 is nearest to 8, but then -4 would find nothing: 20 is too far from it.
        assert_eq!(errors_deg(&scored(&[0.0, 10.0], &[8.0, 20.0])), [8.0, 10.0]);
    }

    #[test]
    fn bearings_are_compared_across_plus_minus_pi() {
        assert_eq!(errors_deg(&scored(&[179.0], &[-179.0])), [2.0]);
    }

    #[test]
    fn width_errors_are_relative_to_the_true_width() {
        assert_eq!(scored(&[0.0], &[0.0]).matched[0].width_error, Some(0.25));
        let closed = TruthOpening { bearing_rad: 0.0, width_m: 0.0 };
        let line = OpeningLine {
            known: "judged".to_owned(),
            bearing_rad: 0.0,
            width_m: 3.0,
            range_m: 5.0,
            walls: [0, 1],
            evidence: String::new(),
            p: None,
            cut_by_view: false,
        };
        assert_eq!(score(&[closed], &[line]).matched[0].width_error, None);
    }
}
