//! How often maps of simulated flights are right, as a table in Markdown:
//! `cargo run --release -p crosscut-flight --example maps -- SCENARIO|PLAN.json... FIRST_SEED COUNT`.
//!
//! For odometry that drifts by 0, 2, 5 and 10 % and for scans alone, a line each for the map, for counting every change of
//! the count as a new junction, and for taking all within 8 m of the pose to be one. The columns are the figures of
//! `crosscut_evaluate::maps`, and the time that pose, place, steady answer and map took for a revolution. A second table
//! has the places and steady counts, whatever the odometry. With `MAPS_SAY` in the environment, each map that is not
//! exact is described first.
#![allow(clippy::print_stdout)] // the table is the output

use std::error::Error;
use std::time::Instant;

use crosscut_detector::{Engine, Preset, Settings};
use crosscut_evaluate::flights::{FlightFigures, FlightScore};
use crosscut_evaluate::tables::{MAP_COLUMNS, map_cells};
use crosscut_evaluate::{Proportion, maps::MapTruth};
use crosscut_flight::{Flight, Map, Mapper, PARAMS};
use crosscut_messages::TruthMap;
use crosscut_sensor::Sensor;
use crosscut_simulator::{Flight as Scenes, Plan, scenarios};
use crosscut_stage::{Frame, Params, Value};
use nalgebra::{Isometry2, Vector2};

const DRIFTS: [Option<f64>; 5] = [Some(0.0), Some(0.02), Some(0.05), Some(0.1), None];

/// The figures of the flights with one drift, and the times of frames.
#[derive(Default)]
struct Sum {
    figures: FlightFigures,
    frames_ns: Vec<u128>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [names @ .., first, count] = &args[..] else { return Err("SCENARIO|PLAN.json... FIRST_SEED COUNT".into()) };
    let (first, count): (u64, u64) = (first.parse()?, count.parse()?);
    let mut sums: Vec<(&str, Vec<Sum>)> = Vec::new();
    let mut engine = Settings::new(Preset::Default).engine()?;
    for name in names {
        let mut of_drifts: Vec<Sum> = DRIFTS.iter().map(|_| Sum::default()).collect();
        for seed in first..first + count {
            fly(name, seed, &mut engine, &mut of_drifts)?;
        }
        sums.push((name, of_drifts));
    }
    print_maps(&sums);
    print_places(&sums);
    Ok(())
}

/// The flight through a scenario's mine, or through that of a plan.
fn scenes(name: &str, seed: u64) -> Result<Scenes, Box<dyn Error>> {
    if name.ends_with(".json") {
        return Ok(Plan::from_json(&std::fs::read_to_string(name)?)?.fly(seed)?);
    }
    let scenario = scenarios().iter().find(|scenario| scenario.name == name).ok_or("no such scenario")?;
    Ok((scenario.fly)(seed))
}

/// One flight, followed once for each drift.
fn fly(name: &str, seed: u64, engine: &mut Engine, sums: &mut [Sum]) -> Result<(), Box<dyn Error>> {
    let (sensor, mut frame) = (Sensor::default(), Frame::default());
    let mut flight = scenes(name, seed)?.peekable();
    let mine = flight.peek().and_then(|scene| scene.map.clone()).ok_or("a flight has a map")?;
    let mut runs = DRIFTS.iter().map(|drift| follower(*drift, &mine)).collect::<Result<Vec<_>, _>>()?;
    let (mut before, mut odometry) = (None, [Isometry2::identity(); DRIFTS.len()]);
    let mut truth = MapTruth::from(&mine);
    for scene in flight {
        frame.notes.clear();
        sensor.revolution(&scene.scan, &mut frame.revolution, &mut frame.notes);
        engine.process(&mut frame)?;
        let pose = scene.truth.pose.ok_or("a flight has poses")?;
        truth.add(frame.revolution.stamp_ns, &pose);
        let pose = Isometry2::new(Vector2::new(pose.x_m, pose.y_m), pose.yaw_rad);
        let step = before.replace(pose).map_or(Isometry2::identity(), |before: Isometry2<f64>| before.inv_mul(&pose));
        for (at, (flight, mapper, score)) in runs.iter_mut().enumerate() {
            frame.revolution.odometry = DRIFTS[at].map(|drift| {
                // To one side or the other, and too long or too short, as the seed says.
                let sign = if (seed + at as u64).is_multiple_of(2) { 1.0 } else { -1.0 };
                let moved = step.translation.vector * (1.0 + sign * drift);
                let turned_rad = step.rotation.angle() + sign * drift * 0.1 * moved.norm();
                odometry[at] *= Isometry2::new(moved, turned_rad);
                odometry[at]
            });
            let start = Instant::now();
            flight.add(&mut frame);
            mapper.add(&frame);
            sums[at].frames_ns.push(start.elapsed().as_nanos());
            score.add(&frame, &scene.truth);
        }
    }
    for (at, (_, mapper, score)) in runs.into_iter().enumerate() {
        let map = mapper.map();
        let figures = score.figures(&map);
        if std::env::var_os("MAPS_SAY").is_some() && figures.map.exact.hits == 0 {
            say(&format!("{name} {seed}, drift {:?}", DRIFTS[at]), &map, &truth);
        }
        sums[at].figures.merge(&figures);
    }
    Ok(())
}

fn follower(drift: Option<f64>, mine: &TruthMap) -> Result<(Flight, Mapper, FlightScore), Box<dyn Error>> {
    let mut params = Params::defaults(PARAMS);
    let kind = if drift.is_some() { "auto" } else { "scan_match" };
    params.set("pose", Value::String(kind.into()))?;
    Ok((Flight::new(&params, 0.6), Mapper::default(), FlightScore::new(mine)))
}

/// What is wrong with a map.
fn say(name: &str, map: &Map, truth: &MapTruth) {
    println!("{name}: {}", map.summary());
    map.refusals.iter().for_each(|refusal| println!("  at {}: {}", refusal.at_ns / 100_000_000, refusal.why));
    truth.differences(map).iter().for_each(|difference| println!("  {difference}"));
}

fn print_maps(sums: &[(&str, Vec<Sum>)]) {
    let header: Vec<&str> =
        ["flights", "drift", "nodes by"].into_iter().chain(MAP_COLUMNS).chain(["ms p50, p99, most"]).collect();
    println!("| {} |\n|{}", header.join(" | "), "---|".repeat(header.len()));
    for (name, sums) in sums {
        for (drift, sum) in DRIFTS.iter().zip(sums) {
            let drift = drift.map_or("scans alone".to_owned(), |drift| format!("{:.0} %", 100.0 * drift));
            let figures = &sum.figures;
            let mut times_ns = sum.frames_ns.clone();
            times_ns.sort_unstable();
            let ms = |share: f64| times_ns[((times_ns.len() - 1) as f64 * share) as usize] as f64 * 1e-6;
            let time = format!("{:.2}, {:.2}, {:.0}", ms(0.5), ms(0.99), ms(1.0));
            for (what, figures, time) in [
                ("map", &figures.map, time.as_str()),
                ("every change", &figures.every_change, ""),
                ("8 m", &figures.radius, ""),
            ] {
                println!("| {name} | {drift} | {what} | {} | {time} |", map_cells(figures).join(" | "));
            }
        }
    }
}

fn print_places(sums: &[(&str, Vec<Sum>)]) {
    println!("\n| flights | answer | junctions | passages | dead ends | chambers | count right | flicker |");
    println!("|---|---|---|---|---|---|---|---|");
    for (name, sums) in sums {
        // With the odometry of usual vehicles; the drift changes little.
        let of = &sums[1].figures;
        for (answer, here, count, flicker) in [
            ("single", &of.here, of.count, of.flicker),
            ("steady", &of.steady_here, of.steady_count, of.steady_flicker),
        ] {
            use crosscut_messages::TruthKind::{Chamber, DeadEnd, Junction, Passage};
            let of_kinds = [Junction, Passage, DeadEnd, Chamber]
                .map(|kind| percent(here.get(&kind).copied().unwrap_or_default(), 1));
            let (of_kinds, count, flicker) = (of_kinds.join(" | "), percent(count, 1), percent(flicker, 2));
            println!("| {name} | {answer} | {of_kinds} | {count} | {flicker} |");
        }
    }
}

fn percent(share: Proportion, decimals: usize) -> String {
    share.value().map_or_else(|| "-".to_owned(), |share| format!("{:.decimals$}", 100.0 * share))
}
