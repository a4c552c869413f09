//! How the time of every solver grows with the number of returns: `cargo bench -p crosscut-spectral`;
//! some of them: `... -- NAME...`.
//!
//! Four straight walls, 3.5 m apart, 20 m long, evenly sampled. The dense solvers get equation (1) with σ = 1.5 per m²,
//! the sparse ones the graph of each return's 2 neighbours on either side. One line per solver and size, columns parted
//! by commas: the mean of many runs, in processor time of the thread where the system tells it (Linux), so that the
//! turns of other programs do not count.

use std::fs::read_to_string;
use std::hint::black_box;
use std::time::Instant;

use crosscut_spectral::{blocks, components, faer_evd, slicing};
use crosscut_stage::{Affinity, Notes, SpectralStage, Spectrum};

const DENSE: [usize; 5] = [90, 180, 360, 720, 1440];
const SPARSE: [usize; 8] = [90, 180, 360, 720, 1440, 4096, 20_000, 100_000];
const WALLS: usize = 4;
/// The system counts processor time in steps of milliseconds, so a solver runs for this long.
const ENOUGH_NS: u64 = 300_000_000;
/// Runs between two looks at the time.
const RUNS_BETWEEN: u32 = 3;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!("{:<12},{:>8},{:>12}", "solver", "returns", "us");
    let mut dense: [(&str, Box<dyn SpectralStage>); 3] = [
        ("faer", faer_evd::KIND.with(&[])?),
        ("slicing", slicing::KIND.with(&[])?),
        ("slicing16", slicing::KIND.with(&[("eigenvalues", 16.into())])?),
    ];
    let names: Vec<String> = std::env::args().skip(1).filter(|arg| !arg.starts_with("--")).collect();
    let is_asked_for = |name: &str| names.is_empty() || names.iter().any(|asked| asked == name);
    for n in DENSE {
        let affinity = every_pair(n);
        for (name, stage) in dense.iter_mut().filter(|(name, _)| is_asked_for(name)) {
            print(name, n, stage.as_mut(), &affinity)?;
        }
    }
    // That of preset `default`: a wall of 25,000 returns has its next eigenvalue below 1e-7.
    let tolerance = [("zero_tolerance", 1e-8.into())];
    let mut sparse: [(&str, Box<dyn SpectralStage>); 2] =
        [("blocks", blocks::KIND.with(&tolerance)?), ("components", components::KIND.with(&[])?)];
    for n in SPARSE {
        let affinity = neighbours(n);
        for (name, stage) in sparse.iter_mut().filter(|(name, _)| is_asked_for(name)) {
            print(name, n, stage.as_mut(), &affinity)?;
        }
    }
    Ok(())
}

fn print(
    name: &str,
    n: usize,
    stage: &mut dyn SpectralStage,
    affinity: &Affinity,
) -> Result<(), crosscut_stage::StageError> {
    let (mut out, start) = (Spectrum::default(), Instant::now());
    // Processor time of this thread, or time where there is no such thing.
    let now_ns = || on_processor_ns().unwrap_or_else(|| start.elapsed().as_nanos() as u64);
    let (start_ns, mut runs, mut sum_ns) = (now_ns(), 0, 0);
    while sum_ns < ENOUGH_NS {
        for _ in 0..RUNS_BETWEEN {
            stage.spectrum(black_box(affinity), &mut out, &mut Notes::default())?;
        }
        runs += RUNS_BETWEEN;
        sum_ns = now_ns() - start_ns;
    }
    println!("{name:<12},{n:>8},{:>12.1}", sum_ns as f64 / 1e3 / f64::from(runs));
    Ok(())
}

fn on_processor_ns() -> Option<u64> {
    read_to_string("/proc/thread-self/schedstat").ok()?.split_whitespace().next()?.parse().ok()
}

fn every_pair(n: usize) -> Affinity {
    let along = |i: usize| 20.0 * (i / WALLS) as f64 / (n / WALLS) as f64;
    let across = |i: usize| 3.5 * (i % WALLS) as f64;
    let square = |i: usize, j: usize| (along(i) - along(j)).powi(2) + (across(i) - across(j)).powi(2);
    let mut affinity = Affinity::default();
    let w = affinity.weights.make_dense(n);
    for j in 0..n {
        for i in 0..n {
            // Wall by wall, as a lidar sees them.
            let [i_of_wall, j_of_wall] = [i, j].map(|i| i % (n / WALLS) * WALLS + i / (n / WALLS) % WALLS);
            w[(i, j)] = (-1.5 * square(i_of_wall, j_of_wall)).exp();
        }
    }
    affinity.degrees = (0..n).map(|j| w.col(j).iter().sum()).collect();
    affinity
}

fn neighbours(n: usize) -> Affinity {
    let wall = n / WALLS;
    let mut affinity = Affinity::default();
    let w = affinity.weights.make_sparse();
    for i in 0..n {
        let (first, end) = ((i / wall * wall).min(n), ((i / wall + 1) * wall).min(n));
        let row = i.saturating_sub(2).max(first)..(i + 3).min(end);
        affinity.degrees.push(row.len() as f64);
        row.for_each(|j| w.push(j as u32, 1.0));
        w.end_row();
    }
    affinity
}
