//! Returns that hang in the air: dust, and mixed returns beside pillars.

use crate::Lengths;
use crate::mixed;
use crate::ring::Ring;

/// A return is compared with this many on either side. The outermost on either side does not count for "on both sides".
const REACH: usize = 4;
/// Two returns touch if they are nearer to each other than this many spacings of their beams.
const SPACINGS: f64 = 4.0;
/// A spacing counts as at least this long.
const LEAST_SPACING_M: f64 = 0.05;
/// Dust is nearer than the returns around it by at least this much.
const NEARER_M: f64 = 0.3;
/// At least this share of the returns around dust is farther.
const FARTHER_SHARE: f64 = 0.6;
/// A return that touches this many others is part of something.
const COMPANY: usize = 3;

/// Finds the returns that hang in the air; holds its buffers.
#[derive(Clone, Debug, Default)]
pub(crate) struct Dust {
    /// The ranges of the ring, and [`REACH`] more on either side: those around the turn, or NaN beyond the end of the
    /// view.
    ranges_m: Vec<f64>,
    is_dust: Vec<bool>,
}

impl Dust {
    /// For each return whether it hangs in the air: fewer than [`COMPANY`] of its neighbours touch it although most of
    /// them are farther, on both sides; or it is a mixed return beside a pillar. In a ring so small that a return is
    /// its own neighbour none does.
    pub(crate) fn find(&mut self, ring: &Ring, lengths: &Lengths) -> &[bool] {
        let n = ring.len();
        self.is_dust.clear();
        self.is_dust.resize(n, false);
        if n <= REACH {
            return &self.is_dust;
        }
        let range_m = |i: usize| ring.range_m(i);
        let beyond_m = |i: usize| if ring.full_turn { ring.range_m(i) } else { f64::NAN };
        self.ranges_m.clear();
        self.ranges_m.extend((n - REACH..n).map(beyond_m).chain((0..n).map(range_m)).chain((0..REACH).map(beyond_m)));
        for (i, (around_m, is_dust)) in self.ranges_m.windows(2 * REACH + 1).zip(&mut self.is_dust).enumerate() {
            let beside_m = [around_m[REACH - 1], around_m[REACH], around_m[REACH + 1]];
            *is_dust = (stands_out(around_m) && company(ring, i) < COMPANY)
                || mixed::is_beside_pillar(ring, i, beside_m, lengths);
        }
        &self.is_dust
    }
}

/// Whether most of the ranges around the middle one are larger, on both sides.
fn stands_out(around_m: &[f64]) -> bool {
    let farther_m = around_m[REACH] + NEARER_M;
    let is_farther = |range_m: &&f64| **range_m > farther_m;
    let some_farther = |ranges_m: &[f64]| ranges_m.iter().any(|range_m| is_farther(&range_m));
    // Few returns are nearer than a neighbour on either side, so this is false for most without a count.
    some_farther(&around_m[1..REACH]) && some_farther(&around_m[REACH + 1..2 * REACH]) && {
        let seen = around_m.iter().filter(|range_m| !range_m.is_nan()).count() - 1;
        around_m.iter().filter(is_farther).count() as f64 >= FARTHER_SHARE * seen as f64
    }
}

/// How many of its neighbours a return touches.
fn company(ring: &Ring, i: usize) -> usize {
    let reach = REACH as isize;
    let neighbours = (-reach..=reach).filter(|&step| step != 0).filter_map(|step| ring.after(i, step));
    neighbours.filter(|&j| touch(ring, i, j)).count()
}

/// Whether two returns may be of one surface.
pub(crate) fn touch(ring: &Ring, i: usize, j: usize) -> bool {
    let spacing_m = ring.range_m(i).min(ring.range_m(j)) * ring.step_rad * ring.beams_apart(i, j) as f64;
    ring.distance_m(i, j) < SPACINGS * spacing_m.max(LEAST_SPACING_M)
}
