//! Writes a flight of any length, for measuring throughput, memory and latency: the first minute of a simulated flight,
//! repeated, with stamps that continue.
//!
//! `lab/run long_flight OUT.mcap REVOLUTIONS HZ`

use std::path::Path;

use anyhow::Context;
use crosscut_messages::Time;
use crosscut_simulator::{Scene, scenarios, write_mcap};

const SCENARIO: &str = "mine";
const SEED: u64 = 1;
/// Scans of the flight that is repeated.
const SCANS: usize = 600;

fn main() -> anyhow::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [out, revolutions, hz] = arguments.as_slice() else {
        anyhow::bail!("usage: long_flight OUT.mcap REVOLUTIONS HZ");
    };
    let (revolutions, hz): (usize, f64) = (revolutions.parse()?, hz.parse()?);
    let scenario = scenarios().iter().find(|scenario| scenario.name == SCENARIO).context("no such scenario")?;
    let flight: Vec<Scene> = (scenario.fly)(SEED).take(SCANS).collect();
    let first_ns = flight.first().context("an empty flight")?.stamp_ns;
    let scenes = flight.iter().cycle().take(revolutions).enumerate().map(|(index, scene)| {
        let mut scene = scene.clone();
        scene.stamp_ns = first_ns + (index as f64 / hz * 1e9) as u64;
        scene.scan.header.stamp = Time::from_ns(scene.stamp_ns);
        scene
    });
    let written = write_mcap(Path::new(out), scenes)?;
    println!("{written} revolutions at {hz} Hz: {out}");
    Ok(())
}
