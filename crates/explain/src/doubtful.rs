//! The wall that may be none.

use crosscut_stage::{Frame, Verdict, Wall};

/// A wall of at most this many returns may be none.
pub(crate) const FEW: usize = 3;

/// The wall that may be none: one of [`FEW`] returns; else, where an affinity decides gap by gap, one that stands inside a gap, so
/// that no verdict joins it to the others or parts it from them.
pub(crate) fn may_be_none(frame: &Frame) -> Option<&Wall> {
    let (junction, verdicts) = (&frame.junction, &frame.affinity.verdicts);
    let counts = || junction.walls.iter().filter(|wall| !wall.island && junction.junctions > 1);
    let is_of = |verdict: &Verdict, id: u32| {
        verdict.returns.iter().any(|i| junction.wall_of_return.get(*i as usize) == Some(&Some(id)))
    };
    let is_free = |wall: &&Wall| !verdicts.is_empty() && !verdicts.iter().any(|verdict| is_of(verdict, wall.id));
    let small = counts().filter(|wall| wall.returns <= FEW).min_by_key(|wall| wall.returns);
    small.or_else(|| counts().filter(is_free).min_by_key(|wall| wall.returns))
}
