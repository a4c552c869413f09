//! Generator of figures of the docs: the share of scenes of the family `wet` that no single scan can decide, because a
//! patch of lost beams in a wall looks like the mouth of a branch.
//! `cargo run --release -p crosscut-simulator --example undecidable`
//!
//! Each run of lost beams between two returns of one wall is examined. A straight branch with parallel sides, of the width
//! and the least angle to the wall in the table, explains the run if its mouth fits between those two returns, and all
//! beams of the run but two reach the end of the range in it without meeting its sides; two may be lost by chance. Branches
//! are tried in steps of a quarter of a beam and 5 cm. The branches of the family itself are at least 5 m wide, and 54°
//! apart.

use std::f64::consts::TAU;

use crosscut_simulator::{Scene, Split, suites};

const WIDTHS_M: [f64; 5] = [0.6, 0.8, 1.0, 1.2, 1.6];
const LOST_BY_CHANCE: usize = 2;
const LEAST_ANGLES_DEG: [f64; 3] = [0.0, 30.0, 54.0];
/// The range of the lidar of every family.
const RANGE_M: f64 = 15.0;
/// A branch bends by at most this between 8 m, where its bearing is measured, and the end of the range.
const BEND_RAD: f64 = 0.35;

type Point = [f64; 2];

/// Beams without a return, between two returns of one wall.
struct Run {
    bearings_rad: Vec<f64>,
    ends_m: [Point; 2],
}

fn main() {
    let wet = suites().iter().find(|suite| suite.name == "wet").expect("it is one of the suites");
    let scenes: Vec<Vec<Run>> = wet.scenes(Split::Dev).map(|scene| runs(&scene)).collect();
    println!("% of {} scenes that no scan decides, by width and angle of the branch", scenes.len());
    println!("{:>10}{}", "", LEAST_ANGLES_DEG.map(|angle_deg| format!("{angle_deg:>9.0}°")).concat());
    for width_m in WIDTHS_M {
        let shares = LEAST_ANGLES_DEG.map(|angle_deg| {
            let explained = |runs: &&Vec<Run>| runs.iter().any(|run| explained(run, width_m, angle_deg.to_radians()));
            format!("{:>10.1}", 100.0 * scenes.iter().filter(explained).count() as f64 / scenes.len() as f64)
        });
        println!("{width_m:>8.1} m{}", shares.concat());
    }
}

fn runs(scene: &Scene) -> Vec<Run> {
    let (scan, labels) = (&scene.scan, &scene.truth.labels);
    let n = labels.len();
    let bearing_rad = |beam: usize| f64::from(scan.angle_min) + beam as f64 * f64::from(scan.angle_increment);
    let at_m = |beam: usize| {
        let (range_m, bearing_rad) = (f64::from(scan.ranges[beam % n]), bearing_rad(beam));
        [range_m * bearing_rad.cos(), range_m * bearing_rad.sin()]
    };
    let on_wall: Vec<usize> = (0..n).filter(|&beam| labels[beam] >= 0).collect();
    let pairs = (0..on_wall.len()).map(|i| (on_wall[i], on_wall.get(i + 1).copied().unwrap_or(on_wall[0] + n)));
    // At a dead end the opening is between two returns of the only wall, near its bearing.
    let has_opening = |from: usize, to: usize| {
        let near = |opening: f64| (opening - bearing_rad(from) + BEND_RAD).rem_euclid(TAU);
        let width_rad = bearing_rad(to) - bearing_rad(from) + 2.0 * BEND_RAD;
        scene.truth.walls == 1 && scene.truth.openings.iter().any(|opening| near(opening.bearing_rad) < width_rad)
    };
    let patches = pairs.filter(|&(from, to)| to > from + 1 && labels[from] == labels[to % n] && !has_opening(from, to));
    patches
        .map(|(from, to)| Run {
            bearings_rad: (from + 1..to).map(bearing_rad).collect(),
            ends_m: [at_m(from), at_m(to)],
        })
        .collect()
}

/// Whether a branch of this width and at least this angle explains the run.
fn explained(run: &Run, width_m: f64, least_angle_rad: f64) -> bool {
    let (first, last) = (run.bearings_rad[0], run.bearings_rad[run.bearings_rad.len() - 1]);
    let step_rad = TAU / 360.0 / 4.0;
    let steps = ((last - first) / step_rad) as usize;
    let axes = (0..=steps + 16).map(|step| first + (step as f64 - 8.0) * step_rad);
    axes.into_iter().any(|axis_rad| {
        // Coordinates of the ends of the run across the axis of the branch, to the left, and along it.
        let [right_m, left_m] = run.ends_m.map(|[x_m, y_m]| y_m * axis_rad.cos() - x_m * axis_rad.sin());
        let [near_m, far_m] = run.ends_m.map(|[x_m, y_m]| x_m * axis_rad.cos() + y_m * axis_rad.sin());
        if (left_m - right_m).atan2((far_m - near_m).abs()) < least_angle_rad {
            return false;
        }
        let places = ((left_m - right_m - width_m) / 0.05).floor();
        (0..=places as i64).take_while(|_| places >= 0.0).any(|place| {
            let side_m = right_m + 0.05 * place as f64;
            let unseen = |bearing_rad: &&f64| {
                let off_axis_m = RANGE_M * (*bearing_rad - axis_rad).sin();
                (side_m..side_m + width_m).contains(&off_axis_m)
            };
            run.bearings_rad.len() - run.bearings_rad.iter().filter(unseen).count() <= LOST_BY_CHANCE
        })
    })
}
