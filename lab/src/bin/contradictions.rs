//! Counts what no answer may claim (`crosscut_lab::Contradiction`) in recordings, which need no truth. `--list` prints
//! each of them as well.
//!
//! ```text
//! lab/run contradictions [--list] RECORDING...
//! ```

use std::path::PathBuf;

use crosscut_detector::{Engine, Preset, Settings};
use crosscut_ingest::{ReadOptions, Recording, recordings_in};
use crosscut_lab::{Contradiction, contradictions};
use crosscut_report::{VEHICLE_PARAMS, VEHICLE_WIDTH_M};
use crosscut_sensor::Sensor;
use crosscut_stage::{Frame, Params, Source as _};

fn main() -> anyhow::Result<()> {
    let (options, inputs): (Vec<String>, Vec<String>) = std::env::args().skip(1).partition(|arg| arg == "--list");
    let inputs: Vec<PathBuf> = inputs.into_iter().map(PathBuf::from).collect();
    let mut engine = Settings::new(Preset::Default).engine()?;
    println!("{:40} {:>6} {:>8} {:>8} {:>8}", "", "scans", "blocked", "island", "handful");
    for path in recordings_in(&inputs)? {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let (scans, [blocked, island, handful]) = count(path, &mut engine, !options.is_empty())?;
        println!("{name:40} {scans:6} {blocked:8} {island:8} {handful:8}");
    }
    Ok(())
}

/// How many scans a recording has, and in how many each kind of contradiction occurs.
fn count(path: PathBuf, engine: &mut Engine, is_listed: bool) -> anyhow::Result<(usize, [usize; 3])> {
    let width_m = Params::defaults(VEHICLE_PARAMS).get(VEHICLE_WIDTH_M);
    let mut recording = Recording::open(&[path], &ReadOptions::default(), Sensor::default())?;
    let (mut frame, mut scans, mut counts) = (Frame::default(), 0, [0; 3]);
    while recording.next(&mut frame.revolution, &mut frame.notes)? {
        engine.process(&mut frame)?;
        frame.notes.clear();
        let mut occurs = [false; 3];
        for contradiction in contradictions(&frame, width_m) {
            let kind = match contradiction {
                Contradiction::BlockedOpening { .. } => 0,
                Contradiction::WallAsIsland { .. } => 1,
                Contradiction::SureOfHandful { .. } => 2,
            };
            occurs[kind] = true;
            if is_listed {
                let confidence = frame.junction.confidence.unwrap_or_default();
                println!("  scan {scans}, confidence {confidence:.2}: {contradiction}");
            }
        }
        counts.iter_mut().zip(occurs).for_each(|(count, occurs)| *count += usize::from(occurs));
        scans += 1;
    }
    Ok((scans, counts))
}
