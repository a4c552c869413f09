//! A vehicle that follows a route through a mine, disturbed on its way, and odometry that drifts.

use crate::network::{Point, Vector, left_of, unit};
use crate::noise::{Drifting, Generator, generator, normal};
use crate::pose::{Motion, Pose};

/// Steps of the motion within one sweep.
const STEPS_PER_SWEEP: usize = 10;

/// How the vehicle flies, and how it errs. Disturbances wander with the given standard deviation and time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Handling {
    /// Speed over ground.
    pub speed_m_s: f64,
    /// Fastest turn.
    pub turn_rate_max_rad_s: f64,
    /// It heads for the point of the route this far ahead.
    pub look_ahead_m: f64,
    /// Standard deviation of the offset to the side of the route.
    pub offset_sd_m: f64,
    /// Standard deviation of the heading beside the way flown.
    pub yaw_sd_rad: f64,
    /// Standard deviation of roll and of pitch.
    pub tilt_sd_rad: f64,
    /// Standard deviation of the odometry's error in speed, as a share of it: one draw per flight.
    pub odometry_scale_sd: f64,
    /// Standard deviation of the odometry's error in turn rate: one draw per flight.
    pub odometry_turn_sd_rad_s: f64,
}

impl Default for Handling {
    /// 1.5 m/s, tilted by 1.5° (one standard deviation), odometry off by 2 % and 0.2° a second.
    fn default() -> Self {
        Self {
            speed_m_s: 1.5,
            turn_rate_max_rad_s: 0.8,
            look_ahead_m: 2.0,
            offset_sd_m: 0.2,
            yaw_sd_rad: 3_f64.to_radians(),
            tilt_sd_rad: 1.5_f64.to_radians(),
            odometry_scale_sd: 0.02,
            odometry_turn_sd_rad_s: 0.2_f64.to_radians(),
        }
    }
}

/// Where the odometry believes the vehicle to be, starting at the origin, and how fast it moved since the
/// sweep before.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Belief {
    /// Place in the odometry's own frame.
    pub position_m: Vector,
    /// Heading in the odometry's own frame.
    pub heading_rad: f64,
    /// Velocity in the body frame.
    pub velocity_m_s: Vector,
    /// Turn rate, anticlockwise.
    pub turn_rate_rad_s: f64,
}

/// A vehicle on its way: an iterator over sweeps, until the end of the route is near.
#[derive(Clone, Debug)]
pub struct Vehicle {
    handling: Handling,
    route_m: Vec<Point>,
    sweep_s: f64,
    /// Index of the last point of the route that was passed.
    passed: usize,
    /// Where it is and which way it flies; its nose strays from that by the yaw disturbance.
    position_m: Point,
    course_rad: f64,
    pose: Pose,
    belief: Belief,
    offset: Drifting,
    yaw: Drifting,
    roll: Drifting,
    pitch: Drifting,
    scale: f64,
    turn_bias_rad_s: f64,
    rng: Generator,
}

impl Vehicle {
    /// At the start of a route, facing along it. Points of the route should be closer together than the look-ahead.
    pub fn new(handling: Handling, route_m: Vec<Point>, sweep_s: f64, seed: u64) -> Self {
        let mut rng = generator(seed, "vehicle");
        let position_m = route_m.first().copied().unwrap_or_else(Point::origin);
        let course_rad = route_m.get(1).map_or(0.0, |next| (next.y - position_m.y).atan2(next.x - position_m.x));
        Self {
            passed: 0,
            position_m,
            course_rad,
            pose: Pose::level(position_m, course_rad),
            belief: Belief::default(),
            offset: Drifting::new(handling.offset_sd_m, 3.0),
            yaw: Drifting::new(handling.yaw_sd_rad, 1.0),
            roll: Drifting::new(handling.tilt_sd_rad, 0.5),
            pitch: Drifting::new(handling.tilt_sd_rad, 0.5),
            scale: 1.0 + handling.odometry_scale_sd * normal(&mut rng),
            turn_bias_rad_s: handling.odometry_turn_sd_rad_s * normal(&mut rng),
            handling,
            route_m,
            sweep_s,
            rng,
        }
    }

    /// One step of pure pursuit.
    fn step(&mut self, dt_s: f64) {
        let handling = self.handling;
        let target_m = self.target_m(dt_s);
        let towards = target_m - self.position_m;
        let error_rad = crosscut_stage::wrap_angle_rad(towards.y.atan2(towards.x) - self.course_rad);
        let wanted_rad_s = 2.0 * handling.speed_m_s * error_rad.sin() / towards.norm().max(0.1);
        let turn_rate = wanted_rad_s.clamp(-handling.turn_rate_max_rad_s, handling.turn_rate_max_rad_s);
        self.course_rad += turn_rate * dt_s;
        self.position_m += unit(self.course_rad) * (handling.speed_m_s * dt_s);
        self.pose = Pose {
            position_m: self.position_m,
            heading_rad: self.course_rad + self.yaw.step(dt_s, &mut self.rng),
            roll_rad: self.roll.step(dt_s, &mut self.rng),
            pitch_rad: self.pitch.step(dt_s, &mut self.rng),
        };
    }

    /// The point of the route that lies the look-ahead in front, displaced to the side by the disturbance.
    fn target_m(&mut self, dt_s: f64) -> Point {
        while self.passed + 1 < self.route_m.len()
            && (self.route_m[self.passed] - self.position_m).norm() < self.handling.look_ahead_m
        {
            self.passed += 1;
        }
        let ahead = self.route_m[self.passed] - self.position_m;
        let offset_m = self.offset.step(dt_s, &mut self.rng);
        self.position_m + ahead + left_of(ahead.try_normalize(1e-9).unwrap_or_default()) * offset_m
    }

    /// What the odometry makes of the `dt_s` from `before` to now.
    fn believe(&mut self, before: &Pose, dt_s: f64) {
        let moved = nalgebra::Rotation2::new(-before.heading_rad) * (self.pose.position_m - before.position_m);
        let turned_rad = self.pose.heading_rad - before.heading_rad;
        let belief = &mut self.belief;
        belief.velocity_m_s = moved * self.scale / dt_s;
        belief.turn_rate_rad_s = turned_rad / dt_s + self.turn_bias_rad_s;
        belief.position_m += nalgebra::Rotation2::new(belief.heading_rad) * belief.velocity_m_s * dt_s;
        belief.heading_rad += belief.turn_rate_rad_s * dt_s;
    }
}

impl Iterator for Vehicle {
    /// The motion during a sweep, and the odometry at its first beam.
    type Item = (Motion, Belief);

    fn next(&mut self) -> Option<Self::Item> {
        let end_m = *self.route_m.last()?;
        if self.passed + 1 == self.route_m.len() && (end_m - self.position_m).norm() < self.handling.look_ahead_m {
            return None;
        }
        let (start, belief) = (self.pose, self.belief);
        for _ in 0..STEPS_PER_SWEEP {
            self.step(self.sweep_s / STEPS_PER_SWEEP as f64);
        }
        self.believe(&start, self.sweep_s);
        Some((Motion { start, end: self.pose }, belief))
    }
}
