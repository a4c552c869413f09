//! The method inside a robot's own program: one scan in, walls and openings out; no files, no threads, no viewer.
//!
//! `cargo run` in this folder.

use std::f32::consts::PI;

use crosscut_detector::stage::Opening;
use crosscut_detector::{Detector, LaserScan};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut detector = Detector::builder().vehicle_width_m(0.8).build()?;
    for scan in driver() {
        match detector.detect(&scan) {
            Ok(answer) => answer.openings.iter().for_each(steer),
            Err(failure) => eprintln!("{failure}"), // the next scan is as good as any
        }
    }
    Ok(())
}

/// A robot's own program has better use for it.
fn steer(opening: &Opening) {
    println!("an opening at {:.0}°, {:.1} m wide", opening.bearing_rad.to_degrees(), opening.width_m);
}

/// What a lidar sees in the middle of straight tunnels 6 m and 8 m wide; a driver would deliver this.
fn driver() -> impl Iterator<Item = LaserScan> {
    [6.0, 8.0].into_iter().map(tunnel_scan)
}

fn tunnel_scan(width_m: f32) -> LaserScan {
    let (beams, range_max) = (360, 15.0);
    let angle_increment = 2.0 * PI / beams as f32;
    let angle_min = -PI + 0.5 * angle_increment;
    let range = |beam: usize| {
        let range = width_m / 2.0 / (angle_min + beam as f32 * angle_increment).sin().abs();
        if range < range_max { range } else { f32::INFINITY }
    };
    LaserScan {
        angle_min,
        angle_max: PI - 0.5 * angle_increment,
        angle_increment,
        range_min: 0.1,
        range_max,
        ranges: (0..beams).map(range).collect(),
        ..Default::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tunnel_has_two_walls_and_two_openings() {
        let mut detector = Detector::builder().build().expect("the preset");
        for scan in driver() {
            let answer = detector.detect(&scan).expect("a sound scan");
            assert_eq!((answer.junctions, answer.openings.len()), (2, 2));
        }
        assert_eq!(detector.frame().affinity.weights.n(), 360);
    }
}
