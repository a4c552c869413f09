//! Scenes per second on one core: `cargo bench -p crosscut-simulator`. Each line has the rate of a family of places or of
//! a flight, as the median of several passes over the same scenes. Every pass makes mines, scans and truth again.

use std::hint::black_box;
use std::time::Instant;

use crosscut_simulator::{Split, scenarios, suites};

const SCENES: usize = 200;
const PASSES: usize = 7;

fn main() {
    println!("{:<16}{:>16}", "", "revolutions/s");
    // Families of flights are left out, because they skip most scans. The flights themselves follow.
    for suite in suites().iter().filter(|suite| !suite.name.starts_with("flight_")) {
        print_median(suite.name, || suite.scenes(Split::Dev).take(SCENES).count());
    }
    for scenario in scenarios() {
        print_median(scenario.name, || (scenario.fly)(1).take(SCENES).count());
    }
}

fn print_median(name: &str, make: impl Fn() -> usize) {
    let mut rates: Vec<f64> = (0..PASSES).map(|_| rate(&make)).collect();
    rates.sort_by(f64::total_cmp);
    println!("{name:<16}{:>16.0}", rates[PASSES / 2]);
}

/// Scenes per second.
fn rate(make: impl Fn() -> usize) -> f64 {
    let start = Instant::now();
    let made = black_box(make());
    made as f64 / start.elapsed().as_secs_f64()
}
