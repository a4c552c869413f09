//! Mixed returns, of beams that met two things at once: an edge, and what is behind it.
//!
//! A beam has a width. One part of it meets the edge and the other what is behind, and many a lidar then tells a range in
//! between ("mixed pixels"; Tuley, Vandapel and Hebert 2005, "Analysis and Removal of Artifacts in 3-D LADAR Data"). One
//! alone cannot be told from the one return that is seen of a wall. So it is one only where that makes a difference: beside
//! a pillar, which it would tie to what is behind it, and in a way on, which it would close.

use super::Limits;
use super::gap::Judge;
use super::joining::LEAST_RETURNS;
use super::ring::Ring;

/// It lies at least so far behind the edge, and as far in front of what is behind that.
const BETWEEN_M: f64 = 0.5;
/// Beside a pillar: it leaves the lines that lead to those beside it, from so many returns before, by this share of the
/// distance, or more.
const LINES: isize = 2;
const OFF_LINE_SHARE: f64 = 0.25;
/// In a way on: it is so far off the lines of both walls.
const OFF_LINE_M: f64 = 0.2;

/// Whether a range is one of those between a near one and a far one.
fn is_between(near_m: f64, here_m: f64, far_m: f64) -> bool {
    near_m + BETWEEN_M < here_m && here_m + BETWEEN_M < far_m
}

/// Whether a return is a mixed one beside a pillar. `ranges_m` are that of the return before it, its own, and that of the one
/// after it; NaN where the view ends.
#[inline]
pub(super) fn is_beside_pillar(ring: &Ring, i: usize, ranges_m: [f64; 3], limits: &Limits) -> bool {
    let [before_m, here_m, after_m] = ranges_m;
    (is_between(before_m, here_m, after_m) && is_between_edge_and_behind(ring, i, -1, limits))
        || (is_between(after_m, here_m, before_m) && is_between_edge_and_behind(ring, i, 1, limits))
}

/// The same by all but the ranges, the edge of the pillar being the next return in this direction.
fn is_between_edge_and_behind(ring: &Ring, i: usize, to_edge: isize, limits: &Limits) -> bool {
    let [Some(edge), Some(behind)] = [to_edge, -to_edge].map(|direction| ring.after(i, direction)) else {
        return false;
    };
    is_off_line(ring, i, edge, to_edge)
        && is_off_line(ring, i, behind, -to_edge)
        && is_edge_of_pillar(ring, edge, to_edge, limits)
}

/// Whether a return is on no line of those from another on.
fn is_off_line(ring: &Ring, i: usize, other: usize, direction: isize) -> bool {
    (1..=LINES).all(|steps| {
        ring.after(other, direction * steps).is_some_and(|from| {
            let line = ring.position_m(other) - ring.position_m(from);
            let towards = ring.position_m(i) - ring.position_m(other);
            let along = line.dot(&towards);
            along <= 0.0 || line.perp(&towards).abs() > OFF_LINE_SHARE * along
        })
    })
}

/// Whether what goes on from a return in this direction is short, and stands in front of what is beyond it.
fn is_edge_of_pillar(ring: &Ring, edge: usize, direction: isize, limits: &Limits) -> bool {
    let mut last = edge;
    for returns in 1..ring.len() {
        let Some(next) = ring.after(edge, direction * returns as isize) else { return false };
        if ring.are_apart(last, next, limits.passage_m) {
            return returns >= LEAST_RETURNS && ring.range_m(last) + BETWEEN_M < ring.range_m(next);
        }
        if ring.are_apart(edge, next, limits.island_m) {
            return false;
        }
        last = next;
    }
    false
}

/// Whether a return between two pieces is a mixed one in a way on: by bearing, range and the lines of both it is of neither,
/// and without it a vehicle could pass.
pub(super) fn is_in_way(judge: &Judge<'_>, a: &[usize], lone: usize, b: &[usize]) -> bool {
    let ring = judge.ring;
    let (p, q) = (a[a.len() - 1], b[0]);
    let [p_m, lone_m, q_m] = [p, lone, q].map(|i| ring.range_m(i));
    let off_line_m = || {
        let [before, after] = judge.directions(a, b);
        let off_m = |from: usize, line| (ring.position_m(lone) - ring.position_m(from)).perp(&line).abs();
        Some(off_m(p, before?).min(off_m(q, after?)))
    };
    ring.beams_from(p, q) == 2
        && is_between(p_m.min(q_m), lone_m, p_m.max(q_m))
        && off_line_m().is_some_and(|off_m| off_m >= OFF_LINE_M)
        && judge.room_ratio_of_way(a, b).is_some()
}
