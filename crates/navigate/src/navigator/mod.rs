//! The navigator: follows passages, stops at places, asks the planner, leaves by the way that it chose.

mod answer;
mod at_place;
mod deciding;
mod following;
mod homing;
mod start;

use std::f64::consts::PI;

use crosscut_flight::{FlightAnswer, HereKind, Mapper};
use crosscut_stage::{Frame, wrap_angle_rad};
use nalgebra::{Isometry2, Point2};

use self::start::Start;
use crate::chart::{Chart, WayEnd};
use crate::planner::Planner;
use crate::steering::towards;
use crate::surround::Surround;
use crate::trail::Trail;
use crate::{Command, Limits};

pub use answer::{MissionEnd, PilotStep, PlaceDecision};

/// The vehicle turns back where it is free for less than this ahead, m.
const BEFORE_FACE_M: f64 = 1.3;

/// The vehicle has left a place once it is this much farther away than its look, m.
const BEYOND_LOOK_M: f64 = 0.7;

/// Progress is less than a metre in this many revolutions: the vehicle is stuck.
const STUCK_AFTER: u64 = 200;
const STUCK_M: f64 = 1.0;

/// The mission is given up after this many times in a row.
const MOST_STUCK: u32 = 6;

/// A mission that finds nothing new is given up after this many revolutions, and these for each metre of the map and of the
/// farthest place from the start: a passage is on the map once its end is found.
const LIMIT: f64 = 1500.0;
const LIMIT_PER_M: f64 = 30.0;

/// What the navigator is doing.
#[derive(Clone, Copy, Debug)]
enum Doing {
    /// Following a passage.
    Follow,
    /// At a place, on the way to where it is decided.
    Arrive { kind: HereKind, began: u64, from_m: Point2<f64>, last_seen: u64 },
    /// Leaving a place by a chosen way.
    Leave { began: u64 },
}

impl Doing {
    fn name(self) -> &'static str {
        match self {
            Self::Follow => "follows",
            Self::Arrive { .. } => "arrives",
            Self::Leave { .. } => "leaves",
        }
    }
}

/// The place that was left last. Poses are as they were tracked.
#[derive(Clone, Copy, Debug)]
struct Left {
    at_m: Point2<f64>,
    bearing_rad: f64,
    look_m: f64,
    kind: HereKind,
    /// The way that it is to be left by, if it is on the map.
    place: Option<WayEnd>,
}

/// Flies a vehicle by what the frames of its flight show.
pub struct Navigator {
    planner: Box<dyn Planner>,
    limits: Limits,
    surround: Surround,
    chart: Chart,
    trail: Trail,
    doing: Doing,
    /// The direction that the vehicle is to fly in, in the axes of the tracked poses.
    course_rad: f64,
    goal_m: Point2<f64>,
    /// Brings tracked poses into the frame of the map.
    correction: Isometry2<f64>,
    /// Visits that have ended when the correction was made.
    visits: usize,
    left: Option<Left>,
    /// A passage was seen since the last place.
    is_armed: bool,
    goes_home: bool,
    /// Decisions in a row without a route to a way that is left.
    cut_off: u32,
    start: Start,
    /// What looks like home by the map does not by what is seen: the map is wrong, until the next place.
    is_elsewhere: bool,
    /// The corrections by which the walls in view lay on those of the start, and from where.
    seen_home: Vec<(Isometry2<f64>, Point2<f64>)>,
    /// Revolutions near home on the way there.
    near_home: u64,
    now: u64,
    last_m: Option<Point2<f64>>,
    without_way: u64,
    progress: (u64, Point2<f64>),
    stuck: u32,
    last_new: u64,
    map_m: f64,
    /// The farthest that the vehicle was from its start.
    farthest_m: f64,
}

impl Navigator {
    /// For a vehicle with these limits.
    pub fn new(planner: Box<dyn Planner>, limits: Limits) -> Self {
        Self {
            planner,
            limits,
            surround: Surround::new(limits.radius_m),
            chart: Chart::default(),
            trail: Trail::default(),
            doing: Doing::Follow,
            course_rad: 0.0,
            goal_m: Point2::origin(),
            correction: Isometry2::identity(),
            visits: 0,
            left: None,
            is_armed: true,
            goes_home: false,
            cut_off: 0,
            start: Start::default(),
            is_elsewhere: false,
            seen_home: Vec::new(),
            near_home: 0,
            now: 0,
            last_m: None,
            without_way: 0,
            progress: (0, Point2::origin()),
            stuck: 0,
            last_new: 0,
            map_m: 0.0,
            farthest_m: 0.0,
        }
    }

    /// The command after the next frame, which the flight has filled and the mapper has taken.
    pub fn step(&mut self, frame: &Frame, mapper: &Mapper) -> PilotStep {
        self.now += 1;
        let flown = FlightAnswer::of(frame);
        let Some(pose) = flown.pose else {
            return self.rests("waits", self.limit());
        };
        let here_m = Point2::from(pose.translation.vector);
        self.surround.add(&frame.revolution, &pose);
        let field = self.surround.field(here_m);
        self.move_to(here_m);
        self.trail.add(pose, mapper);
        self.follow_the_map(&pose, mapper);
        let steady = flown.steady_here();
        if self.is_home(frame, flown.here.as_ref(), &pose, mapper) {
            return self.rests("is home", Some(MissionEnd::Home));
        }
        if let Some(home_m) = self.home_in_reach(here_m, &field) {
            self.goal_m = home_m;
            let (end, command) = (self.watch(here_m, mapper), towards(home_m, true, &field, &pose, &self.limits));
            return PilotStep { command, end, ..self.rests("goes home", None) };
        }
        let (mut decision, mut stops) = (None, false);
        match self.doing {
            Doing::Follow => self.follow(flown.here.as_ref(), steady, &pose, &field),
            Doing::Leave { began } => self.leave(flown.here.as_ref(), steady, &pose, began),
            Doing::Arrive { kind, .. } => {
                stops = true;
                if self.is_to_decide(steady, &pose, &field, mapper) {
                    let located = mapper.is_in_node().then(|| mapper.located()).flatten();
                    decision = Some(self.decide(located, kind, frame, &pose));
                }
            }
        }
        let end = self.watch(here_m, mapper);
        let command = towards(self.goal_m, stops, &field, &pose, &self.limits);
        PilotStep { command, goal_m: self.goal_m, correction: self.correction, doing: self.doing.name(), decision, end }
    }

    fn rests(&self, doing: &'static str, end: Option<MissionEnd>) -> PilotStep {
        let (command, goal_m, correction) = (Command::default(), self.goal_m, self.correction);
        PilotStep { command, goal_m, correction, doing, decision: None, end }
    }

    fn move_to(&mut self, here_m: Point2<f64>) {
        let moved_m = self.last_m.map_or(f64::INFINITY, |last_m| (here_m - last_m).norm());
        if moved_m > 0.2 {
            self.farthest_m = self.farthest_m.max(here_m.coords.norm());
            self.last_m = Some(here_m);
        }
    }

    /// At a decision the map takes a stay that goes on to be what it looks like then. Once it has ended, more is known.
    fn follow_the_map(&mut self, pose: &Isometry2<f64>, mapper: &Mapper) {
        if mapper.poses().len() != self.visits {
            self.visits = mapper.poses().len();
            self.correction = mapper.placed(&mapper.anchored(*pose)) * pose.inverse();
        }
    }

    /// Whether the vehicle is stuck, or nothing new comes.
    fn watch(&mut self, here_m: Point2<f64>, mapper: &Mapper) -> Option<MissionEnd> {
        let (since, at_m) = self.progress;
        if (here_m - at_m).norm() > STUCK_M {
            self.progress = (self.now, here_m);
            self.stuck = 0;
        } else if self.now - since > STUCK_AFTER {
            self.progress = (self.now, here_m);
            self.stuck += 1;
            if self.stuck >= MOST_STUCK {
                return Some(MissionEnd::Stuck);
            }
            match (self.doing, self.left) {
                (Doing::Leave { .. }, Some(left)) => {
                    self.note_try(&left, false);
                    self.arrive(left.kind, here_m);
                }
                _ => {
                    self.correction = mapper.located().map_or(self.correction, |located| located.correction);
                    self.course_rad = wrap_angle_rad(self.course_rad + PI);
                    self.doing = Doing::Follow;
                }
            }
        }
        self.limit()
    }

    fn limit(&self) -> Option<MissionEnd> {
        ((self.now - self.last_new) as f64 > LIMIT + LIMIT_PER_M * (self.map_m + self.farthest_m))
            .then_some(MissionEnd::GaveUp)
    }
}
