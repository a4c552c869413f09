//! Generator of a figure of the docs: how the time of preset `default` grows with the number of points, in one thread.
//!
//! `lab/run growth [FIGURE.svg]`
//!
//! Places with 2, 3 and 4 branches 4 to 5 m wide, seen by a 2D lidar of more and more beams, as dense 2D clouds, and by
//! a lidar of many rings. Of each size: the processor time of a revolution, from its points to its walls and openings;
//! how many of the answers have the true count; and the exponent a of the fit time = c·nᵃ, of each kind, and from
//! sweeps to clouds: of one line fitted through both, and from the smallest sweep to the largest cloud.

mod plot;

use anyhow::Context;
use crosscut_detector::{Engine, Preset, Settings};
use crosscut_sensor::Sensor;
use crosscut_simulator::{Places, Rings, lidar::Lidar};
use crosscut_stage::{Frame, Revolution};
use plot::Curve;

/// A seed that no suite uses.
const FIRST_SEED: u64 = 77_000;
const BRANCHES: [usize; 3] = [2, 3, 4];
/// Each place is processed repeatedly for this long.
const LEAST_MS: f64 = 300.0;
const PLACES: Places = Places { width_m: [4.0, 5.0], ..Places::CLEAN };

/// A kind of scan that is timed: its name, its sizes, and a function that returns the revolution of a place with about n
/// points and its true count.
type Kind = (&'static str, &'static [usize], fn(branches: usize, n: usize) -> (Revolution, u32));

const KINDS: [Kind; 3] = [
    ("2D sweeps", &[360, 720, 1440, 2880, 4096], sweep),
    ("2D clouds", &[360, 1000, 4096, 10_000, 30_000, 100_000], flat_cloud),
    ("3D clouds", &[1000, 3000, 10_000, 30_000, 100_000], rings_cloud),
];

fn main() -> anyhow::Result<()> {
    let mut engine = Settings::new(Preset::Default).engine()?;
    let mut curves = Vec::new();
    println!("{:<10} {:>8} {:>10} {:>6}", "kind", "points", "ms", "right");
    for (name, sizes, make) in KINDS {
        let mut curve = Curve { name, points: Vec::new() };
        for &size in sizes {
            let Measured { points, ms, right } = measure(&mut engine, size, make)?;
            println!("{name:<10} {points:>8.0} {ms:>10.3} {right:>4}/{}", BRANCHES.len());
            curve.points.push([points, ms]);
        }
        println!("{name:<10} grow as n^{:.2}\n", curve.exponent());
        curves.push(curve);
    }
    let all = one_line(&curves[0], &curves[1]);
    println!("sweeps, then 2D clouds of more points, grow as n^{:.2}", all.exponent());
    println!("from the smallest sweep to the largest 2D cloud, n^{:.2}", all.ends().exponent());
    println!("most memory: {} MB", peak_memory_mb()?);
    if let Some(figure) = std::env::args().nth(1) {
        std::fs::write(&figure, plot::svg(&curves)).with_context(|| format!("cannot write {figure}"))?;
    }
    Ok(())
}

/// The sweeps, and the clouds that have more points than any sweep.
fn one_line(sweeps: &Curve, clouds: &Curve) -> Curve {
    let most = sweeps.points.iter().fold(0.0f64, |most, &[points, _]| most.max(points));
    let beyond = clouds.points.iter().filter(|&&[points, _]| points > most);
    Curve { name: "one line", points: sweeps.points.iter().chain(beyond).copied().collect() }
}

/// The measurement at one size.
struct Measured {
    /// Mean number of points.
    points: f64,
    /// Processor time of a revolution, which depends little on other programs on the machine.
    ms: f64,
    /// Number of places with the right count.
    right: usize,
}

fn measure(engine: &mut Engine, size: usize, make: fn(usize, usize) -> (Revolution, u32)) -> anyhow::Result<Measured> {
    let (mut points, mut right, mut ms) = (0, 0, 0.0);
    for branches in BRANCHES {
        let (seen, walls) = make(branches, size);
        points += seen.len();
        let (sensor, mut frame) = (Sensor::default(), Frame::default());
        let mut process = || {
            frame.revolution.clone_from(&seen);
            frame.notes.clear();
            sensor.level(&mut frame.revolution, &mut frame.notes);
            engine.process(&mut frame)?;
            anyhow::Ok(frame.junction.junctions)
        };
        let counted = process()?;
        let (start_ms, mut repeats) = (processor_ms()?, 0);
        while processor_ms()? < start_ms + LEAST_MS {
            process()?;
            repeats += 1;
        }
        ms += (processor_ms()? - start_ms) / f64::from(repeats) / BRANCHES.len() as f64;
        right += usize::from(counted == walls as usize);
    }
    let points = points as f64 / BRANCHES.len() as f64;
    Ok(Measured { points, ms, right })
}

fn sweep(branches: usize, n: usize) -> (Revolution, u32) {
    let places = Places { lidar: Lidar { beams: n, ..Lidar::CLEAN }, ..PLACES };
    let scene = places.scene(branches, FIRST_SEED, 0);
    let mut revolution = Revolution::default();
    let sensor = Sensor::default();
    sensor.revolution(&scene.scan, &mut revolution, &mut Default::default());
    (revolution, scene.truth.walls)
}

fn flat_cloud(branches: usize, n: usize) -> (Revolution, u32) {
    cloud(branches, Rings { rings: 1, lowest_rad: 0.0, beams: n })
}

/// 64 rings over 45° from 10,000 points on, fewer below.
fn rings_cloud(branches: usize, n: usize) -> (Revolution, u32) {
    let rings = if n < 10_000 { 16 } else { 64 };
    cloud(branches, Rings { rings, lowest_rad: -22.5_f64.to_radians(), beams: n / rings })
}

fn cloud(branches: usize, rings: Rings) -> (Revolution, u32) {
    let cloud = PLACES.cloud(branches, FIRST_SEED, rings);
    (Revolution { points_m: cloud.points_m, ..Revolution::default() }, cloud.truth.walls)
}

/// Processor time of this thread.
fn processor_ms() -> anyhow::Result<f64> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").context("needs Linux")?;
    let ns: f64 = text.split_whitespace().next().context("an empty schedstat")?.parse()?;
    Ok(ns / 1e6)
}

/// Largest resident memory of this process.
fn peak_memory_mb() -> anyhow::Result<u64> {
    let status = std::fs::read_to_string("/proc/self/status").context("needs Linux")?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).context("no VmHWM")?;
    let kb: u64 = line.trim().trim_end_matches(" kB").parse()?;
    Ok(kb / 1024)
}
