//! The gap at which another decision gives the nearest other count.

use crosscut_stage::Frame;

use crate::change::Change;
use crate::judged::{Judged, judged};

/// A verdict whose room differs from what an opening needs by more than this factor is not near to another one.
const NEAR: f64 = 10.0;

/// The gap at which another decision gives the nearest other count.
#[derive(Clone, Debug, PartialEq)]
pub struct Nearest {
    /// The count that there would be.
    pub count: usize,
    /// Two walls that would be one, or one that would be two.
    pub walls: Vec<u32>,
    /// The returns on both sides of the gap.
    pub returns: [usize; 2],
    /// From one to the other, metres.
    pub gap_m: f64,
}

/// By the verdict nearest to its threshold where an affinity decides gap by gap, else by the smallest change of τ that an
/// edge explains, else by the two closest walls.
pub(crate) fn nearest(frame: &Frame, changes: &[Change], closest: Option<([u32; 2], [usize; 2])>) -> Option<Nearest> {
    let (points_m, count) = (&frame.revolution.points_m, frame.junction.junctions);
    let is_island = |wall: u32| frame.junction.walls.iter().any(|other| other.id == wall && other.island);
    let near = |walls: &[u32], returns: [usize; 2]| {
        let [a, b] = returns.map(|i| points_m.get(i));
        let count = if walls.len() > 1 { count.saturating_sub(1) } else { count + 1 };
        let of = Nearest { count, walls: walls.to_vec(), returns, gap_m: (a? - b?).norm() };
        (!walls.iter().copied().any(is_island)).then_some(of)
    };
    let by_verdict = |Judged { verdict, walls: [a, b], .. }: Judged| {
        let returns = verdict.returns.map(|i| i as usize);
        match (a?, b?, verdict.is_opening) {
            (a, b, true) if a != b => near(&[a, b], returns),
            (a, b, false) if a == b => near(&[a], returns),
            _ => None,
        }
    };
    let verdicts = judged(frame).into_iter().filter(|judged| judged.doubt() < NEAR.ln());
    let by_change = || changes.iter().find_map(|change| near(&change.walls, change.edge?.returns));
    let by_distance = || closest.and_then(|(walls, returns)| near(&walls, returns));
    verdicts.into_iter().find_map(by_verdict).or_else(by_change).or_else(by_distance)
}
