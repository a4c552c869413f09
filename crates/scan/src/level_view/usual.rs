//! How many returns a beam of a cloud usually has: what tells a wall from dust.

use crate::median;

/// A beam that met a wall has at least this share of the usual number of returns. With fewer it met dust, or a cable.
const SHARE: f64 = 0.25;
/// The usual number is known at this many ranges, from the vehicle outward.
const RANGES: usize = 28;
/// Each of these ranges is this many times the one before.
const STEP: f64 = 1.25;

/// The number of returns, at whatever range, that a beam has in the angles |z| / range <= height / (2r) that are level
/// at a range r: the median over the beams that have any, at each of [`RANGES`] ranges r.
#[derive(Clone, Debug, Default)]
pub(super) struct Usual {
    ranges_m: [f64; RANGES],
    medians: [u32; RANGES],
    /// Beam by beam, the number at each range.
    counts: Vec<[u32; RANGES]>,
    /// The numbers of all beams at one range.
    of_beams: Vec<u32>,
}

impl Usual {
    /// Begins to count the returns of this many beams, at ranges from the nearest on.
    pub(super) fn begin(&mut self, beams: usize, nearest_m: f64) {
        self.ranges_m = std::array::from_fn(|at| nearest_m * STEP.powi(at as i32));
        self.counts.clear();
        self.counts.resize(beams, [0; RANGES]);
    }

    /// Counts a return of a beam that is level at the first `ranges` ranges, at least one.
    pub(super) fn count(&mut self, beam: usize, ranges: usize) {
        self.counts[beam][ranges - 1] += 1;
    }

    /// Takes the medians of what was counted.
    pub(super) fn end(&mut self) {
        // An angle that is level at a range is level at all nearer ones.
        for of_beam in &mut self.counts {
            (1..RANGES).rev().for_each(|at| of_beam[at - 1] += of_beam[at]);
        }
        for (at, of_range) in self.medians.iter_mut().enumerate() {
            self.of_beams.clear();
            self.of_beams.extend(self.counts.iter().map(|of_beam| of_beam[at]).filter(|&count| count > 0));
            *of_range = median(&mut self.of_beams, u32::cmp);
        }
    }

    /// How many returns a beam needs for a wall at this range.
    pub(super) fn enough(&self, range_m: f64) -> usize {
        let median = self.ranges_to(range_m).checked_sub(1).map_or(0, |at| self.medians[at]);
        ((SHARE * f64::from(median)).ceil() as usize).max(1)
    }

    /// How many of the ranges are not beyond this one; none within the vehicle.
    pub(super) fn ranges_to(&self, range_m: f64) -> usize {
        self.ranges_m.partition_point(|&at_m| at_m <= range_m)
    }
}
