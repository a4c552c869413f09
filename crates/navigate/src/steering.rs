//! From a goal to a command: the way over free cells, followed at a speed that the room allows.

use nalgebra::{Isometry2, Point2};

use crosscut_stage::wrap_angle_rad;

use crate::surround::Field;
use crate::{Command, Limits};

/// The vehicle heads for the place this far along its way, m.
const LOOK_AHEAD_M: f64 = 1.0;

/// It turns on the spot towards what is farther to the side.
const ON_THE_SPOT_RAD: f64 = 0.7;

/// Turn rate for each radian off.
const GAIN_PER_S: f64 = 2.2;

/// Braking is planned with this, m/s²; the vehicle can do more.
const BRAKING_M_S2: f64 = 0.7;

/// A command takes effect this much later, s.
const DELAY_S: f64 = 0.2;

/// The vehicle stops this far from what lies straight ahead, m.
const SPARE_M: f64 = 0.06;

/// With this much room beside it the vehicle flies at full speed, m.
const ROOMY_M: f64 = 0.7;

/// With the least room it still flies at this speed, m/s.
const CREEP_M_S: f64 = 0.35;

impl Limits {
    /// How fast to turn towards what lies this far to the left.
    fn turn_rate_rad_s(&self, off_rad: f64) -> f64 {
        (GAIN_PER_S * off_rad).clamp(-self.turn_rate_max_rad_s, self.turn_rate_max_rad_s)
    }
}

/// The command towards a goal. `stops`: the vehicle is to come to rest there.
pub(crate) fn towards(
    goal_m: Point2<f64>,
    stops: bool,
    field: &Field,
    pose: &Isometry2<f64>,
    limits: &Limits,
) -> Command {
    let here_m = Point2::from(pose.translation.vector);
    let nearest = field.best(|reached| Some((reached.place_m - goal_m).norm() + 0.02 * reached.cost_m));
    let way = nearest.map_or_else(Vec::new, |reached| field.way_to(reached.place_m));
    let Some(&last) = way.last() else { return Command::default() };
    let left_m = (last - here_m).norm();
    if left_m < 0.25 {
        let turn_rate_rad_s = if stops { 0.0 } else { limits.turn_rate_rad_s(off_rad(goal_m, pose)) };
        return Command { speed_m_s: 0.0, turn_rate_rad_s };
    }
    let target_m = way.iter().copied().find(|place_m| (place_m - here_m).norm() > LOOK_AHEAD_M).unwrap_or(last);
    let off_rad = off_rad(target_m, pose);
    let turn_rate_rad_s = limits.turn_rate_rad_s(off_rad);
    if off_rad.abs() > ON_THE_SPOT_RAD {
        return Command { speed_m_s: 0.0, turn_rate_rad_s };
    }
    let near = way.iter().take_while(|place_m| (*place_m - here_m).norm() < 1.6);
    let least_m = near.map(|place_m| field.clearance_at_m(*place_m)).fold(f64::INFINITY, f64::min);
    let room_m = (least_m - limits.radius_m).max(0.0);
    let by_room_m_s = CREEP_M_S + (limits.speed_max_m_s - CREEP_M_S) * (room_m / ROOMY_M).min(1.0);
    let mut speed_m_s = by_room_m_s * off_rad.cos().powi(2);
    if stops || left_m < 1.5 {
        speed_m_s = speed_m_s.min((2.0 * BRAKING_M_S2 * left_m).sqrt().max(0.2));
    }
    // What lies straight ahead counts wherever the way leads.
    let free_m = (field.free_m(pose.rotation.angle(), limits.radius_m + 0.02) - DELAY_S * speed_m_s).max(0.0);
    speed_m_s = speed_m_s.min((2.0 * BRAKING_M_S2 * free_m).sqrt());
    if free_m <= 0.0 && off_rad.abs() < 0.1 {
        // The way leads out of a place that is too near to a wall.
        speed_m_s = 0.12;
    }
    let ahead_m = (field.ahead_m(pose.rotation.angle(), limits.radius_m + SPARE_M) - DELAY_S * speed_m_s).max(0.0);
    speed_m_s = speed_m_s.min((2.0 * BRAKING_M_S2 * ahead_m).sqrt());
    Command { speed_m_s, turn_rate_rad_s }
}

/// How far to the left of straight ahead a place lies.
fn off_rad(place_m: Point2<f64>, pose: &Isometry2<f64>) -> f64 {
    let towards = place_m - Point2::from(pose.translation.vector);
    wrap_angle_rad(towards.y.atan2(towards.x) - pose.rotation.angle())
}
