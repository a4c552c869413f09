//! Returns that hang in the air.

use super::ring::Ring;

/// The returns that are looked at, nearest first.
const STEPS: [isize; 8] = [-1, 1, -2, 2, -3, 3, -4, 4];
/// The outermost say nothing of both sides.
const REACH: isize = 4;
/// Two returns this many beam spacings apart, plus [`SLACK_M`], are in touch.
const SPACINGS: f64 = 4.0;
const SLACK_M: f64 = 0.05;
/// Dust is nearer than what is around it by at least this much.
const NEARER_M: f64 = 0.3;
/// Share of the returns around it that are farther.
const FARTHER_SHARE: f64 = 0.6;
/// A return that so many others touch is part of something: the degree at which it counts.
const COMPANY: usize = 3;

/// Marks the returns that fewer than [`COMPANY`] of their neighbours touch although most of these are farther, on both
/// sides.
pub(super) fn mark(ring: &Ring, dust: &mut Vec<bool>) {
    dust.clear();
    dust.extend((0..ring.len()).map(|i| is_dust(ring, i)));
}

fn is_dust(ring: &Ring, i: usize) -> bool {
    // Nearest first: along a wall these touch, and no more needs to be known.
    let neighbours = || STEPS.into_iter().filter_map(|step| Some((step, ring.after(i, step).filter(|&j| j != i)?)));
    let mut touching = neighbours().filter(|&(_, j)| in_touch(ring, i, j));
    if touching.nth(COMPANY - 1).is_some() {
        return false;
    }
    let (mut seen, mut farther, mut farther_aside) = (0, 0, [false; 2]);
    for (step, j) in neighbours() {
        seen += 1;
        if ring.range_m(j) > ring.range_m(i) + NEARER_M {
            farther += 1;
            farther_aside[usize::from(step > 0)] |= step.abs() < REACH;
        }
    }
    f64::from(farther) >= FARTHER_SHARE * f64::from(seen) && farther_aside == [true; 2]
}

fn in_touch(ring: &Ring, i: usize, j: usize) -> bool {
    let spacing_m = ring.range_m(i).min(ring.range_m(j)) * ring.step_rad * ring.beams_apart(i, j) as f64;
    ring.distance_m(i, j) < SPACINGS * spacing_m.max(SLACK_M) + SLACK_M
}
