//! `here` on simulated flights, against the network of the mine.

use std::collections::BTreeMap;

use crosscut_flight::{Flight, Places};
use crosscut_ingest::{PARAMS, Sensor};
use crosscut_pipeline::{Preset, Settings};
use crosscut_simulator::{Scene, network::Network, network::Point, scenarios};
use crosscut_stage::{Frame, HereKind, Params};

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
    // A spur that hardly leaves the circle may be a way or a bay.
    let spurs = network
        .tunnels
        .iter()
        .filter(|tunnel| tunnel.ends.contains(&junction) && tunnel.ends.iter().any(|&end| network.degree(end) == 1));
    let width_m = 2.0 * network.half_width_at_m(junction);
    let length_m = |line: &[Point]| line.windows(2).map(|two| (two[1] - two[0]).norm()).sum::<f64>();
    let is_short = spurs.into_iter().any(|spur| length_m(&spur.centreline_m) < 2.5 * width_m);
    match () {
        () if is_short && to_junction < 2.0 => None,
        () if to_junction < 0.5 => Some((HereKind::Junction, network.degree(junction))),
        () if to_end < 0.8 && to_junction > 2.0 => Some((HereKind::DeadEnd, 1)),
        () if to_junction > 2.0 && to_end > 3.0 => Some((HereKind::Passage, 2)),
        () => None,
    }
}

#[test]
fn kind_and_ways_are_right_in_nine_of_ten_revolutions() {
    let mut places = Places::new(&Params::defaults(crosscut_flight::PARAMS), 0.6);
    let mut right: BTreeMap<String, [usize; 2]> = BTreeMap::new();
    for (name, seed) in [("tunnel", 1), ("tunnel", 2), ("mine", 1), ("mine", 2)] {
        let scenario = scenarios().iter().find(|scenario| scenario.name == name).expect("there is one");
        let mut engine = Settings::new(Preset::Default).engine().expect("the preset");
        let (sensor, mut frame) = (Sensor::new(&Params::defaults(PARAMS)), Frame::default());
        let flight = (scenario.fly)(seed);
        let network = flight.mine().network().clone();
        for scene in flight.step_by(3) {
            let pose = scene.pose.expect("of a flight");
            let Some((kind, ways)) = truth(&network, &pose.position_m) else { continue };
            frame.notes.clear();
            sensor.revolution(&scene.scan, &mut frame.revolution, &mut frame.notes);
            engine.process(&mut frame).expect("no failure");
            let found = places.here(&frame.revolution, &frame.junction, None).expect("a full turn");
            let is_right = found.kind == kind && found.ways.len() == ways;
            let entry = right.entry(format!("{name} {kind:?} {ways}")).or_default();
            entry[0] += usize::from(is_right);
            entry[1] += 1;
        }
    }
    for (of, [right, all]) in &right {
        println!("{of}: {right} of {all}");
    }
    // A place that has not been seen at all would make the bound below empty.
    assert!(right.len() >= 6, "{right:?}");
    for (of, [right, all]) in &right {
        assert!(*right as f64 >= 0.9 * *all as f64, "{of}: {right} of {all}");
    }
}

/// Leaves the beams within 120 degrees of straight ahead.
fn narrow(scene: &mut Scene) {
    let (first_rad, step_rad) = (f64::from(scene.scan.angle_min), f64::from(scene.scan.angle_increment));
    let beam_at = |bearing_deg: f64| ((bearing_deg.to_radians() - first_rad) / step_rad).round() as usize;
    let [first, last] = [beam_at(-120.0), beam_at(120.0)];
    let bearing_rad = |beam: usize| (first_rad + beam as f64 * step_rad) as f32;
    (scene.scan.angle_min, scene.scan.angle_max) = (bearing_rad(first), bearing_rad(last));
    scene.scan.ranges = scene.scan.ranges[first..=last].to_vec();
}

#[test]
fn a_limited_view_knows_what_earlier_scans_saw_behind() {
    let (mut revolutions, mut unknown, mut right, mut judged) = (0_u32, 0_u32, 0_u32, 0_u32);
    for (name, seed) in [("tunnel", 1), ("mine", 1)] {
        let scenario = scenarios().iter().find(|scenario| scenario.name == name).expect("there is one");
        let mut engine = Settings::new(Preset::Default).engine().expect("the preset");
        let (sensor, mut frame) = (Sensor::new(&Params::defaults(PARAMS)), Frame::default());
        let scenes = (scenario.fly)(seed);
        let network = scenes.mine().network().clone();
        let mut flight = Flight::new(&Params::defaults(crosscut_flight::PARAMS), 0.6);
        for (at, mut scene) in scenes.enumerate() {
            narrow(&mut scene);
            frame.notes.clear();
            sensor.revolution(&scene.scan, &mut frame.revolution, &mut frame.notes);
            engine.process(&mut frame).expect("no failure");
            flight.add(&mut frame);
            if at == 0 {
                assert_eq!(frame.here, None, "nothing is known of what lies behind");
            }
            revolutions += 1;
            unknown += u32::from(frame.here.is_none());
            let Some(found) = &frame.here else { continue };
            let pose = scene.pose.expect("of a flight");
            let Some(truth) = truth(&network, &pose.position_m) else { continue };
            judged += 1;
            right += u32::from(truth == (found.kind, found.ways.len()));
        }
    }
    println!("{unknown} of {revolutions} unknown, {right} of {judged} right");
    assert!(unknown * 10 < revolutions, "{unknown} of {revolutions} unknown");
    assert!(f64::from(right) >= 0.9 * f64::from(judged), "{right} of {judged} right");
}
