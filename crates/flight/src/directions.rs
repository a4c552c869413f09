//! Whether the directions of the scans are wrong: scans and odometry show the same motions, but for one turn in all of them,
//! or mirrored.
//!
//! With the motions oₖ of the odometry and sₖ of the scans over short ways as complex numbers, and their turns, the scans are
//! turned by the θ, or mirrored and turned by the θ, that make the sum of squares least:
//!
//! ```text
//! Σ |sₖ - e^iθ oₖ|²   or   Σ |sₖ - e^iθ ōₖ|²,   θ = arg Σ ōₖ sₖ   or   arg Σ oₖ sₖ
//! ```
//!
//! An odometry that is bad in other ways, as of wheels that slip, leaves much more of the sum than a turn does.

use nalgebra::{Isometry2, Vector2};

use crosscut_stage::{Fan, as_setting_rad};

/// A way, and this many of them show it, metres.
const WAY_M: f64 = 0.5;
const LEAST_WAYS: u32 = 5;

/// A turn of a radian counts as this way, metres.
const TURN_M: f64 = 1.0;

/// A scanner that is turned by less is not told from an odometry that slips to one side, rad.
const LEAST_RAD: f64 = 0.35;

/// Ways and turns that differ by less than this share are those of one motion.
const ALIKE: f64 = 0.3;

/// A vehicle that turns where it stands makes no longer way than this, metres.
const STANDS_M: f64 = 0.05;

/// Of the sum of squares of all motions, at most this is left, and at most this share of what is left without a turn.
const MOST_LEFT: f64 = 0.03;
const FAR_BETTER: f64 = 0.1;

/// Compares the motions of both since the flight began.
#[derive(Clone, Debug, Default)]
pub(crate) struct Directions {
    /// Since the last way ended.
    way: [Isometry2<f64>; 2],
    ways: u32,
    /// Σ ōs and Σ os, m².
    turned: Vector2<f64>,
    mirrored: Vector2<f64>,
    /// Σ |o|² + |s|², m².
    all: f64,
    /// Of the turns, Σ ω_o ω_s and Σ ω_o² + ω_s², rad².
    turns: f64,
    all_turns: f64,
}

/// How scans lie to the odometry: mirrored first, then turned by this, rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Wrong {
    pub(crate) turned_rad: f64,
    pub(crate) is_mirrored: bool,
}

impl Directions {
    /// Adds the motions of both from one revolution to the next, in the frames of the earlier one.
    pub(crate) fn add(&mut self, odometry: &Isometry2<f64>, scans: &Isometry2<f64>) {
        self.way = [self.way[0] * odometry, self.way[1] * scans];
        if self.way.iter().any(|way| way.translation.vector.norm() >= WAY_M) {
            self.end_way();
        }
    }

    fn end_way(&mut self) {
        let [odometry, scans] = std::mem::take(&mut self.way);
        let [o, s] = [odometry, scans].map(|way| way.translation.vector);
        let [o_rad, s_rad] = [odometry, scans].map(|way| way.rotation.angle());
        let conjugate = Vector2::new(o.x, -o.y);
        self.ways += 1;
        self.turned += Vector2::new(o.dot(&s), o.perp(&s));
        self.mirrored += Vector2::new(conjugate.dot(&s), conjugate.perp(&s));
        self.all += o.norm_squared() + s.norm_squared();
        self.turns += o_rad * s_rad;
        self.all_turns += o_rad * o_rad + s_rad * s_rad;
    }

    /// What is wrong with the directions, once the motions show it.
    pub(crate) fn wrong(&self) -> Option<Wrong> {
        self.best().filter(|_| self.ways >= LEAST_WAYS)
    }

    /// Whether wrong directions may be what makes these motions of odometry and scans differ, each a way in metres and a turn in
    /// radians: there are too few to show it, or no turn before this one.
    pub(crate) fn may_explain(&self, odometry: [f64; 2], scans: [f64; 2]) -> bool {
        let mut so_far = self.clone();
        so_far.end_way();
        let mirrors = |of: [f64; 2], by: [f64; 2]| {
            (of[0] - by[0]).abs() <= ALIKE * of[0] + STANDS_M && (of[1] + by[1]).abs() < ALIKE * of[1].abs()
        };
        (self.ways < LEAST_WAYS && so_far.best().is_some()) || mirrors(odometry, scans)
    }

    fn best(&self) -> Option<Wrong> {
        let all = self.all + TURN_M * TURN_M * self.all_turns;
        let left = |moved: f64, turned: f64| all - 2.0 * (moved + TURN_M * TURN_M * turned);
        let [turned, mirrored] = [left(self.turned.norm(), self.turns), left(self.mirrored.norm(), -self.turns)];
        // A vehicle that does not turn moves the same way in a mirror.
        let is_mirrored = mirrored < FAR_BETTER * turned;
        let (least, by) = if is_mirrored { (mirrored, self.mirrored) } else { (turned, self.turned) };
        let is_so = least < MOST_LEFT * all && least < FAR_BETTER * left(self.turned.x, self.turns);
        let turned_rad = by.y.atan2(by.x);
        (is_so && (is_mirrored || turned_rad.abs() > LEAST_RAD)).then_some(Wrong { turned_rad, is_mirrored })
    }
}

impl Wrong {
    /// What is wrong, and the setting that mends it, for a scanner that is taken to look as `fan` says.
    pub(crate) fn described(&self, fan: &Fan) -> String {
        let Self { turned_rad, is_mirrored } = *self;
        let (yaw_rad, upside_down) = match is_mirrored {
            true => (turned_rad - fan.yaw_rad, !fan.upside_down),
            false => (fan.yaw_rad - turned_rad, fan.upside_down),
        };
        let degrees = turned_rad.to_degrees().round();
        let how = match (is_mirrored, degrees == 0.0) {
            (true, true) => "mirrored".to_owned(),
            (true, false) => format!("mirrored and turned by {degrees} degrees"),
            _ => format!("turned by {degrees} degrees"),
        };
        let setting = match upside_down {
            true => ", ingest.upside_down = true",
            false if fan.upside_down => ", ingest.upside_down = false",
            false => "",
        };
        format!(
            "pose: scans and odometry show the same motions, the scans {how}: a direction is wrong, no motion; \
             ingest.yaw_rad = {:.3}{setting} turns the scans",
            as_setting_rad(yaw_rad)
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is found of 40 motions of 0.2 m that turn by `turn_rad`, where odometry and scans show these of them.
    fn wrong(turn_rad: f64, odometry: impl Fn(u32, &Isometry2<f64>) -> Isometry2<f64>) -> Option<Wrong> {
        let mut directions = Directions::default();
        for at in 0..40 {
            let scans = Isometry2::new(Vector2::new(0.2, 0.0), if at % 3 == 0 { turn_rad } else { -0.2 * turn_rad });
            directions.add(&odometry(at, &scans), &scans);
        }
        directions.wrong()
    }

    #[test]
    fn a_turn_and_a_mirror_are_told_from_bad_odometry() {
        let turned =
            |by: f64| move |_: u32, of: &Isometry2<f64>| Isometry2::rotation(by) * of * Isometry2::rotation(-by);
        let found = wrong(0.1, turned(0.8)).expect("a turn");
        assert!((found.turned_rad + 0.8).abs() < 0.01 && !found.is_mirrored, "{found:?}");
        let mirror = |_: u32, of: &Isometry2<f64>| {
            Isometry2::new(Vector2::new(of.translation.x, -of.translation.y), -of.rotation.angle())
        };
        let found = wrong(0.1, mirror).expect("a mirror");
        assert!(found.turned_rad.abs() < 0.01 && found.is_mirrored, "{found:?}");
        let longer =
            |_: u32, of: &Isometry2<f64>| Isometry2::new(of.translation.vector * 1.25, of.rotation.angle() * 0.7);
        let stands = |_: u32, _: &Isometry2<f64>| Isometry2::identity();
        let sideways = turned(0.3);
        let slips = |at: u32, of: &Isometry2<f64>| if at % 10 < 3 { Isometry2::translation(0.0, 0.3) } else { *of };
        assert_eq!([wrong(0.1, longer), wrong(0.1, stands), wrong(0.1, slips), wrong(0.1, sideways)], [None; 4]);
    }
}
