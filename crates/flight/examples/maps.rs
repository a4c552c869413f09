//! How often the map of a simulated flight is right: `cargo run --release -p crosscut-flight --example maps -- SCENARIO FIRST COUNT`.
//!
//! For odometry that drifts by 0, 2, 5 and 10 % and for scans alone, a line: maps that are exact (each junction and dead
//! end that was flown through is one node, each passage between two of them one passage), nodes over true nodes, nodes
//! that mix two places, true nodes, nodes without a true node, and the longest time that a frame took.
#![allow(clippy::print_stdout)] // the table is the output

use std::collections::{BTreeMap, BTreeSet};
use std::error::Error;
use std::time::Instant;

use crosscut_flight::{Flight, Map, Mapper, PARAMS};
use crosscut_ingest::Sensor;
use crosscut_pipeline::{Preset, Settings};
use crosscut_simulator::network::{Network, Point};
use crosscut_simulator::{Scene, scenarios};
use crosscut_stage::{Frame, Params, Value};
use nalgebra::{Isometry2, Vector2};

const DRIFTS: [Option<f64>; 5] = [Some(0.0), Some(0.02), Some(0.05), Some(0.1), None];

#[derive(Default)]
struct Score {
    flights: u32,
    exact: u32,
    nodes: usize,
    true_nodes: usize,
    mixed: usize,
    of_nothing: usize,
    missed: usize,
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
        let mut runs: Vec<(Flight, Mapper)> = DRIFTS
            .iter()
            .map(|drift| {
                let mut params = Params::defaults(PARAMS);
                let kind = if drift.is_some() { "auto" } else { "scan_match" };
                params.set("pose", Value::Text(kind.into())).map(|()| (Flight::new(&params, 0.6), Mapper::default()))
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
            for (at, (flight, mapper)) in runs.iter_mut().enumerate() {
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
            }
        }
        for (at, (_, mapper)) in runs.iter().enumerate() {
            let map = mapper.map();
            let score = scores.entry(at).or_default();
            let right = judge(&map, &network, &poses, score);
            if std::env::var_os("MAPS_SAY").is_some() {
                println!("seed {seed} drift {:?}: {} {}", DRIFTS[at], map.summary(), if right { "exact" } else { "" });
                for merge in &map.merges {
                    println!("  {}", merge.why);
                }
            }
        }
    }
    println!("drift | exact | nodes / true | mixed | of nothing | missed | p99 ms | max ms");
    for (at, score) in &mut scores {
        let of = DRIFTS[*at].map_or("scans".to_owned(), |drift| format!("{:.0} %", 100.0 * drift));
        score.frames_ns.sort_unstable();
        let at = |share: f64| score.frames_ns[((score.frames_ns.len() - 1) as f64 * share) as usize] as f64 / 1e6;
        let Score { flights, exact, nodes, true_nodes, mixed, of_nothing, missed, .. } = score;
        println!(
            "{of} | {exact}/{flights} | {nodes} / {true_nodes} | {mixed} | {of_nothing} | {missed} | {:.2} | {:.0}",
            at(0.99),
            at(1.0)
        );
    }
    Ok(())
}

fn true_pose(scene: &Scene) -> Option<Isometry2<f64>> {
    let pose = scene.pose?;
    Some(Isometry2::new(Vector2::new(pose.position_m.x, pose.position_m.y), pose.heading_rad))
}

/// The junction or dead end that a place belongs to, if any is near.
fn node_at(network: &Network, place_m: Point, widths: f64) -> Option<usize> {
    let is_node = |node: &usize| network.degree(*node) != 2;
    let off = |node: usize| (network.nodes[node].position_m - place_m).norm() / (2.0 * network.half_width_at_m(node));
    let near = (0..network.nodes.len()).filter(is_node).map(|node| (off(node), node));
    near.filter(|(off, _)| *off < widths).min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, node)| node)
}

fn judge(map: &Map, network: &Network, poses: &[(u64, Isometry2<f64>)], score: &mut Score) -> bool {
    // The nodes that were flown through, in order.
    let mut route: Vec<usize> = Vec::new();
    for (_, pose) in poses {
        let node = node_at(network, Point::from(pose.translation.vector), 0.4);
        if let Some(node) = node.filter(|node| route.last() != Some(node)) {
            route.push(node);
        }
    }
    let true_nodes: BTreeSet<usize> = route.iter().copied().collect();
    let ordered = |a: usize, b: usize| (a.min(b), a.max(b));
    let true_passages: BTreeSet<_> = route.windows(2).map(|pair| ordered(pair[0], pair[1])).collect();
    let middle = |[from_ns, to_ns]: [u64; 2]| {
        let during: Vec<_> = poses.iter().filter(|(ns, _)| (from_ns..=to_ns).contains(ns)).collect();
        during.get(during.len() / 2).map(|(_, pose)| Point::from(pose.translation.vector))
    };
    let is_of = |visit: &[u64; 2]| middle(*visit).and_then(|place_m| node_at(network, place_m, 1.6));
    let found: Vec<BTreeSet<Option<usize>>> =
        map.nodes.iter().map(|node| node.visits.iter().map(is_of).collect()).collect();
    let one = |node: usize| found[node].iter().next().copied().flatten();
    let passages: BTreeSet<_> =
        map.passages.iter().filter_map(|way| Some(ordered(one(way.from)?, one(way.to)?))).collect();
    let named: BTreeSet<usize> = (0..found.len()).filter_map(one).collect();
    if std::env::var_os("MAPS_SAY").is_some() {
        for (node, of) in map.nodes.iter().zip(&found) {
            println!(
                "  {of:?} {:?} {} ways at {:.1} {:.1}, {} visits",
                node.kind,
                node.ways.len(),
                node.position_m.x,
                node.position_m.y,
                node.visits.len()
            );
        }
        println!("  true route {route:?}");
    }
    let mixed = found.iter().filter(|of| of.len() > 1).count();
    score.flights += 1;
    score.nodes += map.nodes.len();
    score.true_nodes += true_nodes.len();
    score.mixed += mixed;
    score.of_nothing += found.iter().filter(|of| of.contains(&None)).count();
    score.missed += true_nodes.difference(&named).count();
    // Where the flight begins or ends, a node may be seen that was not flown through.
    let is_exact = mixed == 0
        && named.len() == map.nodes.len()
        && true_nodes.is_subset(&named)
        && passages.len() == map.passages.len()
        && true_passages.is_subset(&passages);
    score.exact += u32::from(is_exact);
    is_exact
}
