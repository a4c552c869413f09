//! How many returns a beam of a cloud has as a rule: what tells a wall from dust.

use std::f64::consts::TAU;

use crate::{Revolution, wrap_angle_rad};

/// What a beam meets has so large a share of the returns that a beam has as a rule. Fewer are dust, or a cable.
const SHARE: f64 = 0.25;
/// The rule is known at ranges from the vehicle on, each so many times the one before.
const RANGES: usize = 28;
const STEP: f64 = 1.25;

/// Beams all around, as wide as the angle from one to the next.
pub(super) struct Fan {
    /// The bearing of the middle of the first one.
    pub(super) first_rad: f64,
    pub(super) beams: usize,
}

impl Fan {
    /// The beam of a bearing.
    pub(super) fn beam(&self, bearing_rad: f64) -> usize {
        let offset_rad = wrap_angle_rad(bearing_rad - self.first_rad);
        let offset = (offset_rad / TAU * self.beams as f64).round() as isize;
        offset.rem_euclid(self.beams as isize) as usize
    }
}

/// The number of returns, at whatever range, that a beam has in the angles |z| / range <= height / (2r) that are level at a
/// range r: the median over the beams that have any, at each of [`RANGES`] ranges r.
#[derive(Clone, Debug, Default)]
pub(super) struct Usual {
    nearest_m: f64,
    medians: Vec<u32>,
    /// Of each return that is level at some range.
    beams: Vec<u32>,
    /// Beam by beam, the number at each range.
    counts: Vec<u32>,
    sorted: Vec<u32>,
}

impl Usual {
    /// Looks at all returns of `cloud`, of these ranges in the plane.
    pub(super) fn measure(&mut self, cloud: &Revolution, ranges_m: &[f64], fan: &Fan, height_m: f64, width_m: f64) {
        self.nearest_m = width_m / 2.0;
        self.counts.clear();
        self.counts.resize(fan.beams * RANGES, 0);
        self.beams.clear();
        self.beams.resize(cloud.len(), 0);
        for (i, (point, range_m)) in cloud.points_m.iter().zip(ranges_m).enumerate() {
            let level_to_m = height_m / 2.0 * range_m / point.z.abs();
            if let Some(at) = self.at(level_to_m) {
                let beam = fan.beam(cloud.bearing_rad(i));
                self.beams[i] = beam as u32;
                self.counts[beam * RANGES + at] += 1;
            }
        }
        // What is level at a range is so at all nearer ones.
        for of_beam in self.counts.chunks_exact_mut(RANGES) {
            (1..RANGES).rev().for_each(|at| of_beam[at - 1] += of_beam[at]);
        }
        self.medians.clear();
        for at in 0..RANGES {
            self.sorted.clear();
            self.sorted.extend(self.counts[at..].iter().step_by(RANGES).filter(|&&count| count > 0));
            self.sorted.sort_unstable();
            self.medians.push(self.sorted.get(self.sorted.len() / 2).copied().unwrap_or(0));
        }
    }

    /// The beam of a return that is level, or would be at a smaller range.
    pub(super) fn beam(&self, number: u32) -> usize {
        self.beams[number as usize] as usize
    }

    /// How many returns at this range are more than dust.
    pub(super) fn enough(&self, range_m: f64) -> usize {
        let median = self.at(range_m).map_or(0, |at| self.medians[at]);
        ((SHARE * f64::from(median)).ceil() as usize).max(1)
    }

    /// The last of the ranges that is not beyond this one; `None` within the vehicle, and for what is no range.
    fn at(&self, range_m: f64) -> Option<usize> {
        let steps = (range_m / self.nearest_m).ln() / STEP.ln();
        (steps >= 0.0).then(|| (steps as usize).min(RANGES - 1))
    }
}
