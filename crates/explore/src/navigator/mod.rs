//! The navigator: follows passages, stops at places, asks the planner, leaves by the way that it chose.

mod answer;
mod deciding;
mod homing;

use std::f64::consts::PI;

use nalgebra::{Isometry2, Point2};

use crosscut_flight::Mapper;
use crosscut_simulator::Command;
use crosscut_stage::{Frame, Here, HereKind, Way, unit, wrap_angle_rad};

use crate::chart::{Chart, LinkEnd};
use crate::planner::Planner;
use crate::steering::{Limits, towards};
use crate::surround::{Field, Surround};

pub use answer::{Decision, End, Step};

/// The revolutions that a place is looked at before a decision, at least, and at most before one without the map.
const LEAST_LOOKS: u64 = 6;
const MOST_LOOKS: u64 = 40;

/// Revolutions to reach the middle of a junction, and the face of a dead end.
const MOST_TO_MIDDLE: u64 = 90;
const MOST_TO_FACE: u64 = 150;

/// A place that was seen ceases to be one after this many revolutions without it.
const MOST_AWAY: u64 = 12;

/// The vehicle turns back where it is free for less than this ahead, m.
const BEFORE_FACE_M: f64 = 1.3;

/// The vehicle has left a place once it is this much farther away than its look, m.
const BEYOND_LOOK_M: f64 = 0.7;

/// An attempt to leave may take this many revolutions.
const MOST_TO_LEAVE: u64 = 250;

/// Without a way ahead for this many revolutions, the vehicle turns back.
const MOST_WITHOUT_WAY: u64 = 30;

/// Progress is less than a metre in this many revolutions: the vehicle is stuck.
const STUCK_AFTER: u64 = 200;
const STUCK_M: f64 = 1.0;

/// The mission is given up after this many times in a row.
const MOST_STUCK: u32 = 6;

/// A mission that finds nothing new is given up after this many revolutions, and these for each metre of the map.
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
    /// Its position on the map, and the way that it was left by.
    place: Option<(Point2<f64>, LinkEnd)>,
    /// The direction in which it was really left, in the frame of the map.
    really_rad: Option<f64>,
    way_m: f64,
}

/// Flies a vehicle by what the frames of its flight show.
pub struct Navigator {
    planner: Box<dyn Planner>,
    limits: Limits,
    surround: Surround,
    chart: Chart,
    doing: Doing,
    /// The direction that the vehicle is to fly in, in the axes of the tracked poses.
    course_rad: f64,
    goal_m: Point2<f64>,
    /// Brings tracked poses into the frame of the map.
    correction: Isometry2<f64>,
    left: Option<Left>,
    /// A passage was seen since the last place.
    is_armed: bool,
    goes_home: bool,
    /// The kind of the place at the start.
    home_kind: Option<HereKind>,
    /// Revolutions near home on the way there.
    near_home: u64,
    /// The first place, and the direction in which it was reached, turned back; in the frame of the map.
    first: Option<(Point2<f64>, f64)>,
    now: u64,
    way_m: f64,
    last_m: Option<Point2<f64>>,
    without_way: u64,
    progress: (u64, Point2<f64>),
    stuck: u32,
    last_new: u64,
    map_m: f64,
}

impl Navigator {
    /// For a vehicle with these limits.
    pub fn new(planner: Box<dyn Planner>, limits: Limits) -> Self {
        Self {
            planner,
            limits,
            surround: Surround::new(limits.radius_m),
            chart: Chart::default(),
            doing: Doing::Follow,
            course_rad: 0.0,
            goal_m: Point2::origin(),
            correction: Isometry2::identity(),
            left: None,
            is_armed: true,
            goes_home: false,
            home_kind: None,
            near_home: 0,
            first: None,
            now: 0,
            way_m: 0.0,
            last_m: None,
            without_way: 0,
            progress: (0, Point2::origin()),
            stuck: 0,
            last_new: 0,
            map_m: 0.0,
        }
    }

    /// The command after the next frame, which the flight has filled and the mapper has taken.
    pub fn step(&mut self, frame: &Frame, mapper: &Mapper) -> Step {
        self.now += 1;
        let Some(pose) = frame.pose else {
            return self.rests("waits", self.limit());
        };
        let here_m = Point2::from(pose.translation.vector);
        self.surround.add(&frame.revolution, &pose);
        let field = self.surround.field(here_m);
        self.move_to(here_m);
        let steady = frame.steady.as_ref().and_then(|steady| steady.here.as_ref());
        if self.is_home(here_m, steady) {
            return self.rests("is home", Some(End::Home));
        }
        if let Some(home_m) = self.home_in_reach(here_m, &field) {
            self.goal_m = home_m;
            let (end, command) = (self.watch(here_m, mapper), towards(home_m, true, &field, &pose, &self.limits));
            return Step { command, end, ..self.rests("goes home", None) };
        }
        let (mut decision, mut stops) = (None, false);
        match self.doing {
            Doing::Follow => self.follow(frame.here.as_ref(), steady, &pose, &field),
            Doing::Leave { began } => self.leave(frame.here.as_ref(), steady, &pose, began),
            Doing::Arrive { kind, began, from_m, last_seen } => {
                stops = true;
                let is_seen = steady.is_some_and(|here| here.kind == kind);
                let last_seen = if is_seen { self.now } else { last_seen };
                self.doing = Doing::Arrive { kind, began, from_m, last_seen };
                if self.now - last_seen > MOST_AWAY {
                    self.doing = Doing::Follow;
                } else if self.has_arrived(kind, began, from_m, steady, &pose, &field) {
                    let is_in_node = mapper.is_in_node();
                    if is_in_node
                        || self.now - began > MOST_LOOKS + MOST_TO_MIDDLE
                        || kind != HereKind::Junction && self.now - began > MOST_LOOKS
                    {
                        let located = is_in_node.then(|| mapper.located()).flatten();
                        decision = Some(self.decide(located, kind, frame, &pose));
                    }
                }
            }
        }
        let end = self.watch(here_m, mapper);
        let command = towards(self.goal_m, stops, &field, &pose, &self.limits);
        Step { command, goal_m: self.goal_m, correction: self.correction, doing: self.doing.name(), decision, end }
    }

    fn rests(&self, doing: &'static str, end: Option<End>) -> Step {
        let (command, goal_m, correction) = (Command::default(), self.goal_m, self.correction);
        Step { command, goal_m, correction, doing, decision: None, end }
    }

    fn move_to(&mut self, here_m: Point2<f64>) {
        let moved_m = self.last_m.map_or(f64::INFINITY, |last_m| (here_m - last_m).norm());
        if moved_m > 0.2 {
            self.way_m += if moved_m.is_finite() { moved_m } else { 0.0 };
            self.last_m = Some(here_m);
        }
        self.chart.passes(self.correction * here_m);
    }

    /// Along a passage, until a place is reached.
    fn follow(&mut self, seen: Option<&Here>, steady: Option<&Here>, pose: &Isometry2<f64>, field: &Field) {
        let here_m = Point2::from(pose.translation.vector);
        let from_left_m = self.left.map_or(f64::INFINITY, |left| (left.at_m - here_m).norm());
        if let Some(here) = steady {
            let has_left = self.left.is_none_or(|left| from_left_m > left.look_m + BEYOND_LOOK_M);
            let node = here.node();
            self.is_armed |= has_left && node.is_none();
            let is_other = match node {
                Some(HereKind::Junction) => {
                    self.is_armed
                        || self.left.is_some_and(|left| match left.kind {
                            HereKind::DeadEnd => from_left_m > left.look_m,
                            _ => from_left_m > 2.0 * left.look_m + 2.0,
                        })
                }
                Some(_) => {
                    self.is_armed
                        || self
                            .left
                            .is_some_and(|left| left.kind == HereKind::Junction && from_left_m > 0.7 * left.look_m)
                }
                None => false,
            };
            if let Some(kind) = node.filter(|_| is_other) {
                self.arrive(kind, here_m);
                return;
            }
        }
        let way = seen.and_then(|here| self.way_ahead(here, pose).map(|way| (here.look_m, way)));
        match way {
            Some((look_m, way)) => {
                self.without_way = 0;
                self.course_rad = wrap_angle_rad(way.bearing_rad + pose.rotation.angle());
                self.goal_m = here_m + unit(self.course_rad) * look_m.clamp(2.0, 6.0);
            }
            None => {
                self.without_way += 1;
                let (far_m, course_rad) = freest(field, self.course_rad, self.limits.radius_m);
                self.goal_m = here_m + unit(course_rad) * (far_m - 0.5).clamp(0.3, 3.0);
                if self.without_way > MOST_WITHOUT_WAY && far_m < BEFORE_FACE_M
                    || self.without_way > 10 * MOST_WITHOUT_WAY
                {
                    self.arrive(HereKind::DeadEnd, here_m);
                }
            }
        }
    }

    fn arrive(&mut self, kind: HereKind, from_m: Point2<f64>) {
        self.without_way = 0;
        self.doing = Doing::Arrive { kind, began: self.now, from_m, last_seen: self.now };
    }

    /// The way of a place that goes on in the present course, not back.
    fn way_ahead(&self, here: &Here, pose: &Isometry2<f64>) -> Option<Way> {
        let yaw_rad = pose.rotation.angle();
        let here_m = Point2::from(pose.translation.vector);
        let back = self.back_rad(here_m, here.look_m.clamp(2.0, 5.0));
        let off = |way: &Way, from_rad: f64| wrap_angle_rad(way.bearing_rad + yaw_rad - from_rad).abs();
        let backward = back.and_then(|back_rad| {
            let nearest = (0..here.ways.len())
                .min_by(|&a, &b| off(&here.ways[a], back_rad).total_cmp(&off(&here.ways[b], back_rad)))?;
            (off(&here.ways[nearest], back_rad) < 0.9).then_some(nearest)
        });
        // A bend of a passage may be sharp; of several ways the one straight ahead is followed.
        let most_rad = if here.ways.len() <= 2 { 2.0 } else { 1.1 };
        let ahead = here.ways.iter().enumerate().filter(|(number, _)| Some(*number) != backward);
        let ahead = ahead.map(|(_, way)| *way).filter(|way| off(way, self.course_rad) < most_rad);
        ahead.min_by(|a, b| off(a, self.course_rad).total_cmp(&off(b, self.course_rad)))
    }

    /// The direction of where the vehicle was this far back.
    fn back_rad(&self, here_m: Point2<f64>, far_m: f64) -> Option<f64> {
        let back_m = self.chart.back_m(self.correction * here_m, far_m)?;
        let towards = self.correction.inverse() * back_m - here_m;
        Some(towards.y.atan2(towards.x))
    }

    /// Sets the goal within a place, and says whether the vehicle has reached it.
    fn has_arrived(
        &mut self,
        kind: HereKind,
        began: u64,
        from_m: Point2<f64>,
        steady: Option<&Here>,
        pose: &Isometry2<f64>,
        field: &Field,
    ) -> bool {
        let here_m = Point2::from(pose.translation.vector);
        let (course, looks) = (unit(self.course_rad), self.now - began);
        let look_m = steady.map_or(3.0, |here| here.look_m);
        if kind == HereKind::DeadEnd {
            let leads_ahead = steady.is_some_and(|here| {
                let is_ahead =
                    |way: &Way| wrap_angle_rad(way.bearing_rad + pose.rotation.angle() - self.course_rad).abs() < 1.0;
                here.kind == kind && here.ways.iter().any(is_ahead)
            });
            let (far_m, towards_rad) = freest(field, self.course_rad, self.limits.radius_m);
            let is_near = far_m < BEFORE_FACE_M;
            self.goal_m =
                if leads_ahead || is_near { here_m } else { here_m + unit(towards_rad) * (far_m - 0.8).min(2.0) };
            return looks >= LEAST_LOOKS && (leads_ahead || is_near || looks > MOST_TO_FACE);
        }
        let middle = field.best(|reached| {
            let from = reached.place_m - from_m;
            let is_within = reached.cost_m < 2.0 * look_m && from.norm() < 1.3 * look_m && from.dot(&course) > -0.3;
            is_within.then_some(0.1 * reached.cost_m - reached.clearance_m.min(look_m))
        });
        self.goal_m = middle.map_or(here_m, |middle| middle.place_m);
        let is_near = (self.goal_m - here_m).norm() < 0.5;
        looks >= LEAST_LOOKS && (is_near || looks > MOST_TO_MIDDLE)
    }

    /// Out of a place by the chosen way.
    fn leave(&mut self, seen: Option<&Here>, steady: Option<&Here>, pose: &Isometry2<f64>, began: u64) {
        let Some(left) = self.left else {
            self.doing = Doing::Follow;
            return;
        };
        let here_m = Point2::from(pose.translation.vector);
        let from = here_m - left.at_m;
        let has_left = from.norm() > left.look_m + BEYOND_LOOK_M;
        let is_short = steady.is_some_and(|here| here.node() == Some(HereKind::DeadEnd))
            && left.kind == HereKind::Junction
            && from.norm() > 0.7 * left.look_m;
        let has_failed = self.now - began > MOST_TO_LEAVE;
        if has_left || is_short || has_failed {
            let really_rad = from.y.atan2(from.x);
            let led_into = !has_failed && wrap_angle_rad(really_rad - left.bearing_rad).abs() < 0.8;
            let turn_rad = self.correction.rotation.angle();
            self.note_try(&left, led_into);
            if let Some(left) = &mut self.left {
                left.really_rad = Some(wrap_angle_rad(really_rad + turn_rad));
            }
            self.doing = Doing::Follow;
            if has_failed {
                self.arrive(left.kind, here_m);
            }
            return;
        }
        let far_m = left.at_m + unit(left.bearing_rad) * (left.look_m + 4.0);
        let towards = far_m - here_m;
        let course_rad = towards.y.atan2(towards.x);
        let yaw_rad = pose.rotation.angle();
        let off = |way: &Way| wrap_angle_rad(way.bearing_rad + yaw_rad - course_rad).abs();
        let way = seen.and_then(|here| {
            let nearest = here.ways.iter().min_by(|a, b| off(a).total_cmp(&off(b)));
            nearest.filter(|way| off(way) < 0.7).map(|way| (here.look_m, way.bearing_rad + yaw_rad))
        });
        self.course_rad = course_rad;
        let (look_m, bearing_rad) = way.unwrap_or((3.0, course_rad));
        self.goal_m = here_m + unit(bearing_rad) * look_m.clamp(1.5, 5.0);
    }

    /// Whether the vehicle is stuck, or nothing new comes.
    fn watch(&mut self, here_m: Point2<f64>, mapper: &Mapper) -> Option<End> {
        let (since, at_m) = self.progress;
        if (here_m - at_m).norm() > STUCK_M {
            self.progress = (self.now, here_m);
            self.stuck = 0;
        } else if self.now - since > STUCK_AFTER {
            self.progress = (self.now, here_m);
            self.stuck += 1;
            if self.stuck >= MOST_STUCK {
                return Some(End::Stuck);
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

    fn limit(&self) -> Option<End> {
        ((self.now - self.last_new) as f64 > LIMIT + LIMIT_PER_M * self.map_m).then_some(End::GaveUp)
    }
}

/// How far it is free in about the course, and in which direction it is free the farthest.
fn freest(field: &Field, course_rad: f64, radius_m: f64) -> (f64, f64) {
    let offs_rad = (0..=6).flat_map(|step| [0.15 * f64::from(step), -0.15 * f64::from(step)]);
    let mut best = (f64::NEG_INFINITY, 0.0, course_rad);
    for off_rad in offs_rad {
        let free_m = field.free_m(course_rad + off_rad, radius_m);
        let score = free_m * (1.0 - 0.3 * f64::abs(off_rad));
        if score > best.0 + 1e-9 {
            best = (score, free_m, course_rad + off_rad);
        }
    }
    (best.1, best.2)
}
