//! The closed loop: scan, detector, flight, map, planner, command.

use std::borrow::Cow;
use std::time::Instant;

use nalgebra::Point2;

use crosscut_detector::{Config, Registry};
use crosscut_flight::{Map, Mapper};
use crosscut_navigate::{Command, Limits, MissionEnd, Pilot, PilotStep, PlannerKind};
use crosscut_simulator::pose::Pose;
use crosscut_simulator::{Agility, Driven, Scene, World};
use crosscut_stage::{Failure, Frame};

use crate::judge::MissionJudge;

/// Contacts that are no farther apart than this are one crash, revolutions.
const SAME_CRASH: u64 = 20;

/// After this many crashes the mission is over.
const MOST_CRASHES: u32 = 10;

/// What a mission is flown with.
#[derive(Clone, Copy)]
pub struct Setup<'a> {
    /// The stages, the flight and the sensor.
    pub config: &'a Config,
    /// The stages to choose from.
    pub registry: &'a Registry,
    /// The planner.
    pub planner: PlannerKind,
    /// What the vehicle is able to do.
    pub agility: Agility,
    /// Seed of everything that is random in the vehicle and its lidar.
    pub seed: u64,
    /// What the vehicle had sensed, with its true poses, before the mission was interrupted; empty for a new mission.
    pub past: &'a [Scene],
}

/// One revolution of a mission, for those who watch it.
pub struct Moment<'a> {
    /// Makes what a recording has of the revolution: what was sensed, and its truth.
    pub scene: &'a dyn Fn() -> Scene,
    /// All that is known of the revolution.
    pub frame: &'a Frame,
    /// The map so far.
    pub mapper: &'a Mapper,
    /// What the navigator answered.
    pub step: &'a PilotStep,
    /// The true pose at the end of the revolution.
    pub true_pose: Pose,
}

/// What became of a mission.
#[derive(Clone, Debug)]
pub struct Flown {
    /// Ways of the mine.
    pub ways: usize,
    /// Those that were visited: flown through their middle, or their dead end seen from within 10 m.
    pub ways_visited: usize,
    /// The middles of those that were not, in the frame of the mine, metres.
    pub missed_m: Vec<Point2<f64>>,
    /// Entries into a way to a dead end that had been entered before; the one to home does not count.
    pub entered_in_vain: u32,
    /// The vehicle was within 5 m of its start at the end.
    pub home: bool,
    /// Contacts with the rock.
    pub crashes: u32,
    /// The true way flown, metres.
    pub way_m: f64,
    /// The least way through all of the mine and back, metres.
    pub offline_m: f64,
    /// `offline_m` is exact; else it is a bound from above.
    pub offline_is_exact: bool,
    /// The way of depth-first search on the true mine, metres.
    pub depth_first_m: f64,
    /// Revolutions.
    pub revolutions: u64,
    /// Decisions of the planner.
    pub decisions: u32,
    /// Those at which the count of walls was wrong.
    pub decisions_on_wrong_count: u32,
    /// How it ended; `None` if it was stopped from outside, after too many crashes, or by a failure.
    pub end: Option<MissionEnd>,
    /// A stage failed.
    pub failure: Option<Failure>,
    /// The map at the end.
    pub map: Map,
    /// The time that each revolution took from the scan to the command, without the simulator, nanoseconds. It is not part
    /// of the results.
    pub loop_ns: Vec<u64>,
}

impl Flown {
    /// Every way was visited, and the vehicle is home without a crash.
    pub fn is_success(&self) -> bool {
        self.ways_visited == self.ways && self.home && self.crashes == 0
    }

    /// The time that this share of the revolutions did not exceed, from the scan to the command, milliseconds; 0 without any.
    pub fn loop_ms(&self, share: f64) -> f64 {
        let mut loop_ns = self.loop_ns.clone();
        loop_ns.sort_unstable();
        let at = (loop_ns.len().saturating_sub(1) as f64 * share.clamp(0.0, 1.0)).round() as usize;
        loop_ns.get(at).map_or(0.0, |&of_ns| of_ns as f64 * 1e-6)
    }
}

/// Flies a mission. `watch` sees every revolution, and stops the mission by returning `false`.
///
/// The vehicle senses for one revolution while it obeys the command that it was given after the revolution before. Contact
/// with the rock is counted as a crash; the vehicle then stands where it last was clear, and the mission goes on.
///
/// A mission that was interrupted is resumed from its past: the pilot takes all that the vehicle had sensed, which brings it to
/// where it was, map and all. The vehicle then stands at its last place, and the mission continues from there.
pub fn fly(world: &World, setup: &Setup, watch: &mut dyn FnMut(&Moment) -> bool) -> Flown {
    let Agility { speed_max_m_s, turn_rate_max_rad_s, radius_m, .. } = setup.agility;
    let limits = Limits { speed_max_m_s, turn_rate_max_rad_s, radius_m };
    let mut pilot = Pilot::new(setup.config, setup.registry, setup.planner, limits);
    let resumed = setup.past.last().and_then(|last| Driven::resumed(world, setup.agility, setup.seed, last));
    let mut driven = resumed.unwrap_or_else(|| Driven::new(world, setup.agility, setup.seed));
    let mut past = setup.past.iter().filter_map(|scene| Some((scene, world.pose_of(&scene.truth.pose?))));
    let mut judge = MissionJudge::new(world);
    let mut command = Command::default();
    let mut flown = Flown::new(&judge);
    let mut last_contact: Option<u64> = None;
    let mut last_m: Option<Point2<f64>> = None;
    loop {
        let replayed = past.next();
        let scene = replayed.map_or_else(
            || Cow::Owned(driven.step(command.speed_m_s, command.turn_rate_rad_s)),
            |(scene, _)| Cow::Borrowed(scene),
        );
        let true_pose = replayed.map_or_else(|| driven.pose(), |(_, pose)| pose);
        judge.add(true_pose.position_m);
        flown.way_m +=
            last_m.replace(true_pose.position_m).map_or(0.0, |last_m| (true_pose.position_m - last_m).norm());
        if replayed.map_or_else(|| driven.is_in_contact(), |(scene, _)| scene.truth.contact) {
            flown.crashes += u32::from(last_contact.is_none_or(|last| flown.revolutions - last > SAME_CRASH));
            last_contact = Some(flown.revolutions);
        }
        let began = Instant::now();
        let step = pilot.step(|sensor, frame| {
            sensor.revolution(&scene.scan, &mut frame.revolution, &mut frame.notes);
            frame.revolution.stamp_ns = scene.stamp_ns;
            frame.revolution.odometry = scene.odometry_pose();
        });
        let step = match step {
            Ok(step) => step,
            Err(failure) => {
                flown.failure = Some(failure);
                break;
            }
        };
        flown.loop_ns.push(u64::try_from(began.elapsed().as_nanos()).unwrap_or(u64::MAX));
        flown.revolutions += 1;
        if step.decision.is_some() {
            flown.decisions += 1;
            let walls = replayed.map_or_else(|| driven.walls_in_view(), |(scene, _)| scene.truth.walls);
            flown.decisions_on_wrong_count += u32::from(pilot.frame().junction.junctions != walls as usize);
        }
        command = step.command;
        let scene = || {
            let truth = replayed.map_or_else(|| driven.truth(), |(scene, _)| scene.truth.clone());
            Scene { truth, ..Scene::clone(&scene) }
        };
        let (frame, mapper) = (pilot.frame(), pilot.mapper());
        let goes_on = watch(&Moment { scene: &scene, frame, mapper, step: &step, true_pose });
        flown.end = step.end;
        if flown.end.is_some() || !goes_on || flown.crashes >= MOST_CRASHES {
            break;
        }
    }
    flown.finish(&judge, last_m, pilot.mapper().map())
}

impl Flown {
    fn new(judge: &MissionJudge) -> Self {
        let (offline_m, offline_is_exact) = judge.offline_m();
        Self {
            ways: judge.ways(),
            ways_visited: 0,
            missed_m: Vec::new(),
            entered_in_vain: 0,
            home: false,
            crashes: 0,
            way_m: 0.0,
            offline_m,
            offline_is_exact,
            depth_first_m: judge.depth_first_m(),
            revolutions: 0,
            decisions: 0,
            decisions_on_wrong_count: 0,
            end: None,
            failure: None,
            map: Map::default(),
            loop_ns: Vec::new(),
        }
    }

    fn finish(mut self, judge: &MissionJudge, last_m: Option<Point2<f64>>, map: Map) -> Self {
        self.ways_visited = judge.visited();
        self.missed_m = judge.missed_m();
        self.entered_in_vain = judge.in_vain();
        self.home = last_m.is_some_and(|last_m| judge.is_home(last_m));
        self.map = map;
        self
    }
}
