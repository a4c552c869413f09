//! Poses, places, steady answers and maps of flights: on simulated ones against the truth, the pose graph and scan matching
//! against independent checks.

mod doubt;
mod maps;
mod places;
mod pose_graph;
mod scan_match;
mod simulated;
mod steady;

use crosscut_detector::{Preset, Settings};
use crosscut_flight::Flight;
use crosscut_sensor::Sensor;
use crosscut_simulator::{Scenario, Scene, scenarios};
use crosscut_stage::{Frame, Params};

fn scenario(name: &str) -> &'static Scenario {
    scenarios().iter().find(|scenario| scenario.name == name).expect("there is one")
}

/// Follows a flight of the simulator. `edit` changes a scene before it is processed, `each` takes the scene and its frame.
fn follow(name: &str, seed: u64, revolutions: usize, edit: impl Fn(&mut Scene), mut each: impl FnMut(&Scene, &Frame)) {
    let (sensor, mut engine) = (Sensor::default(), Settings::new(Preset::Default).engine().expect("the preset"));
    let mut flight = Flight::new(&Params::defaults(crosscut_flight::PARAMS), 0.6);
    let mut frame = Frame::default();
    for mut scene in (scenario(name).fly)(seed).take(revolutions) {
        edit(&mut scene);
        frame.notes.clear();
        sensor.revolution(&scene.scan, &mut frame.revolution, &mut frame.notes);
        engine.process(&mut frame).expect("no failure");
        flight.add(&mut frame);
        each(&scene, &frame);
    }
}
