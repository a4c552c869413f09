//! Prints the scans of a recording of any kind: number, stamp, beams, returns and the nearest return.
//!
//! `cargo run -p crosscut-ingest --example scans -- RECORDING...`

use std::error::Error;
use std::path::PathBuf;

use crosscut_ingest::{Notes, ReadOptions, Recording, Revolution, Sensor, Source as _};

fn main() -> Result<(), Box<dyn Error>> {
    let inputs: Vec<PathBuf> = std::env::args_os().skip(1).map(PathBuf::from).collect();
    let mut recording = Recording::open(&inputs, &ReadOptions::default(), Sensor::default())?;
    let mut scan = Revolution::default();
    while recording.next(&mut scan, &mut Notes::default())? {
        let beams = scan.sweep.as_ref().map_or(0, |sweep| sweep.ranges_m.len());
        let nearest_m = scan.points_m.iter().map(|point| point.x.hypot(point.y)).fold(f64::INFINITY, f64::min);
        println!(
            "{} {} ns: {beams} beams, {} returns, nearest {nearest_m:.2} m",
            scan.seq,
            scan.stamp_ns,
            scan.points_m.len()
        );
    }
    for loss in recording.losses() {
        eprintln!("lost: {loss}");
    }
    Ok(())
}
