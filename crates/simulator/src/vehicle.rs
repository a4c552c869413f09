//! A vehicle that follows a route through a mine, with disturbances, and odometry that drifts.

use crosscut_stage::unit;

use crate::network::{Point, Vector, left_of};
use crate::noise::{Drifting, Generator, generator, normal};
use crate::pose::{Motion, Pose};

/// Steps of the motion within one sweep.
const STEPS_PER_SWEEP: usize = 10;

/// Drift of the heading in rad per metre of way, as a part of that of the way.
const TURN_DRIFT: f64 = 0.1;

/// Motion and errors of the vehicle. Disturbances are correlated in time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Handling {
    /// Speed over ground.
    pub speed_m_s: f64,
    /// Largest turn rate.
    pub turn_rate_max_rad_s: f64,
    /// Distance to the point of the route that the vehicle heads for.
    pub look_ahead_m: f64,
    /// The vehicle stands and turns while the point that it heads for is farther to its side than this.
    pub turn_on_spot_rad: f64,
    /// Standard deviation of the offset to the side of the route.
    pub offset_sd_m: f64,
    /// Standard deviation of the heading relative to the course.
    pub yaw_sd_rad: f64,
    /// Standard deviation of roll and of pitch.
    pub tilt_sd_rad: f64,
    /// Standard deviation of the odometry's relative error in speed, drawn once per flight.
    pub odometry_scale_sd: f64,
    /// Standard deviation of the odometry's error in turn rate, drawn once per flight.
    pub odometry_turn_sd_rad_s: f64,
}

impl Default for Handling {
    /// 1.5 m/s, never on the spot, a tilt of 1.5° (standard deviation), and odometry with errors of 2 % and 0.2°/s.
    fn default() -> Self {
        Self {
            speed_m_s: 1.5,
            turn_rate_max_rad_s: 0.8,
            look_ahead_m: 2.0,
            turn_on_spot_rad: f64::INFINITY,
            offset_sd_m: 0.2,
            yaw_sd_rad: 3_f64.to_radians(),
            tilt_sd_rad: 1.5_f64.to_radians(),
            odometry_scale_sd: 0.02,
            odometry_turn_sd_rad_s: 0.2_f64.to_radians(),
        }
    }
}

/// Pose of the vehicle by its odometry, which starts at the origin, and velocity since the previous sweep.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OdometryState {
    /// Position in the odometry's frame.
    pub position_m: Vector,
    /// Heading in the odometry's frame.
    pub heading_rad: f64,
    /// Velocity in the body frame.
    pub velocity_m_s: Vector,
    /// Turn rate, anticlockwise.
    pub turn_rate_rad_s: f64,
}

/// A vehicle in motion: an iterator over sweeps that ends near the end of the route.
#[derive(Clone, Debug)]
pub struct Vehicle {
    handling: Handling,
    route_m: Vec<Point>,
    sweep_s: f64,
    /// Index of the last point of the route that was passed.
    passed: usize,
    position_m: Point,
    /// Direction of motion. The heading differs from it by the yaw disturbance.
    course_rad: f64,
    pose: Pose,
    odometry: OdometryState,
    offset: Drifting,
    yaw: Drifting,
    roll: Drifting,
    pitch: Drifting,
    scale: f64,
    turn_bias_rad_s: f64,
    turn_bias_rad_per_m: f64,
    rng: Generator,
}

impl Vehicle {
    /// A vehicle at the start of a route, facing along it. Points of the route are closer together than the look-ahead.
    pub fn new(handling: Handling, route_m: Vec<Point>, sweep_s: f64, seed: u64) -> Self {
        let mut rng = generator(seed, "vehicle");
        let position_m = route_m.first().copied().unwrap_or_else(Point::origin);
        let course_rad = route_m.get(1).map_or(0.0, |next| (next.y - position_m.y).atan2(next.x - position_m.x));
        Self {
            passed: 0,
            position_m,
            course_rad,
            pose: Pose::level(position_m, course_rad),
            odometry: OdometryState::default(),
            offset: Drifting::new(handling.offset_sd_m, 3.0),
            yaw: Drifting::new(handling.yaw_sd_rad, 1.0),
            roll: Drifting::new(handling.tilt_sd_rad, 0.5),
            pitch: Drifting::new(handling.tilt_sd_rad, 0.5),
            scale: 1.0 + handling.odometry_scale_sd * normal(&mut rng),
            turn_bias_rad_s: handling.odometry_turn_sd_rad_s * normal(&mut rng),
            turn_bias_rad_per_m: 0.0,
            handling,
            route_m,
            sweep_s,
            rng,
        }
    }

    /// Lets the odometry drift by this share of the way, in place of its relative error in speed, and its heading by
    /// [`TURN_DRIFT`] of it. The signs are drawn.
    pub(crate) fn set_drift(&mut self, share: f64, seed: u64) {
        let mut rng = generator(seed, "drift");
        let mut signed = |value: f64| value.copysign(normal(&mut rng));
        self.scale = 1.0 + signed(share);
        self.turn_bias_rad_per_m = signed(TURN_DRIFT * share);
    }

    /// One step of pure pursuit.
    fn step(&mut self, dt_s: f64) {
        let handling = self.handling;
        let target_m = self.target_m(dt_s);
        let towards = target_m - self.position_m;
        let error_rad = crosscut_stage::wrap_angle_rad(towards.y.atan2(towards.x) - self.course_rad);
        let (speed_m_s, wanted_rad_s) = if error_rad.abs() > handling.turn_on_spot_rad {
            (0.0, handling.turn_rate_max_rad_s.copysign(error_rad))
        } else {
            (handling.speed_m_s, 2.0 * handling.speed_m_s * error_rad.sin() / towards.norm().max(0.1))
        };
        let turn_rate = wanted_rad_s.clamp(-handling.turn_rate_max_rad_s, handling.turn_rate_max_rad_s);
        self.course_rad += turn_rate * dt_s;
        self.position_m += unit(self.course_rad) * (speed_m_s * dt_s);
        self.pose = Pose {
            position_m: self.position_m,
            heading_rad: self.course_rad + self.yaw.step(dt_s, &mut self.rng),
            roll_rad: self.roll.step(dt_s, &mut self.rng),
            pitch_rad: self.pitch.step(dt_s, &mut self.rng),
        };
    }

    /// The point of the route at the look-ahead distance, displaced sideways by the disturbance.
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

    /// Updates the odometry by the motion from `before` to now, during `dt_s`.
    fn update_odometry(&mut self, before: &Pose, dt_s: f64) {
        let moved = nalgebra::Rotation2::new(-before.heading_rad) * (self.pose.position_m - before.position_m);
        let turned_rad = self.pose.heading_rad - before.heading_rad;
        let odometry = &mut self.odometry;
        odometry.velocity_m_s = moved * self.scale / dt_s;
        odometry.turn_rate_rad_s =
            turned_rad / dt_s + self.turn_bias_rad_s + self.turn_bias_rad_per_m * moved.norm() / dt_s;
        odometry.position_m += nalgebra::Rotation2::new(odometry.heading_rad) * odometry.velocity_m_s * dt_s;
        odometry.heading_rad += odometry.turn_rate_rad_s * dt_s;
    }
}

impl Iterator for Vehicle {
    /// The motion during a sweep, and the odometry at its first beam.
    type Item = (Motion, OdometryState);

    fn next(&mut self) -> Option<Self::Item> {
        let end_m = *self.route_m.last()?;
        if self.passed + 1 == self.route_m.len() && (end_m - self.position_m).norm() < self.handling.look_ahead_m {
            return None;
        }
        let (start, odometry) = (self.pose, self.odometry);
        for _ in 0..STEPS_PER_SWEEP {
            self.step(self.sweep_s / STEPS_PER_SWEEP as f64);
        }
        self.update_odometry(&start, self.sweep_s);
        Some((Motion { start, end: self.pose }, odometry))
    }
}
