//! What makes answers of preset `default` doubtful, on scenes computed by hand.

use std::f64::consts::TAU;

use crosscut_detector::{Detector, LaserScan};
use crosscut_stage::SURE;

const BEAMS: usize = 360;

/// A dead end 3.5 m wide whose end is 4 m ahead; beams to the last `lost_m` of its left wall come back with nothing.
fn dead_end(lost_m: f64) -> LaserScan {
    let (half_m, end_m) = (1.75, 4.0);
    let range = |beam: usize| {
        let (sin, cos) = ((beam as f64 + 0.5) / BEAMS as f64 * TAU).sin_cos();
        let (side_m, ahead_m) = (half_m / sin.abs(), if cos > 0.0 { end_m / cos } else { f64::INFINITY });
        let is_lost = sin > 0.0 && side_m < ahead_m && side_m * cos > end_m - lost_m;
        if is_lost { f32::INFINITY } else { side_m.min(ahead_m) as f32 }
    };
    let step = TAU / BEAMS as f64;
    LaserScan {
        angle_min: (0.5 * step) as f32,
        angle_increment: step as f32,
        range_max: 30.0,
        ranges: (0..BEAMS).map(range).collect(),
        ..LaserScan::default()
    }
}

#[test]
fn the_more_of_a_wall_is_lost_the_less_sure_is_a_dead_end() {
    let mut detector = Detector::builder().build().expect("the preset");
    let mut confidence = |lost_m: f64| {
        let junction = detector.detect(&dead_end(lost_m)).expect("a scan");
        assert_eq!(junction.junctions, 1, "{lost_m} m lost");
        junction.confidence.expect("calibrated")
    };
    let [none, some, more] = [0.0, 0.8, 1.2].map(&mut confidence);
    assert!(none >= SURE, "a dead end of which all is seen: {none}");
    assert!(some < none && more < some, "{none}, {some} and {more}");
}
