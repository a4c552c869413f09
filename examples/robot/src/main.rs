//! The method inside a robot's own program: one scan in, walls and openings out; no files, no threads, no viewer.
//!
//! `cargo run` in this folder.

use std::error::Error;
use std::f32::consts::PI;

use crosscut_pipeline::{Frame, LaserScan, Preset, Settings};

fn main() -> Result<(), Box<dyn Error>> {
    // Once, at start: which stages to run, and how wide the vehicle is; `sensor_yaw_rad` and others say how the lidar is mounted.
    let settings = Settings::new(Preset::Default).vehicle_width_m(0.8);
    let (sensor, mut engine) = (settings.sensor()?, settings.engine()?);
    let mut frame = Frame::default();

    // For every `scan: LaserScan` that the driver delivers; the frame's buffers are used again.
    for scan in [tunnel_scan(6.0), tunnel_scan(8.0)] {
        frame.notes.clear();
        sensor.revolution(&scan, &mut frame.revolution, &mut frame.notes);
        if let Err(failure) = engine.process(&mut frame) {
            eprintln!("{failure}"); // the next scan is as good as any
            continue;
        }
        let junction = &frame.junction;
        let confidence = junction.confidence.unwrap_or(0.0); // an affinity of your own has none
        println!("{} walls, {}, confidence {confidence:.2}", junction.junctions, junction.place);
        for opening in &junction.openings {
            let bearing_deg = opening.bearing_rad.to_degrees();
            println!("  an opening at {bearing_deg:.0}°, {:.1} m wide, {}", opening.width_m, opening.evidence);
        }
    }
    Ok(())
}

/// What a lidar sees in the middle of a straight tunnel; a driver would deliver this.
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
        let settings = Settings::new(Preset::Default);
        let (sensor, mut engine) = (settings.sensor().expect("allowed"), settings.engine().expect("allowed"));
        let mut frame = Frame::default();
        sensor.revolution(&tunnel_scan(6.0), &mut frame.revolution, &mut frame.notes);
        engine.process(&mut frame).expect("a sound scan");
        assert_eq!((frame.junction.junctions, frame.junction.openings.len()), (2, 2));
    }
}
