//! How rough walls are, and how inexact ranges.

use proptest::prelude::{prop_assert, proptest};

use crate::{range_m, room, scan_of};

const BEAMS: usize = 360;

/// Deviations with a variance of 1: sums of three numbers that are even in [-1, 1].
fn deviations(seed: u64) -> Vec<f64> {
    let mut state = seed;
    let mut even = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    };
    (0..2 * BEAMS).map(|_| even() + even() + even()).collect()
}

proptest! {
    #[test]
    fn the_roughness_of_sigma_noise_is_sigma(seed: u64, sigma_m in 0.01..0.1f64, half_m in 4.0..9.0f64) {
        // Returns are 7 cm apart and more, so that bumps of this size are of the wall, and not of the lidar.
        let (walls, deviations) = (room(half_m), deviations(seed));
        let rough = scan_of(BEAMS, |beam, bearing_rad| {
            let across = bearing_rad.cos().abs().max(bearing_rad.sin().abs());
            range_m(&walls, bearing_rad) + sigma_m * deviations[beam] / across
        });
        let found_m = rough.roughness.sd_m;
        prop_assert!((0.75..1.25).contains(&(found_m / sigma_m)), "{found_m} m instead of {sigma_m} m");
        prop_assert!(rough.roughness.range_error.is_none(), "no returns are dense");
    }

    #[test]
    fn inexact_ranges_are_no_roughness(seed: u64, share in 0.002..0.02f64) {
        // A tunnel: of a room this small, every stretch would have a corner in it.
        let walls = [-1.5, 1.5].map(|y_m| [[-20.0, y_m], [20.0, y_m]]);
        let deviations = deviations(seed);
        let inexact = scan_of(2 * BEAMS, |beam, bearing_rad| {
            range_m(&walls, bearing_rad) * (1.0 + share * deviations[beam])
        });
        let found = inexact.roughness.range_error.expect("many returns are dense");
        prop_assert!((0.6..1.4).contains(&(found / share)), "{found} instead of {share}");
        prop_assert!(inexact.roughness.sd_m < 1.5 * share, "{} m", inexact.roughness.sd_m);
    }
}

#[test]
fn flat_walls_are_not_rough() {
    let walls = room(3.0);
    let flat = scan_of(BEAMS, |_, bearing_rad| range_m(&walls, bearing_rad));
    assert!(flat.roughness.sd_m < 1e-6, "{}", flat.roughness.sd_m);
    assert!((flat.size_m - 3.3).abs() < 0.3, "the median range of a room of 3 m: {}", flat.size_m);
}
