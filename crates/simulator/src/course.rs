//! Shapes of tunnels: curved centrelines, and widths that vary along them.

use std::f64::consts::{PI, TAU};

use rand::RngExt;

use crosscut_stage::unit;

use crate::network::{Point, left_of};
use crate::noise::Generator;

/// Largest distance between points of a centreline, metres.
const STEP_M: f64 = 0.5;

/// A centreline from a place in a direction, with curvature `bend_rad_per_m`.
pub(crate) fn bent(from_m: Point, heading_rad: f64, length_m: f64, bend_rad_per_m: f64) -> Vec<Point> {
    let steps = (length_m / STEP_M).ceil().max(1.0) as usize;
    let step_m = length_m / steps as f64;
    let mut line = vec![from_m];
    for step in 0..steps {
        let middle_m = (step as f64 + 0.5) * step_m;
        line.push(line[step] + unit(heading_rad + bend_rad_per_m * middle_m) * step_m);
    }
    line
}

/// A centreline between two places that deviates from the straight line by `sway_m`·sin²(πs) at share s of its length.
pub(crate) fn swaying(from_m: Point, to_m: Point, sway_m: f64) -> Vec<Point> {
    let along = to_m - from_m;
    let steps = (along.norm() / STEP_M).ceil().max(2.0) as usize;
    let side = left_of(along.normalize()) * sway_m;
    (0..=steps)
        .map(|step| step as f64 / steps as f64)
        .map(|share| from_m + along * share + side * (PI * share).sin().powi(2))
        .collect()
}

/// Half widths along a centreline of `points` points: `half_width_m` with a sinusoidal `variation` (a share) whose
/// wavelength is about 10 m.
pub(crate) fn half_widths(points: usize, half_width_m: f64, variation: f64, rng: &mut Generator) -> Vec<f64> {
    let (phase_rad, wave_m) = (rng.random_range(0.0..TAU), rng.random_range(7.0..13.0));
    let swell = |point: usize| variation * (TAU * point as f64 * STEP_M / wave_m + phase_rad).sin();
    (0..points).map(|point| half_width_m * (1.0 + swell(point))).collect()
}
