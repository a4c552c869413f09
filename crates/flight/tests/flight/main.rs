//! Poses, places, steady answers and maps of flights: on simulated ones against the truth, the pose graph and scan matching
//! against independent checks.

mod doubt;
mod maps;
mod places;
mod pose_graph;
mod scan_match;
mod simulated;
mod steady;

use crosscut_detector::{Engine, Preset, Settings};
use crosscut_flight::Flight;
use crosscut_sensor::Sensor;
use crosscut_simulator::{Scenario, Scene, scenarios};
use crosscut_stage::{Frame, Params};

fn scenario(name: &str) -> &'static Scenario {
    scenarios().iter().find(|scenario| scenario.name == name).expect("there is one")
}

/// Answers the scenes of a flight, in order.
struct Follower {
    sensor: Sensor,
    engine: Engine,
    flight: Flight,
    frame: Frame,
}

impl Default for Follower {
    fn default() -> Self {
        let engine = Settings::new(Preset::Default).engine().expect("the preset");
        let flight = Flight::new(&Params::defaults(crosscut_flight::PARAMS), 0.6);
        Self { sensor: Sensor::default(), engine, flight, frame: Frame::default() }
    }
}

impl Follower {
    fn follow(&mut self, scene: &Scene) -> &Frame {
        let Self { sensor, engine, flight, frame } = self;
        frame.notes.clear();
        sensor.revolution(&scene.scan, &mut frame.revolution, &mut frame.notes);
        engine.process(frame).expect("no failure");
        flight.add(frame);
        frame
    }
}

/// Follows a flight of the simulator. `edit` changes a scene before it is processed, `each` takes the scene and its frame.
fn follow(name: &str, seed: u64, revolutions: usize, edit: impl Fn(&mut Scene), mut each: impl FnMut(&Scene, &Frame)) {
    let mut follower = Follower::default();
    for mut scene in (scenario(name).fly)(seed).take(revolutions) {
        edit(&mut scene);
        let frame = follower.follow(&scene);
        each(&scene, frame);
    }
}
