//! How often the map of a simulated flight is right: `cargo run --release -p crosscut-flight --example maps -- SCENARIO FIRST COUNT`.
//!
//! For odometry that drifts by 0, 2, 5 and 10 % and for scans alone, a line each for the map, for counting every change of
//! the count as a new junction, and for taking all within 8 m of the pose to be one. The columns are the figures of
//! `crosscut_evaluate::maps`, and the time that a frame took.
#![allow(clippy::print_stdout)] // the table is the output

use std::collections::BTreeMap;
use std::error::Error;
use std::time::Instant;

use crosscut_evaluate::Proportion;
use crosscut_evaluate::maps::{
    Counts, MapFigures, MapTruth, TruePassage, TruePlace, WhereAt, every_change, within_radius,
};
use crosscut_flight::{Flight, Mapper, PARAMS};
use crosscut_ingest::Sensor;
use crosscut_pipeline::{Preset, Settings};
use crosscut_simulator::network::Network;
use crosscut_simulator::{Scene, scenarios};
use crosscut_stage::{Frame, Params, Value};
use nalgebra::{Isometry2, Vector2};

const DRIFTS: [Option<f64>; 5] = [Some(0.0), Some(0.02), Some(0.05), Some(0.1), None];

/// The figures of maps, of the two baselines, and the times of frames.
#[derive(Default)]
struct Score {
    map: MapFigures,
    changes: MapFigures,
    radius: MapFigures,
    frames_ns: Vec<u128>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [name, first, count] = &args[..] else { return Err("SCENARIO FIRST COUNT".into()) };
    let (first, count): (u64, u64) = (first.parse()?, count.parse()?);
    let scenario = scenarios().iter().find(|scenario| scenario.name == name).ok_or("no such scenario")?;
    let mut scores: BTreeMap<usize, Score> = BTreeMap::new();
    for seed in first..first + count {
        let flight = (scenario.fly)(seed);
        let network = flight.mine().network().clone();
        let (sensor, mut engine) = (Sensor::default(), Settings::new(Preset::Default).engine()?);
        let mut runs: Vec<(Flight, Mapper, Counts)> = DRIFTS
            .iter()
            .map(|drift| {
                let mut params = Params::defaults(PARAMS);
                let kind = if drift.is_some() { "auto" } else { "scan_match" };
                params
                    .set("pose", Value::Text(kind.into()))
                    .map(|()| (Flight::new(&params, 0.6), Mapper::default(), Counts::default()))
            })
            .collect::<Result<_, _>>()?;
        let (mut frame, mut poses, mut odometry) = (Frame::default(), Vec::new(), [Isometry2::identity(); 5]);
        for scene in flight {
            frame.notes.clear();
            sensor.revolution(&scene.scan, &mut frame.revolution, &mut frame.notes);
            engine.process(&mut frame)?;
            let pose = true_pose(&scene).ok_or("a flight has poses")?;
            let step =
                poses.last().map_or(Isometry2::identity(), |(_, before): &(u64, Isometry2<f64>)| before.inv_mul(&pose));
            poses.push((frame.revolution.stamp_ns, pose));
            for (at, (flight, mapper, counts)) in runs.iter_mut().enumerate() {
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
                scores.entry(at).or_default().frames_ns.push(start.elapsed().as_nanos());
                if let Some(tracked) = frame.pose {
                    let position_m = tracked.translation.vector.into();
                    counts.add(frame.junction.junctions, WhereAt { stamp_ns: frame.revolution.stamp_ns, position_m });
                }
            }
        }
        let truth = truth(&network, &poses);
        for (at, (_, mapper, counts)) in runs.into_iter().enumerate() {
            let (map, stays) = (mapper.map(), counts.stays());
            let figures = MapFigures::of(&map, &truth);
            if std::env::var_os("MAPS_SAY").is_some() {
                let exact = if figures.exact.hits == 1 { "exact" } else { "not exact" };
                println!("seed {seed} drift {:?}: {exact}: {}", DRIFTS[at], map.summary());
                map.merges.iter().for_each(|merge| println!("  {}", merge.why));
            }
            let score = scores.entry(at).or_default();
            score.map.merge(&figures);
            score.changes.merge(&MapFigures::of_visits(&every_change(&stays), &truth));
            score.radius.merge(&MapFigures::of_visits(&within_radius(&stays, 8.0), &truth));
        }
    }
    println!(
        "drift | what | exact % | F1 | nodes / true | same P % | same R % | false merges | degree % | passages % (false) | loops % (false) | p99 ms | max ms"
    );
    for (at, score) in &mut scores {
        let of = DRIFTS[*at].map_or("scans".to_owned(), |drift| format!("{:.0} %", 100.0 * drift));
        score.frames_ns.sort_unstable();
        let ms = |share: f64| score.frames_ns[((score.frames_ns.len() - 1) as f64 * share) as usize] as f64 / 1e6;
        for (what, figures) in [("map", &score.map), ("every change", &score.changes), ("8 m", &score.radius)] {
            println!(
                "{of} | {what} | {} | {:.2} | {:.2} | {} | {} | {} | {} | {} ({}) | {} ({}) | {:.2} | {:.0}",
                percent(figures.exact),
                figures.f1().unwrap_or_default(),
                figures.over_count().unwrap_or_default(),
                percent(figures.same_precision),
                percent(figures.same_recall),
                figures.false_merges,
                percent(figures.degree),
                percent(figures.passages),
                figures.false_passages,
                percent(figures.loops),
                figures.false_loops,
                ms(0.99),
                ms(1.0)
            );
        }
    }
    Ok(())
}

fn true_pose(scene: &Scene) -> Option<Isometry2<f64>> {
    let pose = scene.pose?;
    Some(Isometry2::new(Vector2::new(pose.position_m.x, pose.position_m.y), pose.heading_rad))
}

/// Junctions and dead ends of a mine, the passages between them, and where each revolution was taken.
fn truth(network: &Network, poses: &[(u64, Isometry2<f64>)]) -> MapTruth {
    let is_place = |node: usize| network.degree(node) != 2;
    let numbered: Vec<usize> = (0..network.nodes.len()).filter(|&node| is_place(node)).collect();
    let number = |node: usize| numbered.iter().position(|&other| other == node);
    let place = |&node: &usize| TruePlace {
        position_m: network.nodes[node].position_m.into(),
        ways: network.degree(node),
        width_m: 2.0 * network.half_width_at_m(node),
    };
    let mut passages = Vec::new();
    for &from in &numbered {
        for first in (0..network.tunnels.len()).filter(|&tunnel| network.tunnels[tunnel].ends.contains(&from)) {
            // Along bends to the next place.
            let (mut at, mut by, mut along_m) = (from, first, 0.0);
            loop {
                along_m += network.tunnels[by].length_m();
                let ends = network.tunnels[by].ends;
                at = if ends[0] == at { ends[1] } else { ends[0] };
                let goes_on = (0..network.tunnels.len()).find(|&t| t != by && network.tunnels[t].ends.contains(&at));
                match goes_on.filter(|_| !is_place(at)) {
                    Some(next) => by = next,
                    None => break,
                }
            }
            if let (Some(from), Some(to)) = (number(from), number(at).filter(|_| at >= from)) {
                passages.push(TruePassage { ends: [from, to], length_m: along_m });
            }
        }
    }
    let at =
        |&(stamp_ns, pose): &(u64, Isometry2<f64>)| WhereAt { stamp_ns, position_m: pose.translation.vector.into() };
    MapTruth { places: numbered.iter().map(place).collect(), passages, at: poses.iter().map(at).collect() }
}

fn percent(share: Proportion) -> String {
    share.value().map_or_else(|| "-".to_owned(), |share| format!("{:.0}", 100.0 * share))
}
