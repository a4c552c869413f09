//! What the odds of the gaps mean for the answer.

use crosscut_stage::{Junction, Opening, Revolution, Verdict};

use crate::confidence::is_at_opening;

/// Of a gap: whether the answer has an opening there; `None` where a return beside it is of no wall or of an island.
pub fn has_opening(verdict: &Verdict, revolution: &Revolution, answer: &Junction) -> Option<bool> {
    let wall = |number: u32| answer.wall_of_return[number as usize].filter(|&id| !answer.walls[id as usize].island);
    let [from, to] = [wall(verdict.returns[0])?, wall(verdict.returns[1])?];
    Some(from != to || is_at_edge(verdict, revolution, &answer.openings))
}

/// The probability that the answer is right at every gap, if each is decided for itself: the product of p over its openings
/// and of 1 - p over the gaps within its walls. Of openings without any verdict nothing is known: one half.
pub(crate) fn of_answer(verdicts: &[Verdict], revolution: &Revolution, answer: &Junction) -> f64 {
    if verdicts.is_empty() && !answer.openings.is_empty() {
        return 0.5;
    }
    let right = |verdict: &Verdict| {
        let (p, is_way) = (verdict.p?, has_opening(verdict, revolution, answer)?);
        Some(if is_way { p } else { 1.0 - p })
    };
    verdicts.iter().filter_map(right).product()
}

/// Sets p of each opening: the most of the gaps that lead from the one wall beside it, or to the other.
pub(crate) fn set_of_openings(verdicts: &[Verdict], revolution: &Revolution, answer: &mut Junction) {
    let Junction { openings, wall_of_return, .. } = answer;
    for opening in openings {
        let [clockwise, anticlockwise] = opening.walls;
        let is_of = |verdict: &&Verdict| {
            let [from, to] = verdict.returns.map(|number| wall_of_return[number as usize]);
            if clockwise == anticlockwise {
                is_at_edge(verdict, revolution, std::slice::from_ref(opening))
            } else {
                from != to && (from == Some(clockwise) || to == Some(anticlockwise))
            }
        };
        let most = verdicts.iter().filter(is_of).filter_map(|verdict| verdict.p).reduce(f64::max);
        opening.p = most;
    }
}

fn is_at_edge(verdict: &Verdict, revolution: &Revolution, openings: &[Opening]) -> bool {
    let ends_m = verdict.returns.map(|number| revolution.points_m[number as usize].coords.xy());
    is_at_opening(ends_m, openings)
}
