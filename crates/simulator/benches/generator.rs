//! How fast scenes are made, on one core: `cargo bench -p crosscut-simulator`. One line per family: its rate in the
//! median of several passes over the same scenes. Mines, lidar and truth are made anew in every pass.

use std::hint::black_box;
use std::time::Instant;

use crosscut_simulator::{Split, suites};

const SCENES: usize = 200;
const PASSES: usize = 7;

fn main() {
    println!("{:<16}{:>16}", "family", "revolutions/s");
    for suite in suites() {
        let mut rates: Vec<f64> = (0..PASSES).map(|_| rate(|| suite.scenes(Split::Dev).take(SCENES).count())).collect();
        rates.sort_by(f64::total_cmp);
        println!("{:<16}{:>16.0}", suite.name, rates[PASSES / 2]);
    }
}

/// Scenes per second.
fn rate(make: impl Fn() -> usize) -> f64 {
    let start = Instant::now();
    let made = black_box(make());
    made as f64 / start.elapsed().as_secs_f64()
}
