//! How the time of preset `default` grows with the number of points, in one thread.
//!
//! `cargo run --release --no-default-features --example growth [-- FIGURE.svg]`
//!
//! Places with 2, 3 and 4 branches 4 to 5 m wide, seen by a 2D lidar of more and more beams, as dense 2D clouds, and by a lidar
//! of many rings. Of each size: the median time of a revolution, from its points to its walls and openings; how many of the
//! answers have the true count; and the exponent a of the fit time = c·nᵃ.

mod plot;

use std::time::Instant;

use anyhow::Context;
use crosscut_ingest::Sensor;
use crosscut_pipeline::{Config, Engine, Registry};
use crosscut_simulator::{Places, Rings, lidar::Lidar};
use crosscut_stage::{Frame, Params, Revolution, Step};
use plot::Curve;

/// Seeds of no suite.
const FIRST_SEED: u64 = 77_000;
const BRANCHES: [usize; 3] = [2, 3, 4];
/// Each place is worked on so often, and for at least so long.
const REPEATS: usize = 3;
const PLACES: Places = Places { width_m: [4.0, 5.0], ..Places::CLEAN };

/// What is timed: its name, and the revolution of a place of about n points with its true count.
type Kind = (&'static str, &'static [usize], fn(branches: usize, n: usize) -> (Revolution, u32));

const KINDS: [Kind; 3] = [
    ("2D sweeps", &[360, 720, 1440, 2880, 4096], sweep),
    ("2D clouds", &[360, 1000, 4096, 10_000, 30_000, 100_000], flat_cloud),
    ("3D clouds", &[1000, 3000, 10_000, 30_000, 100_000], rings_cloud),
];

fn main() -> anyhow::Result<()> {
    let registry = Registry::standard();
    let mut engine = Engine::new(&Config::preset("default", &registry)?, &registry);
    let mut curves = Vec::new();
    println!("{:<10} {:>8} {:>10} {:>6}", "kind", "points", "median ms", "right");
    for (name, sizes, make) in KINDS {
        let mut curve = Curve { name, points: Vec::new() };
        for &size in sizes {
            let Measured { points, ms, right, steps_ms } = measure(&mut engine, size, make)?;
            let steps = steps_ms.map(|ms| format!("{ms:.3}")).join(" ");
            println!("{name:<10} {points:>8.0} {ms:>10.3} {right:>4}/{}  {steps}", BRANCHES.len());
            curve.points.push([points, ms]);
        }
        println!("{name:<10} grow as n^{:.2}\n", curve.exponent());
        curves.push(curve);
    }
    println!("most memory: {} MB", peak_memory_mb()?);
    if let Some(figure) = std::env::args().nth(1) {
        std::fs::write(&figure, plot::svg(&curves)).with_context(|| format!("cannot write {figure}"))?;
    }
    Ok(())
}

/// What was measured at one size.
struct Measured {
    /// Mean number of points.
    points: f64,
    /// Median time.
    ms: f64,
    /// How many places have the right count.
    right: usize,
    /// Affinity, spectral, kmeans and report of the last revolution.
    steps_ms: [f64; 4],
}

fn measure(engine: &mut Engine, size: usize, make: fn(usize, usize) -> (Revolution, u32)) -> anyhow::Result<Measured> {
    let (mut points, mut right, mut times_ms, mut steps_ms) = (0, 0, Vec::new(), [0.0; 4]);
    for branches in BRANCHES {
        let (revolution, walls) = make(branches, size);
        points += revolution.len();
        let mut frame = Frame { revolution, ..Frame::default() };
        for _ in 0..REPEATS {
            frame.notes.clear();
            let start = Instant::now();
            engine.process(&mut frame)?;
            times_ms.push(1e3 * start.elapsed().as_secs_f64());
        }
        right += usize::from(frame.junction.junctions == walls as usize);
        let steps = [Step::Affinity, Step::Spectral, Step::Kmeans, Step::Report];
        steps_ms = steps.map(|step| frame.timings.ns(step) as f64 / 1e6);
    }
    times_ms.sort_by(f64::total_cmp);
    let points = points as f64 / BRANCHES.len() as f64;
    Ok(Measured { points, ms: times_ms[times_ms.len() / 2], right, steps_ms })
}

fn sweep(branches: usize, n: usize) -> (Revolution, u32) {
    let places = Places { lidar: Lidar { beams: n, ..Lidar::CLEAN }, ..PLACES };
    let scene = places.scene(branches, FIRST_SEED, 0);
    let mut revolution = Revolution::default();
    let sensor = Sensor::new(&Params::defaults(crosscut_ingest::PARAMS));
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

/// The most memory that this process ever had resident.
fn peak_memory_mb() -> anyhow::Result<u64> {
    let status = std::fs::read_to_string("/proc/self/status").context("needs Linux")?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).context("no VmHWM")?;
    let kb: u64 = line.trim().trim_end_matches(" kB").parse()?;
    Ok(kb / 1024)
}
