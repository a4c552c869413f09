//! What a recording takes: file, time a revolution, memory.
//!
//! `cargo bench -p crosscut --bench recording` records the shipped flight again and again until 6000 revolutions are
//! full, which is ten minutes at 10 Hz; `... -- N` takes N revolutions. One line for each preset and level, columns
//! parted by commas. The time is that of the thread that observes: no stage waits for it until the pool of frames is
//! empty.

use std::path::{Path, PathBuf};
use std::time::Instant;

use crosscut_ingest::{ReadOptions, Recording, Sensor};
use crosscut_pipeline::{Config, Engine, Preset, Registry};
use crosscut_recorder::{Detail, Recorder, RecorderOptions, Scope};
use crosscut_stage::{Frame, Observer as _, Source as _};

const REVOLUTIONS: u64 = 6000;
/// Exact W of every revolution makes 0.5 MB each: fewer of them tell the same.
const FULL_SHARE: u64 = 10;
const PERIOD_NS: u64 = 100_000_000;

type Fallible<T> = Result<T, Box<dyn std::error::Error>>;

fn main() -> Fallible<()> {
    let asked = std::env::args().skip(1).find_map(|arg| arg.parse().ok());
    println!("preset ,level  ,revolutions,returns,kB a revolution,MB a 6000,median ms,p99 ms,parts,peak MB so far");
    for preset in ["paper", "default"] {
        let frames = shipped_flight(preset)?;
        for detail in [Detail::Light, Detail::Default, Detail::Full] {
            let revolutions = asked.unwrap_or(REVOLUTIONS) / if detail == Detail::Full { FULL_SHARE } else { 1 };
            measure(preset, &frames, detail, revolutions)?;
        }
    }
    Ok(())
}

/// The frames of the shipped flight.
fn shipped_flight(preset: &str) -> Fallible<Vec<Frame>> {
    let path = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../recordings/tee.mcap"));
    let registry = Registry::standard();
    let config = Config::preset(Preset::named(preset)?, &registry)?;
    let mut engine = Engine::new(&config, &registry);
    let sensor = Sensor::default();
    let mut recording = Recording::open(&[path], &ReadOptions::default(), sensor)?;
    let mut frames = Vec::new();
    loop {
        let mut frame = Frame::default();
        if !recording.next(&mut frame.revolution, &mut frame.notes)? {
            return Ok(frames);
        }
        engine.process(&mut frame)?;
        frames.push(frame);
    }
}

fn measure(preset: &str, frames: &[Frame], detail: Detail, revolutions: u64) -> Fallible<()> {
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("flight.rrd");
    let scope = Scope { detail, ..Scope::default() };
    let mut recorder = Recorder::new(RecorderOptions { path: Some(path), scope, ..RecorderOptions::default() })?;
    let mut times_ns = Vec::new();
    let first_ns = frames[0].revolution.stamp_ns;
    for (seq, frame) in (0..revolutions).zip(frames.iter().cycle()) {
        let mut frame = frame.clone();
        frame.revolution.seq = seq;
        frame.revolution.stamp_ns = first_ns + PERIOD_NS * seq;
        let start = Instant::now();
        recorder.observe(&frame)?;
        times_ns.push(start.elapsed().as_nanos());
    }
    recorder.finish()?;
    let (bytes, parts) = size_of(folder.path())?;
    let mut returns: Vec<usize> = frames.iter().map(|frame| frame.revolution.len()).collect();
    returns.sort_unstable();
    times_ns.sort_unstable();
    let ms = |share: f64| times_ns[(share * (times_ns.len() - 1) as f64) as usize] as f64 / 1e6;
    println!(
        "{preset:<7},{:<7},{revolutions:>11},{:>7},{:>15.1},{:>9.1},{:>9.2},{:>6.2},{parts:>5},{:>14}",
        format!("{detail:?}").to_lowercase(),
        returns[returns.len() / 2],
        bytes as f64 / 1e3 / revolutions as f64,
        bytes as f64 / 1e6 / revolutions as f64 * 6000.0,
        ms(0.5),
        ms(0.99),
        peak_mb().map_or_else(|| "-".to_owned(), |mb| mb.to_string()),
    );
    Ok(())
}

/// Bytes and files of a folder.
fn size_of(folder: &Path) -> Fallible<(u64, usize)> {
    let sizes: Vec<u64> =
        std::fs::read_dir(folder)?.map(|entry| entry?.metadata().map(|m| m.len())).collect::<Result<_, _>>()?;
    Ok((sizes.iter().sum(), sizes.len()))
}

/// The most memory that this process had, where the system tells it.
fn peak_mb() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let kb: u64 =
        status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?.split_whitespace().next()?.parse().ok()?;
    Some(kb / 1000)
}
