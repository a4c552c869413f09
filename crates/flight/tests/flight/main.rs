//! Poses, places, steady answers and maps of flights: on simulated ones against the truth, the pose graph and scan matching
//! against independent checks.

mod doubt;
mod maps;
mod places;
mod pose_graph;
mod scan_match;
mod simulated;
mod steady;

use std::sync::LazyLock;

use crosscut_detector::{Engine, Preset, Settings};
use crosscut_flight::{Flight, FlightAnswer, Map, Mapper};
use crosscut_messages::TruthPlace;
use crosscut_sensor::Sensor;
use crosscut_simulator::network::Network;
use crosscut_simulator::{Scenario, Scene, scenarios};
use crosscut_stage::{Frame, Params};
use nalgebra::Isometry2;

/// The flights that several tests ask.
static TUNNEL: LazyLock<Flown> = LazyLock::new(|| Flown::of("tunnel", 1, usize::MAX));
static MINE: LazyLock<Flown> = LazyLock::new(|| Flown::of("mine", 1, usize::MAX));

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

/// A flight of the simulator with its answers.
struct Flown {
    network: Network,
    revolutions: Vec<Seen>,
    map: Map,
}

/// What is known of a revolution, and its answers.
struct Seen {
    stamp_ns: u64,
    true_walls: usize,
    true_pose: Isometry2<f64>,
    true_here: Option<TruthPlace>,
    junctions: usize,
    answer: FlightAnswer,
}

impl Flown {
    fn of(name: &str, seed: u64, revolutions: usize) -> Self {
        let network = (scenario(name).fly)(seed).mine().network().clone();
        let (mut mapper, mut seen) = (Mapper::default(), Vec::new());
        let each = |scene: &Scene, frame: &Frame| {
            mapper.add(frame);
            let pose = scene.pose.as_ref().expect("a scene of a flight");
            seen.push(Seen {
                stamp_ns: frame.revolution.stamp_ns,
                true_walls: scene.truth.walls as usize,
                true_pose: Isometry2::new(pose.position_m.coords, pose.heading_rad),
                true_here: scene.truth.here,
                junctions: frame.junction.junctions,
                answer: FlightAnswer::of(frame).clone(),
            });
        };
        follow(name, seed, revolutions, |_| {}, each);
        Self { network, revolutions: seen, map: mapper.map() }
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
