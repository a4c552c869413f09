//! The answers of the default method to simulated scans, for several vehicles.

use crosscut_detector::{Config, Engine, Layer, Preset, Registry};
use crosscut_sensor::Sensor;
use crosscut_simulator::{Split, Suite, suites};
use crosscut_stage::{Beam, Frame, Junction, Notes, Place, Revolution, Sweep};

/// One scan in this many is taken.
const SCENES_STEP: usize = 60;

/// The blind sector: from a fifth of the turn to two fifths.
fn sector(beams: usize) -> std::ops::Range<usize> {
    beams / 5..2 * beams / 5
}

/// The scan with nothing known in the sector.
fn blinded(scan: &Revolution) -> Revolution {
    let of = scan.sweep.as_ref().expect("beams");
    let hidden = sector(of.len());
    let seen = |at: usize| if hidden.contains(&at) { Beam::Unknown } else { of.beams[at] };
    looking(scan, (0..of.len()).map(|at| (of.bearings_rad[at], seen(at))), true)
}

/// The scan by a sensor that does not look into the sector.
fn limited(scan: &Revolution) -> Revolution {
    let of = scan.sweep.as_ref().expect("beams");
    let hidden = sector(of.len());
    let order = (hidden.end..of.len()).chain(0..hidden.start);
    looking(scan, order.map(|at| (of.bearings_rad[at], of.beams[at])), false)
}

/// A scan of these beams alone, each with its bearing.
pub(crate) fn looking(scan: &Revolution, seen: impl Iterator<Item = (f64, Beam)>, full_turn: bool) -> Revolution {
    let of = scan.sweep.clone().expect("beams");
    let mut revolution = Revolution::default();
    let sweep = revolution.sweep.insert(Sweep { beams: Vec::new(), bearings_rad: Vec::new(), full_turn, ..of });
    for (bearing_rad, mut beam) in seen {
        if let Beam::Return(i) = &mut beam {
            revolution.points_m.push(scan.points_m[*i as usize]);
            *i = revolution.points_m.len() as u32 - 1;
        }
        sweep.bearings_rad.push(bearing_rad);
        sweep.beams.push(beam);
    }
    revolution
}

pub(crate) fn engine(settings: &[&str]) -> Engine {
    let registry = Registry::standard();
    let settings: Vec<String> = settings.iter().map(ToString::to_string).collect();
    let layers = [Preset::Default.into(), Layer::settings("--set", &settings).expect("settings")];
    Engine::new(&Config::resolve(&registry, &layers).expect("allowed"), &registry)
}

/// One scan in `step` of a suite, each with its name.
pub(crate) fn scans(suite: &Suite, step: usize) -> impl Iterator<Item = (String, Revolution)> {
    let sensor = Sensor::default();
    suite.scenes(Split::Dev).enumerate().step_by(step).map(move |(number, scene)| {
        let mut scan = Revolution::default();
        sensor.revolution(&scene.scan, &mut scan, &mut Notes::default());
        (format!("{} {number}", suite.name), scan)
    })
}

fn some_scans(suite: &Suite) -> impl Iterator<Item = (String, Revolution)> {
    scans(suite, SCENES_STEP)
}

fn answer(engine: &mut Engine, revolution: Revolution) -> Junction {
    let mut frame = Frame { revolution, ..Frame::default() };
    engine.process(&mut frame).expect("a sound scan");
    frame.junction
}

#[test]
fn what_a_vehicle_hides_all_the_time_is_outside_the_view() {
    let mut engine = engine(&[]);
    let mut compared = 0;
    for (name, scan) in suites().iter().flat_map(some_scans) {
        if !scan.sweep.as_ref().is_some_and(|sweep| sweep.full_turn) {
            continue;
        }
        let (ours, other) = (answer(&mut engine, blinded(&scan)), answer(&mut engine, limited(&scan)));
        assert_eq!((ours.place, ours.junctions), (Place::PartialView, other.junctions), "{name}");
        let ways = |answer: &Junction| -> Vec<_> {
            answer.openings.iter().map(|opening| (opening.bearing_rad, opening.width_m)).collect()
        };
        assert_eq!(ways(&ours), ways(&other), "{name}");
        compared += 1;
    }
    assert!(compared > 50, "{compared}");
}

#[test]
fn no_opening_is_narrower_than_the_vehicle() {
    const WIDTH_M: f64 = 1.8;
    for rule in ["between_walls", "free_space"] {
        let mut engine = engine(&["vehicle.width_m=1.8", &format!("report.openings={rule}")]);
        let mut widths_m = Vec::new();
        for (_, scan) in suites().iter().filter(|suite| ["narrow", "wet"].contains(&suite.name)).flat_map(some_scans) {
            widths_m.extend(answer(&mut engine, scan).openings.iter().map(|opening| opening.width_m));
        }
        assert!(widths_m.len() > 10 && widths_m.iter().all(|&width_m| width_m >= WIDTH_M), "{rule}: {widths_m:?}");
    }
}
