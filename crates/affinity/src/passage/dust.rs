//! Returns that hang in the air.

use super::ring::Ring;

/// How many returns to each side are looked at.
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
    let (mut seen, mut touching, mut farther, mut farther_aside) = (0, 0, 0, [false; 2]);
    for step in (1..=REACH).flat_map(|step| [-step, step]) {
        let Some(j) = ring.after(i, step).filter(|&j| j != i) else { continue };
        let spacing_m = ring.range_m(i).min(ring.range_m(j)) * ring.step_rad * ring.beams_apart(i, j) as f64;
        seen += 1;
        touching += usize::from(ring.distance_m(i, j) < SPACINGS * spacing_m.max(SLACK_M) + SLACK_M);
        if ring.range_m(j) > ring.range_m(i) + NEARER_M {
            farther += 1;
            farther_aside[usize::from(step > 0)] |= step.abs() < REACH;
        }
    }
    touching < COMPANY && f64::from(farther) >= FARTHER_SHARE * f64::from(seen) && farther_aside == [true; 2]
}
