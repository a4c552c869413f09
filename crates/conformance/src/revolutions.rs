//! Random revolutions: sweeps of a lidar that sees pieces of wall, and clouds without beams.

use std::f64::consts::{PI, TAU};
use std::ops::Range;

use crosscut_stage::{Beam, Point, Revolution, Sweep, wrap_angle_rad};
use proptest::collection::vec;
use proptest::prelude::{Strategy, any, prop_oneof};

/// A sweep of `beams` beams: runs of beams that hit a wall at one distance (rough to 5 cm), have no return, or are
/// unreadable; either direction of turning, a full turn or a part of it.
pub fn scan(beams: Range<usize>) -> impl Strategy<Value = Revolution> {
    let run = (prop_oneof![3 => 0.3..15.0f64, 1 => -2.0..0.0f64], 1..12usize);
    let shape = (-PI..PI, any::<bool>(), any::<bool>());
    (vec(run, 1..20), vec(-0.05..0.05f64, beams), shape).prop_map(
        |(runs, rough_m, (start_rad, full_turn, clockwise))| {
            let step_rad = if full_turn { TAU / rough_m.len().max(1) as f64 } else { 0.01 };
            let turn = if clockwise { -1.0 } else { 1.0 };
            let along_runs = runs.iter().cycle().flat_map(|&(range_m, beams)| std::iter::repeat_n(range_m, beams));
            let mut revolution = Revolution::default();
            let mut sweep = Sweep { step_rad, full_turn, range_max_m: 15.0, ..Sweep::default() };
            for ((beam, rough_m), run_m) in rough_m.iter().enumerate().zip(along_runs) {
                let bearing_rad = wrap_angle_rad(start_rad + turn * beam as f64 * step_rad);
                sweep.bearings_rad.push(bearing_rad);
                sweep.beams.push(if run_m > 0.0 {
                    let (range_m, (sin, cos)) = (run_m + rough_m, bearing_rad.sin_cos());
                    revolution.points_m.push(Point::new(range_m * cos, range_m * sin, 0.0));
                    Beam::Return(revolution.points_m.len() as u32 - 1)
                } else if run_m > -1.0 {
                    Beam::NoReturn
                } else {
                    Beam::Unknown
                });
            }
            revolution.sweep = Some(sweep);
            revolution
        },
    )
}

/// A cloud of `points` points in R³: a few clumps, a third of their points twice.
pub fn cloud(points: Range<usize>) -> impl Strategy<Value = Revolution> {
    let coordinates = |reach_m: f64| [-reach_m..reach_m, -reach_m..reach_m, -reach_m..reach_m];
    (vec(coordinates(10.0), 1..6), vec(coordinates(0.8), points)).prop_map(|(centres_m, offsets_m)| {
        let mut points_m: Vec<Point> = Vec::new();
        for (i, offset_m) in offsets_m.iter().enumerate() {
            let centre_m = centres_m[i % centres_m.len()];
            let point = Point::new(centre_m[0] + offset_m[0], centre_m[1] + offset_m[1], centre_m[2] + offset_m[2]);
            points_m.push(if i % 3 == 2 { points_m[i - 1] } else { point });
        }
        Revolution { points_m, ..Revolution::default() }
    })
}
