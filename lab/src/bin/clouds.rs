//! The share of right counts of preset `default` in clouds, compared with 2D scans of the same places.
//!
//! `lab/run clouds [PLACES]`
//!
//! Development places of every family, PLACES of each (50): the share with the true count in the 2D scan, in a cloud of
//! one level ring of 4000 beams, and in one of 64 rings over 45° of 1500 beams. Walls stand upright and the lidar is
//! level. The truth is that of the 2D scan.

use crosscut_detector::{Engine, Preset, Settings};
use crosscut_sensor::Sensor;
use crosscut_simulator::{Rings, Split, suites};
use crosscut_stage::{Frame, Point};

const FLAT: Rings = Rings { rings: 1, lowest_rad: 0.0, beams: 4000 };
const ROUND: Rings = Rings { rings: 64, lowest_rad: -0.39, beams: 1500 };

fn main() -> anyhow::Result<()> {
    let places: usize = std::env::args().nth(1).map_or(Ok(50), |places| places.parse())?;
    let mut engine = Settings::new(Preset::Default).engine()?;
    let sensor = Sensor::default();
    let mut frame = Frame::default();
    println!("{:<10} {:>8} {:>8} {:>8}", "family", "2D scan", "2D cloud", "3D cloud");
    for suite in suites() {
        let (Some(flat), Some(round)) = (suite.clouds(Split::Dev, FLAT), suite.clouds(Split::Dev, ROUND)) else {
            continue;
        };
        let mut right = [0; 3];
        for ((scene, flat), round) in suite.scenes(Split::Dev).zip(flat).zip(round).take(places) {
            sensor.revolution(&scene.scan, &mut frame.revolution, &mut frame.notes);
            right[0] += usize::from(junctions(&mut engine, &mut frame)? == scene.truth.walls);
            for (right, cloud) in right[1..].iter_mut().zip([flat, round]) {
                set_cloud(&sensor, &mut frame, cloud.points_m);
                *right += usize::from(junctions(&mut engine, &mut frame)? == cloud.truth.walls);
            }
        }
        let [scan, flat, round] = right.map(|right| 100.0 * right as f64 / places as f64);
        println!("{:<10} {scan:>6.0} % {flat:>6.0} % {round:>6.0} %", suite.name);
    }
    Ok(())
}

fn set_cloud(sensor: &Sensor, frame: &mut Frame, points_m: Vec<Point>) {
    frame.revolution.clear();
    frame.revolution.sweep = None;
    frame.revolution.points_m = points_m;
    sensor.level(&mut frame.revolution, &mut frame.notes);
}

fn junctions(engine: &mut Engine, frame: &mut Frame) -> anyhow::Result<u32> {
    frame.notes.clear();
    engine.process(frame)?;
    Ok(frame.junction.junctions as u32)
}
