//! The method inside a robot's own program: one scan in, walls and ways on out; no files, no threads, no viewer.
//!
//! `cargo run --release --example robot`

use std::f32::consts::PI;

use crosscut_ingest::Sensor;
use crosscut_messages::LaserScan;
use crosscut_pipeline::{Config, Engine, Layer, Registry, Schema};
use crosscut_stage::{Frame, Params, Value};

fn main() -> anyhow::Result<()> {
    // Once, at start: how the lidar is mounted, which stages to run, and how wide the vehicle is.
    let mut mounting = Params::defaults(crosscut_ingest::PARAMS);
    mounting.set("yaw_rad", Value::Number(0.0))?;
    let sensor = Sensor::new(&mounting);
    let registry = Registry::standard();
    let layers = [Layer::preset("default")?, Layer::settings("--set", &["vehicle.width_m=0.8".to_owned()])?];
    let mut engine = Engine::new(&Config::resolve(&Schema::new(&registry), &layers)?, &registry);
    let mut frame = Frame::default();

    // For every scan that the driver delivers; the frame's buffers are used again.
    for scan in [tunnel_scan(6.0), tunnel_scan(8.0)] {
        frame.notes.clear();
        sensor.revolution(&scan, &mut frame.revolution, &mut frame.notes);
        if let Err(failure) = engine.process(&mut frame) {
            eprintln!("{failure}"); // the next scan is as good as any
            continue;
        }
        let junction = &frame.junction;
        println!("{} walls, {}, confidence {:.2}", junction.junctions, junction.place, junction.confidence);
        for opening in &junction.openings {
            let bearing_deg = opening.bearing_rad.to_degrees();
            println!("  a way on at {bearing_deg:.0}°, {:.1} m wide, {}", opening.width_m, opening.evidence);
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
