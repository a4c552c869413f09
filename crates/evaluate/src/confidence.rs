//! Calibration of the confidence, and the ranking of answers by it.

use crosscut_stage::SURE;
use serde::Serialize;

use crate::Proportion;

/// Number of bins of the reliability table.
pub const BINS: usize = 10;

/// The relation of confidence and truth.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Confidence {
    /// Answers in tenths of confidence: [0, 0.1), [0.1, 0.2), ..., [0.9, 1].
    pub reliability: Vec<ReliabilityBin>,
    /// Share of the answers that are sure.
    pub sure: Proportion,
    /// Share of the sure answers that are right.
    pub sure_right: Proportion,
    /// Probability that a right answer has a higher confidence than a wrong one, ties by half; `None` if all answers
    /// are right or all are wrong.
    pub auroc: Option<f64>,
}

/// The answers whose confidence is in one tenth.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ReliabilityBin {
    /// Smallest confidence of the bin.
    pub from: f64,
    /// Mean confidence of its answers; `None` if it has none.
    pub mean_confidence: Option<f64>,
    /// Share of its answers that are right; near the mean confidence if the method is calibrated.
    pub right: Proportion,
}

impl Confidence {
    /// Evaluates pairs of confidence and whether the answer was right, in any order.
    pub(crate) fn of(answers: &[(f64, bool)]) -> Self {
        let (mut sure, mut sure_right) = (Proportion::default(), Proportion::default());
        let mut bins = [(0.0, Proportion::default()); BINS];
        for &(confidence, right) in answers {
            sure.count(confidence >= SURE);
            if confidence >= SURE {
                sure_right.count(right);
            }
            let bin = &mut bins[bin_of(confidence)];
            bin.0 += confidence;
            bin.1.count(right);
        }
        let reliability = bins.iter().enumerate().map(|(bin, &(sum, right))| ReliabilityBin {
            from: lower_edge(bin),
            mean_confidence: (right.of > 0).then(|| sum / right.of as f64),
            right,
        });
        Self { reliability: reliability.collect(), sure, sure_right, auroc: auroc(answers) }
    }
}

fn lower_edge(bin: usize) -> f64 {
    bin as f64 / BINS as f64
}

/// The last bin whose lower edge is at most `confidence`. The comparison with the edges puts 0.3 into [0.3, 0.4).
fn bin_of(confidence: f64) -> usize {
    (1..BINS).rev().find(|&bin| confidence >= lower_edge(bin)).unwrap_or(0)
}

/// (R - r(r+1)/2) / (r·w), with R the sum of the ranks of the r right answers among all, ties at their mean rank, and w
/// the number of wrong ones (Mann and Whitney).
fn auroc(answers: &[(f64, bool)]) -> Option<f64> {
    let mut sorted = answers.to_vec();
    sorted.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let (mut right, mut rank_sum, mut before) = (0.0, 0.0, 0.0);
    for ties in sorted.chunk_by(|a, b| a.0 == b.0) {
        let here = ties.len() as f64;
        let right_here = ties.iter().filter(|answer| answer.1).count() as f64;
        rank_sum += right_here * (before + 0.5 * (here + 1.0));
        right += right_here;
        before += here;
    }
    let wrong = before - right;
    (right > 0.0 && wrong > 0.0).then(|| (rank_sum - 0.5 * right * (right + 1.0)) / (right * wrong))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::{any, prop, prop_assert, prop_assert_eq, proptest};

    #[test]
    fn answers_are_in_the_bin_whose_lower_edge_they_reach() {
        for bin in 0..BINS {
            assert_eq!(bin_of(lower_edge(bin)), bin);
            assert_eq!(bin_of(lower_edge(bin + 1).next_down()), bin);
        }
        assert_eq!((bin_of(1.0), bin_of(-0.5), bin_of(7.0), bin_of(f64::NAN)), (9, 0, 9, 0));
    }

    #[test]
    fn reliability_and_sure_answers_agree_with_a_hand_count() {
        let found = Confidence::of(&[(0.95, true), (0.9, false), (1.0, true), (0.35, false), (0.31, true)]);
        assert_eq!((found.sure, found.sure_right), (Proportion { hits: 3, of: 5 }, Proportion { hits: 2, of: 3 }));
        assert_eq!(found.reliability[9].right, Proportion { hits: 2, of: 3 });
        assert_eq!(found.reliability[3].right, Proportion { hits: 1, of: 2 });
        assert!((found.reliability[3].mean_confidence.expect("two answers") - 0.33).abs() < 1e-12);
        assert_eq!(found.reliability[0].mean_confidence, None);
        // Right 0.95, 1.0, 0.31 against wrong 0.9, 0.35: 2 + 2 + 0 of 6 pairs.
        assert!((found.auroc.expect("both kinds") - 4.0 / 6.0).abs() < 1e-12);
    }

    #[test]
    fn without_both_kinds_of_answers_there_is_no_auroc() {
        assert_eq!((auroc(&[]), auroc(&[(0.5, true)]), auroc(&[(0.5, false)])), (None, None, None));
    }

    proptest! {
        #[test]
        fn auroc_is_the_share_of_pairs_in_the_right_order(
            answers in prop::collection::vec((0u8..8, any::<bool>()), 0..40)
        ) {
            let answers: Vec<_> = answers.into_iter().map(|(c, right)| (f64::from(c) / 7.0, right)).collect();
            let (mut won, mut pairs) = (0.0, 0.0);
            for right in answers.iter().filter(|answer| answer.1) {
                for wrong in answers.iter().filter(|answer| !answer.1) {
                    pairs += 1.0;
                    won += if right.0 > wrong.0 { 1.0 } else if right.0 == wrong.0 { 0.5 } else { 0.0 };
                }
            }
            match auroc(&answers) {
                Some(found) => prop_assert!((found - won / pairs).abs() < 1e-12),
                None => prop_assert_eq!(pairs, 0.0),
            }
        }
    }
}
