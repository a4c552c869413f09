//! `here` on simulated flights, against the network of the mine.

use std::collections::BTreeMap;

use crosscut_flight::{Flight, Places};
use crosscut_ingest::{PARAMS, Sensor};
use crosscut_messages::TruthPlace;
use crosscut_pipeline::{Preset, Settings};
use crosscut_simulator::{Scene, scenarios};
use crosscut_stage::{Frame, Here, Params};

fn is_right(here: &Here, truth: Option<TruthPlace>) -> bool {
    let kind = |truth: TruthPlace| format!("{:?}", truth.kind) == format!("{:?}", here.kind);
    truth.is_some_and(|truth| kind(truth) && truth.ways as usize == here.ways.len())
}

#[test]
fn kind_and_ways_are_right_in_nine_of_ten_revolutions() {
    let mut places = Places::new(&Params::defaults(crosscut_flight::PARAMS), 0.6);
    let mut right: BTreeMap<String, [usize; 2]> = BTreeMap::new();
    for (name, seed) in [("tunnel", 1), ("tunnel", 2), ("mine", 1), ("mine", 2)] {
        let scenario = scenarios().iter().find(|scenario| scenario.name == name).expect("there is one");
        let mut engine = Settings::new(Preset::Default).engine().expect("the preset");
        let (sensor, mut frame) = (Sensor::new(&Params::defaults(PARAMS)), Frame::default());
        for scene in (scenario.fly)(seed).step_by(3) {
            let Some(TruthPlace { kind, ways }) = scene.truth.here else { continue };
            frame.notes.clear();
            sensor.revolution(&scene.scan, &mut frame.revolution, &mut frame.notes);
            engine.process(&mut frame).expect("no failure");
            let found = places.here(&frame.revolution, &frame.junction, None).expect("a full turn");
            let is_right = is_right(&found, scene.truth.here);
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
        let mut flight = Flight::new(&Params::defaults(crosscut_flight::PARAMS), 0.6);
        for (at, mut scene) in (scenario.fly)(seed).enumerate() {
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
            if scene.truth.here.is_some() {
                judged += 1;
                right += u32::from(is_right(found, scene.truth.here));
            }
        }
    }
    println!("{unknown} of {revolutions} unknown, {right} of {judged} right");
    assert!(unknown * 10 < revolutions, "{unknown} of {revolutions} unknown");
    assert!(f64::from(right) >= 0.9 * f64::from(judged), "{right} of {judged} right");
}
