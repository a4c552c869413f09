//! Places of all widths with lidars of all kinds, so that nothing was fitted to their mixture.

use crosscut_simulator::lidar::Lidar;
use crosscut_simulator::{Places, Scene};

const SEED: u64 = 1 << 61;

/// Fractions that fill [0, 1)^d evenly: the n-th is the fractional part of n times these, powers of the inverse of the
/// root of x^10 = x + 1.
const STEP: f64 = 1.0 / 1.075_766_066_086_837;

/// The `index`-th place of the mixture.
pub(crate) fn scene(index: u64) -> Scene {
    let share = |dimension: i32| (index as f64 * STEP.powi(dimension)).fract();
    let between = |dimension: i32, [from, to]: [f64; 2]| from + (to - from) * share(dimension);
    // In half of the places, a share of up to `most`.
    let in_half = |dimension: i32, most: f64| (between(dimension, [-most, most])).max(0.0);
    let width_m = 1.2 * (8.0_f64 / 1.2).powf(share(1));
    let beams_all_around = 180.0 * 8.0_f64.powf(share(2));
    // A turn that is 5° short is read as full.
    let view_deg = Some(between(3, [180.0, 540.0])).filter(|view_deg| *view_deg < 355.0).unwrap_or(360.0);
    let lidar = Lidar {
        beams: (beams_all_around * view_deg / 360.0) as usize,
        field_of_view_rad: view_deg.to_radians(),
        range_max_m: between(4, [10.0, 25.0]),
        loss: in_half(5, 0.3),
        patch_share: in_half(6, 0.15),
        dust: in_half(7, 0.04),
        ..Lidar::CLEAN
    };
    let bump_sd_m = width_m * between(8, [0.01, 0.06]);
    let pillars = if width_m > 4.0 && share(9) < 0.3 { [1, 2] } else { [0, 0] };
    let places = Places {
        width_m: [0.8 * width_m, 1.2 * width_m],
        off_centre: [0.0, 0.35],
        bumps_m: [bump_sd_m, 1.0],
        pillars,
        lidar,
    };
    places.scene(1 + index as usize % 5, SEED + index, 0)
}
