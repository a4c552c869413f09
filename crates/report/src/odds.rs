//! What the odds of the gaps mean for the answer.

use crosscut_stage::{Junction, Verdict};

/// The probability of what nothing is known of.
const NOTHING_KNOWN: f64 = 0.5;

/// Of a gap: whether the answer has an opening there; `None` where a return beside it is of no wall or of an island.
pub fn has_opening(verdict: &Verdict, answer: &Junction) -> Option<bool> {
    let wall = |number: u32| answer.wall_of_return[number as usize].filter(|&id| !answer.walls[id as usize].island);
    let [from, to] = [wall(verdict.returns[0])?, wall(verdict.returns[1])?];
    Some(from != to || answer.openings.iter().any(|opening| opening.shares_end_with(verdict.returns)))
}

/// How many gaps the answer is expected to decide wrongly: the sum of 1 - p over its openings and of p over the gaps within
/// its walls. Of an opening at which too little is seen for odds nothing is known, nor of openings without any verdict: one half.
pub(crate) fn wrong_gaps(verdicts: &[Verdict], answer: &Junction) -> f64 {
    if verdicts.is_empty() && !answer.openings.is_empty() {
        return NOTHING_KNOWN;
    }
    let wrong = |verdict: &Verdict| {
        let (p, is_opening) = (verdict.p.unwrap_or(NOTHING_KNOWN), has_opening(verdict, answer)?);
        Some(if is_opening { 1.0 - p } else { p })
    };
    verdicts.iter().filter_map(wrong).sum()
}

/// Sets p of each opening: the most of the gaps that begin or end where it does.
pub(crate) fn set_of_openings(verdicts: &[Verdict], answer: &mut Junction) {
    for opening in &mut answer.openings {
        let of_opening = verdicts.iter().filter(|verdict| opening.shares_end_with(verdict.returns));
        opening.p = of_opening.filter_map(|verdict| verdict.p).reduce(f64::max);
    }
}
