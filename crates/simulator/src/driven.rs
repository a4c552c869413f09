//! A vehicle that obeys commands, with limits and disturbances, and its lidar.

use crosscut_messages::Truth;
use nalgebra::{Isometry2, Vector2};

use crate::lidar::{Echo, Lidar};
use crate::mine::Mine;
use crosscut_stage::unit;

use crate::network::{Point, left_of};
use crate::noise::{Drifting, Generator, generator, normal};
use crate::pose::{Motion, Pose};
use crate::reading::Reading;
use crate::scene::{FIRST_STAMP_NS, Scene, message, odometry};
use crate::survey::seen_from;
use crate::vehicle::OdometryState;
use crate::world::World;

/// Steps of the motion within one sweep.
const STEPS_PER_SWEEP: usize = 10;

/// What a vehicle is able to do, and what disturbs it. Disturbances are correlated in time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Agility {
    /// Largest speed ahead.
    pub speed_max_m_s: f64,
    /// Largest speed astern.
    pub astern_max_m_s: f64,
    /// Largest change of speed.
    pub acceleration_m_s2: f64,
    /// Largest turn rate.
    pub turn_rate_max_rad_s: f64,
    /// Largest change of the turn rate.
    pub turn_acceleration_rad_s2: f64,
    /// The vehicle is a disc of this radius.
    pub radius_m: f64,
    /// Standard deviation of the speed to the side.
    pub sideways_sd_m_s: f64,
    /// Standard deviation of the turn rate about the commanded one.
    pub turn_sd_rad_s: f64,
    /// Standard deviation of roll and of pitch.
    pub tilt_sd_rad: f64,
    /// Standard deviation of the odometry's relative error in speed, drawn once.
    pub odometry_scale_sd: f64,
    /// Standard deviation of the odometry's error in turn rate, drawn once.
    pub odometry_turn_sd_rad_s: f64,
}

impl Default for Agility {
    /// 1.5 m/s, 1 m/s², 1 rad/s, a disc 0.6 m across, a tilt of 1.5° (standard deviation), and odometry with errors of
    /// 2 % and 0.2°/s.
    fn default() -> Self {
        Self {
            speed_max_m_s: 1.5,
            astern_max_m_s: 0.4,
            acceleration_m_s2: 1.0,
            turn_rate_max_rad_s: 1.0,
            turn_acceleration_rad_s2: 3.0,
            radius_m: 0.3,
            sideways_sd_m_s: 0.05,
            turn_sd_rad_s: 0.03,
            tilt_sd_rad: 1.5_f64.to_radians(),
            odometry_scale_sd: 0.02,
            odometry_turn_sd_rad_s: 0.2_f64.to_radians(),
        }
    }
}

/// A vehicle under command in a mine.
#[derive(Clone, Debug)]
pub struct Driven {
    mine: Mine,
    lidar: Lidar,
    agility: Agility,
    pose: Pose,
    speed_m_s: f64,
    turn_rate_rad_s: f64,
    odometry: Isometry2<f64>,
    sideways: Drifting,
    turn: Drifting,
    roll: Drifting,
    pitch: Drifting,
    scale: f64,
    turn_bias_rad_s: f64,
    stamp_ns: u64,
    is_in_contact: bool,
    last: Option<(Motion, Vec<Echo>, Vec<Reading>)>,
    /// The pose that true poses are recorded from.
    origin: Pose,
    of_motion: Generator,
    of_lidar: Generator,
}

impl Driven {
    /// A vehicle at the start of a world, at rest.
    pub fn new(world: &World, agility: Agility, seed: u64) -> Self {
        let mut rng = generator(seed, "driven");
        Self {
            mine: world.mine.clone(),
            lidar: world.lidar,
            pose: world.start,
            speed_m_s: 0.0,
            turn_rate_rad_s: 0.0,
            odometry: Isometry2::identity(),
            sideways: Drifting::new(agility.sideways_sd_m_s, 2.0),
            turn: Drifting::new(agility.turn_sd_rad_s, 1.0),
            roll: Drifting::new(agility.tilt_sd_rad, 0.5),
            pitch: Drifting::new(agility.tilt_sd_rad, 0.5),
            scale: 1.0 + agility.odometry_scale_sd * normal(&mut rng),
            turn_bias_rad_s: agility.odometry_turn_sd_rad_s * normal(&mut rng),
            stamp_ns: FIRST_STAMP_NS,
            is_in_contact: false,
            last: None,
            origin: world.start,
            agility,
            of_motion: rng,
            of_lidar: generator(seed, "lidar"),
        }
    }

    /// A vehicle at rest where the last scene of an earlier flight was taken. Its odometry and its clock continue; its
    /// disturbances are drawn from the seed again. `None` if the scene has no odometry or no true pose.
    pub fn resumed(world: &World, agility: Agility, seed: u64, last: &Scene) -> Option<Self> {
        let mut driven = Self::new(world, agility, seed);
        driven.pose = world.pose_of(&last.truth.pose?);
        driven.odometry = last.odometry_pose()?;
        driven.stamp_ns = last.stamp_ns + driven.sweep_ns();
        Some(driven)
    }

    /// Obeys a command, a speed ahead (below 0 astern) and a turn rate anticlockwise, for the time of one sweep, and senses
    /// meanwhile. The scene has no [`truth`](Self::truth) yet.
    pub fn step(&mut self, speed_m_s: f64, turn_rate_rad_s: f64) -> Scene {
        let (start, stamp_ns) = (self.pose, self.stamp_ns);
        let state = OdometryState {
            position_m: self.odometry.translation.vector,
            heading_rad: self.odometry.rotation.angle(),
            velocity_m_s: Vector2::new(self.speed_m_s, 0.0),
            turn_rate_rad_s: self.turn_rate_rad_s,
        };
        self.is_in_contact = false;
        for _ in 0..STEPS_PER_SWEEP {
            self.advance([speed_m_s, turn_rate_rad_s], self.lidar.sweep_s / STEPS_PER_SWEEP as f64);
        }
        self.stamp_ns += self.sweep_ns();
        let motion = Motion { start, end: self.pose };
        let echoes = self.lidar.view(self.mine.surface(), self.mine.network().height_m, &motion);
        let readings = self.lidar.read(self.mine.surface(), &echoes, &mut self.of_lidar);
        let scan = message(&self.lidar, &readings, stamp_ns, start != self.pose);
        self.last = Some((motion, echoes, readings));
        let map = (stamp_ns == FIRST_STAMP_NS).then(|| self.mine.network().map(&self.origin));
        Scene { odometry: Some(odometry(&state, stamp_ns)), pose: Some(start), map, ..Scene::of_scan(stamp_ns, scan) }
    }

    /// The truth of the last scan; an empty one before the first.
    pub fn truth(&self) -> Truth {
        let Some((motion, echoes, readings)) = &self.last else { return Truth::default() };
        let Pose { position_m, heading_rad, .. } = motion.start;
        Truth {
            pose: Some(seen_from(&self.origin, position_m, heading_rad)),
            here: self.mine.network().place_at(&position_m),
            contact: self.is_in_contact,
            ..self.mine.scenery(&self.lidar, motion, echoes).truth(readings)
        }
    }

    fn sweep_ns(&self) -> u64 {
        (self.lidar.sweep_s * 1e9).round() as u64
    }

    /// The true pose.
    pub fn pose(&self) -> Pose {
        self.pose
    }

    /// Whether the vehicle touched rock during the last sweep. It then stands where it last was clear.
    pub fn is_in_contact(&self) -> bool {
        self.is_in_contact
    }

    /// The true number of walls in the view of the last sweep; 0 before the first.
    pub fn walls_in_view(&self) -> u32 {
        self.last.as_ref().map_or(0, |(motion, echoes, _)| self.mine.scenery(&self.lidar, motion, echoes).walls)
    }

    fn advance(&mut self, [speed_m_s, turn_rate_rad_s]: [f64; 2], dt_s: f64) {
        let Agility { astern_max_m_s, speed_max_m_s, turn_rate_max_rad_s, radius_m, .. } = self.agility;
        let finite = |value: f64| if value.is_finite() { value } else { 0.0 };
        let wanted_m_s = finite(speed_m_s).clamp(-astern_max_m_s, speed_max_m_s);
        let wanted_rad_s = finite(turn_rate_rad_s).clamp(-turn_rate_max_rad_s, turn_rate_max_rad_s);
        let (most_m_s, most_rad_s) =
            (self.agility.acceleration_m_s2 * dt_s, self.agility.turn_acceleration_rad_s2 * dt_s);
        self.speed_m_s += (wanted_m_s - self.speed_m_s).clamp(-most_m_s, most_m_s);
        self.turn_rate_rad_s += (wanted_rad_s - self.turn_rate_rad_s).clamp(-most_rad_s, most_rad_s);
        let rng = &mut self.of_motion;
        let turn_rad = (self.turn_rate_rad_s + self.turn.step(dt_s, rng)) * dt_s;
        // A vehicle that stands is not carried to the side.
        let share = (self.speed_m_s.abs() / speed_max_m_s).min(1.0);
        let sideways_m = self.sideways.step(dt_s, rng) * share * dt_s;
        let (roll_rad, pitch_rad) = (self.roll.step(dt_s, rng), self.pitch.step(dt_s, rng));
        let heading_rad = self.pose.heading_rad + turn_rad;
        let ahead = unit(heading_rad);
        let moved = ahead * (self.speed_m_s * dt_s) + left_of(ahead) * sideways_m;
        let to_m: Point = self.pose.position_m + moved;
        let is_clear = !self.mine.surface().touches(to_m, radius_m);
        let moved = if is_clear { moved } else { moved * 0.0 };
        if !is_clear {
            (self.is_in_contact, self.speed_m_s) = (true, 0.0);
        }
        self.pose = Pose { position_m: self.pose.position_m + moved, heading_rad, roll_rad, pitch_rad };
        let in_body = nalgebra::Rotation2::new(turn_rad - heading_rad) * moved * self.scale;
        self.odometry *= Isometry2::new(in_body, turn_rad + self.turn_bias_rad_s * dt_s);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::families;

    fn driven(agility: Agility, seed: u64) -> Driven {
        let tee = families().iter().find(|family| family.name == "tee").expect("there is one");
        Driven::new(&(tee.world)(seed), agility, seed)
    }

    #[test]
    fn a_vehicle_keeps_to_its_limits() {
        let agility = Agility { sideways_sd_m_s: 0.0, turn_sd_rad_s: 0.0, ..Agility::default() };
        let mut driven = driven(agility, 1);
        let before = driven.pose();
        driven.step(100.0, f64::NAN);
        let moved_m = (driven.pose().position_m - before.position_m).norm();
        assert!(moved_m <= 0.5 * 1.0 * 0.1 * 0.1 * 1.2, "{moved_m} m in a tenth of a second at 1 m/s²");
        assert_eq!(driven.pose().heading_rad, before.heading_rad, "a command that is no number is none");
    }

    #[test]
    fn contact_with_rock_is_reported_and_stops_the_vehicle() {
        let mut driven = driven(Agility::default(), 1);
        let mut contacts = 0;
        for _ in 0..400 {
            driven.step(1.0, 0.0);
            contacts += u32::from(driven.is_in_contact());
            let clear_m = driven.mine.surface().clearance_m(driven.pose().position_m, 5.0);
            assert!(clear_m >= 0.3 - 1e-9, "{clear_m} m from the rock");
        }
        assert!(contacts > 0);
    }

    #[test]
    fn the_same_seed_gives_the_same_scans() {
        let scans = |seed| {
            let mut driven = driven(Agility::default(), seed);
            (0..5).map(|_| driven.step(1.0, 0.1).scan).collect::<Vec<_>>()
        };
        assert_eq!(scans(3), scans(3));
        assert_ne!(scans(3), scans(4));
    }
}
