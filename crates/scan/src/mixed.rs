//! Mixed returns: a beam meets an edge and the surface behind it at once.
//!
//! A beam has a width. If one part of it meets the edge and the other part the surface behind, many lidars report a range
//! in between ("mixed pixels"; Tuley, Vandapel and Hebert 2005, "Analysis and Removal of Artifacts in 3-D LADAR Data").
//! One mixed return looks like a single return of a wall. So a return is taken for mixed only where it makes a
//! difference: beside a pillar, which it would join to the wall behind; and, by affinity `passage`, in an opening, which
//! it would close.

use crate::Lengths;
use crate::pieces::LEAST_WALL_RETURNS;
use crate::ring::Ring;

/// The least distance, along the beam, of a mixed return from the edge before it and from the surface behind it.
const BETWEEN_M: f64 = 0.5;
/// Beside a pillar, a mixed return lies off the lines from this many returns to the neighbour on either side.
const LINES: isize = 2;
/// Beside a pillar, a mixed return lies off such a line by at least this share of its distance along the line.
const OFF_LINE_SHARE: f64 = 0.25;

/// Whether a range lies between a near and a far one, as the range of a mixed return does.
pub fn is_between(near_m: f64, here_m: f64, far_m: f64) -> bool {
    near_m + BETWEEN_M < here_m && here_m + BETWEEN_M < far_m
}

/// Whether a return is a mixed one beside a pillar. `ranges_m` are those of the return before it, its own, and that of
/// the return after it; NaN beyond the end of the view.
#[inline]
pub(crate) fn is_beside_pillar(ring: &Ring, i: usize, ranges_m: [f64; 3], lengths: &Lengths) -> bool {
    let [before_m, here_m, after_m] = ranges_m;
    (is_between(before_m, here_m, after_m) && lies_off_pillar(ring, i, -1, lengths))
        || (is_between(after_m, here_m, before_m) && lies_off_pillar(ring, i, 1, lengths))
}

/// Whether the next return in this direction is the edge of a pillar, and return `i` is neither on a line of the pillar
/// nor on one of what is behind.
fn lies_off_pillar(ring: &Ring, i: usize, to_edge: isize, lengths: &Lengths) -> bool {
    let [Some(edge), Some(behind)] = [to_edge, -to_edge].map(|direction| ring.after(i, direction)) else {
        return false;
    };
    is_off_lines(ring, i, edge, to_edge)
        && is_off_lines(ring, i, behind, -to_edge)
        && is_edge_of_pillar(ring, edge, to_edge, lengths)
}

/// Whether a return is off the lines that lead to its neighbour `other` from the returns behind that.
fn is_off_lines(ring: &Ring, i: usize, other: usize, direction: isize) -> bool {
    (1..=LINES).all(|steps| {
        ring.after(other, direction * steps).is_some_and(|from| {
            let line = ring.position_m(other) - ring.position_m(from);
            let towards = ring.position_m(i) - ring.position_m(other);
            let along = line.dot(&towards);
            along <= 0.0 || line.perp(&towards).abs() > OFF_LINE_SHARE * along
        })
    })
}

/// Whether the piece that begins at a return, in this direction, is short and stands in front of what is beyond it.
fn is_edge_of_pillar(ring: &Ring, edge: usize, direction: isize, lengths: &Lengths) -> bool {
    let mut last = edge;
    for returns in 1..ring.len() {
        let Some(next) = ring.after(edge, direction * returns as isize) else { return false };
        if ring.are_apart(last, next, lengths.passage_m) {
            return returns >= LEAST_WALL_RETURNS && ring.range_m(last) + BETWEEN_M < ring.range_m(next);
        }
        if ring.are_apart(edge, next, lengths.island_m) {
            return false;
        }
        last = next;
    }
    false
}
