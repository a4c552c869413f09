//! `here` on simulated flights, against the network of the mine.

use std::collections::BTreeMap;

use crosscut_flight::{HereKind, here};
use crosscut_ingest::{PARAMS, Sensor};
use crosscut_pipeline::{Preset, Settings};
use crosscut_simulator::{network::Network, network::Point, scenarios};
use crosscut_stage::{Frame, Params};

/// What lies at a position: kind and number of ways; `None` between two kinds of place.
fn truth(network: &Network, at_m: &Point) -> Option<(HereKind, usize)> {
    let by_distance = |degrees: fn(usize) -> bool| {
        let nodes = (0..network.nodes.len()).filter(move |&node| degrees(network.degree(node)));
        let widths = nodes.map(|node| {
            let distance_m = (network.nodes[node].position_m - at_m).norm();
            (distance_m / (2.0 * network.half_width_at_m(node)), node)
        });
        widths.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((f64::INFINITY, 0))
    };
    let (to_junction, junction) = by_distance(|degree| degree >= 3);
    let (to_end, _) = by_distance(|degree| degree == 1);
    match () {
        () if to_junction < 0.6 => Some((HereKind::Junction, network.degree(junction))),
        () if to_end < 0.8 && to_junction > 2.0 => Some((HereKind::DeadEnd, 1)),
        () if to_junction > 2.0 && to_end > 3.0 => Some((HereKind::Passage, 2)),
        () => None,
    }
}

#[test]
fn the_place_is_found_among_all_openings_in_view() {
    let mut right: BTreeMap<String, [usize; 2]> = BTreeMap::new();
    for (name, seed) in [("tunnel", 1), ("tunnel", 2), ("mine", 1), ("mine", 2)] {
        let scenario = scenarios().iter().find(|scenario| scenario.name == name).expect("there is one");
        let mut engine = Settings::new(Preset::Default).engine().expect("the preset");
        let (sensor, mut frame) = (Sensor::new(&Params::defaults(PARAMS)), Frame::default());
        let flight = (scenario.fly)(seed);
        let network = flight.mine().network().clone();
        let mut whole = 0;
        for scene in flight.step_by(6) {
            let pose = scene.pose.expect("of a flight");
            let Some((kind, ways)) = truth(&network, &pose.position_m) else { continue };
            frame.notes.clear();
            sensor.revolution(&scene.scan, &mut frame.revolution, &mut frame.notes);
            engine.process(&mut frame).expect("no failure");
            let found = here(&frame.revolution, &frame.junction, 0.6).expect("a full turn");
            let is_right = found.kind == kind && found.ways.len() + found.closed == ways;
            let entry = right.entry(format!("{name} {kind:?} {ways}")).or_default();
            entry[0] += usize::from(is_right);
            entry[1] += 1;
            whole += usize::from(frame.junction.openings.len() == ways);
        }
        println!("{name} {seed}: by all openings in view {whole}");
    }
    for (of, [right, all]) in &right {
        println!("{of}: {right} of {all}, {:.1} %", 100.0 * *right as f64 / *all as f64);
    }
    let [right, all] = right.values().fold([0, 0], |sum, entry| [sum[0] + entry[0], sum[1] + entry[1]]);
    // All openings in view give the number of ways in 70 % of them.
    assert!(20 * right > 17 * all, "{right} of {all}");
}
