//! How long the flight takes for a revolution: pose, place and steady answer (`flight`), then the map (`map`), in the calling
//! thread, after the four stages, which are not timed.
//!
//! `cargo bench -p crosscut-detector --bench flight` takes simulated flights, all development scenes as if they were one
//! flight (`unrelated`), and two flights of 20,000 revolutions, of which it prints each thousand: one that is flown forth and
//! back (`long`), and one that is elsewhere all at once after each minute, as its first minute is repeated (`lost`).
//! `... -- [NAME...]` takes those of these names alone, `... -- [RECORDING...]` takes recordings instead. Columns are parted
//! by commas, times are in microseconds. Of each revolution the least time of several passes counts, as another program's
//! turn only ever adds.

mod scans;

use std::path::Path;
use std::time::Instant;

use crosscut_detector::{Engine, Preset, Sensor, Settings};
use crosscut_flight::{Flight, Mapper, PARAMS};
use crosscut_simulator::{Scene, Split, scenarios, suites};
use crosscut_stage::{Frame, Notes, Params, Revolution};
use scans::{Fallible, median};

const FLIGHTS: [&str; 3] = ["loops", "chambers", "pillars"];
const SEED: u64 = 7;
const PASSES: usize = 3;
const LONG: usize = 20_000;
const BLOCK: usize = 1000;
const MINUTE: usize = 600;
/// Between two scans of a flight that is repeated.
const SWEEP_NS: u64 = 100_000_000;

fn main() -> Fallible<()> {
    // The first argument of a bench is `--bench`.
    let arguments = std::env::args().skip(1).filter(|arg| !arg.starts_with("--"));
    let (recordings, names): (Vec<String>, Vec<String>) = arguments.partition(|arg| Path::new(arg).exists());
    let is_wanted = |name: &str| names.is_empty() || names.iter().any(|wanted| wanted == name);
    println!(
        "scans           ,   from,     to, flight p50,  p99,   most, map p50,  p99,   most, both p50,  p99,   most"
    );
    if !recordings.is_empty() {
        for scans in scans::of(&recordings, usize::MAX)? {
            print(&scans.name, 0, &mut times_ns(&scans.revolutions, scans.revolutions.len())?);
        }
        return Ok(());
    }
    for name in FLIGHTS.into_iter().filter(|name| is_wanted(name)) {
        let revolutions = flight(name, SEED)?;
        print(name, 0, &mut times_ns(&revolutions, revolutions.len())?);
    }
    if is_wanted("unrelated") {
        let scenes = suites().iter().flat_map(|suite| suite.scenes(Split::Dev));
        let unrelated: Vec<Revolution> = scenes.map(|scene| revolution(&scene)).collect();
        print("unrelated", 0, &mut times_ns(&unrelated, unrelated.len())?);
    }
    let mut long = flight(FLIGHTS[0], SEED)?;
    long.extend_from_within(..);
    let half = long.len() / 2;
    long[half..].reverse();
    let lost = &flight("mine", 1)?[..MINUTE];
    for (name, revolutions) in [("long", &long[..]), ("lost", lost)].into_iter().filter(|(name, _)| is_wanted(name)) {
        for (block, times_ns) in times_ns(revolutions, LONG)?.chunks_mut(BLOCK).enumerate() {
            print(name, block * BLOCK, times_ns);
        }
    }
    Ok(())
}

fn flight(name: &str, seed: u64) -> Fallible<Vec<Revolution>> {
    let scenario = scenarios().iter().find(|scenario| scenario.name == name).ok_or("no such scenario")?;
    Ok((scenario.fly)(seed).map(|scene| revolution(&scene)).collect())
}

fn revolution(scene: &Scene) -> Revolution {
    let mut revolution = Revolution::default();
    Sensor::default().revolution(&scene.scan, &mut revolution, &mut Notes::default());
    revolution.odometry = scene.odometry_pose();
    revolution
}

/// Of each of `count` revolutions, these in turn, the nanoseconds of the flight and of the map.
fn times_ns(revolutions: &[Revolution], count: usize) -> Fallible<Vec<[u64; 2]>> {
    let mut engine: Engine = Settings::new(Preset::Default).engine()?;
    let mut least_ns = vec![[u64::MAX; 2]; count];
    for _ in 0..PASSES {
        let (mut flight, mut mapper) = (Flight::new(&Params::defaults(PARAMS), 0.6), Mapper::default());
        let mut frame = Frame::default();
        for (at, (revolution, least_ns)) in revolutions.iter().cycle().zip(&mut least_ns).enumerate() {
            frame.revolution.clone_from(revolution);
            if count > revolutions.len() {
                frame.revolution.stamp_ns = at as u64 * SWEEP_NS;
            }
            frame.notes.clear();
            engine.process(&mut frame)?;
            let start = Instant::now();
            flight.add(&mut frame);
            let flown = start.elapsed();
            mapper.add(&frame);
            let mapped = start.elapsed() - flown;
            for (least_ns, time) in least_ns.iter_mut().zip([flown, mapped]) {
                *least_ns = (*least_ns).min(time.as_nanos() as u64);
            }
        }
    }
    Ok(least_ns)
}

fn print(name: &str, from: usize, times_ns: &mut [[u64; 2]]) {
    let mut columns = String::new();
    for of in [|times: &[u64; 2]| times[0], |times: &[u64; 2]| times[1], |times: &[u64; 2]| times[0] + times[1]] {
        let mut sorted_ns: Vec<u64> = times_ns.iter().map(of).collect();
        let middle_ns = median(&mut sorted_ns);
        let most_ns = |share: f64| sorted_ns[((sorted_ns.len() - 1) as f64 * share) as usize];
        let us = [middle_ns, most_ns(0.99), most_ns(1.0)].map(|ns| ns as f64 / 1e3);
        columns += &format!(", {:>8.1}, {:>6.1}, {:>8.1}", us[0], us[1], us[2]);
    }
    println!("{name:<16}, {from:>6}, {:>6}{columns}", from + times_ns.len());
}
