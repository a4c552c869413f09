//! One full sweep of the lidar: its returns, and the beams that they came from.

use std::f64::consts::{PI, TAU};
use std::iter::repeat_n;

use nalgebra::{Isometry2, UnitQuaternion, Vector2};

use crate::Point;

/// One revolution: n returns in the body frame (x forward, y left), in message beam order.
#[derive(Clone, Debug, Default)]
pub struct Revolution {
    /// Index of the scan message in its topic, counted over all messages.
    pub seq: u64,
    /// The sensor's stamp, nanoseconds since the epoch.
    pub stamp_ns: u64,
    /// The sensor's frame, as the message names it.
    pub frame_id: String,
    /// The n returns, metres.
    pub points_m: Vec<Point>,
    /// The beams behind the returns; points that a program of one's own gives may have none.
    pub sweep: Option<Sweep>,
    /// Of a message whose entries are not the beams of `sweep` (a cloud, of which a level vehicle sees a sweep): for each
    /// entry, in message order, the return whose wall is its label, or [`Frame::NO_RETURN`](crate::Frame::NO_RETURN) or
    /// [`Frame::NO_WALL`](crate::Frame::NO_WALL). Empty where each beam is an entry.
    pub entries: Vec<i32>,
    /// Of a message that is a cloud, all its points, metres, where the affinity takes them; the returns are those that a level
    /// vehicle sees.
    pub cloud_m: Vec<Point>,
    /// What turned `cloud_m` level, from a frame in which the axis of its lidar is upright.
    pub cloud_tilt: UnitQuaternion<f64>,
    /// The vehicle's pose at the stamp by its odometry, in the odometry's frame, metres and radians; `None` if not known.
    pub odometry: Option<Isometry2<f64>>,
}

/// The beams of a 2D sweep, in message order. Where a message continues beyond a full turn, `beams` leaves those beams
/// out.
#[derive(Clone, Debug, Default)]
pub struct Sweep {
    /// Ranges exactly as on the wire, metres.
    pub ranges_m: Vec<f32>,
    /// Bearing of each beam in the body frame, in (-π, π], sensor mounting applied.
    pub bearings_rad: Vec<f64>,
    /// What each beam of the turn saw.
    pub beams: Vec<Beam>,
    /// Angle from one beam to the next, positive (the direction is in `bearings_rad`).
    pub step_rad: f64,
    /// A beam without a return saw free space up to here; infinite if the sensor states no limit.
    pub range_max_m: f64,
    /// The beams cover the full turn, or all of it but a narrow sector.
    pub full_turn: bool,
    /// Number of beams that this sector would take, between the last one and the first. Nothing is known there.
    pub missing: usize,
    /// The message's own `angle_min`, `angle_increment`, `range_min`, `range_max`, untouched.
    pub wire_geometry: [f32; 4],
    /// Where its beams look, if they are those of one scanner, whose returns lie where ranges and angles put them.
    pub fan: Option<Fan>,
}

/// Where the beams of one scanner look: beam i at yaw ± (first + i·increment), minus if the scanner hangs upside down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fan {
    /// Direction of the scanner's zero angle in the body frame, anticlockwise.
    pub yaw_rad: f64,
    /// The scanner hangs upside down.
    pub upside_down: bool,
    /// Angle of the first beam in the scanner's frame.
    pub first_rad: f64,
    /// From a beam to the next; negative where the scanner turns clockwise.
    pub increment_rad: f64,
}

impl Fan {
    /// Angle of a beam in the body frame, not wrapped. Turning a scanner over mirrors its angles; then the yaw is added.
    pub fn angle_rad(&self, beam: usize) -> f64 {
        let own_rad = self.first_rad + beam as f64 * self.increment_rad;
        self.yaw_rad + if self.upside_down { -own_rad } else { own_rad }
    }

    /// Where a return of this range lies in the body frame: (r cos θ, r sin θ, 0).
    pub fn point_m(&self, beam: usize, range_m: f32) -> Point {
        let ((sin, cos), range_m) = (self.angle_rad(beam).sin_cos(), f64::from(range_m));
        Point::new(range_m * cos, range_m * sin, 0.0)
    }
}

/// What one beam saw.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Beam {
    /// A return; the index of its point in [`Revolution::points_m`].
    Return(u32),
    /// Nothing within the sensor's range.
    NoReturn,
    /// Masked, too near or unreadable: nothing is known in this direction.
    Unknown,
}

/// The beams that the vehicle does not block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct View {
    /// The first of them, in message order.
    pub first: usize,
    /// Their number. After the last beam of the message come those that are missing in the turn, then beam 0.
    pub len: usize,
    /// The beams cover the full turn.
    pub full_turn: bool,
    /// The message lists the beams clockwise.
    pub clockwise: bool,
}

/// A sector of a full turn in which nothing is known leaves a limited view if it is wider than this: part of the vehicle
/// stands in front of the sensor. Behind a narrower one the report may connect a wall.
const BLIND_RAD: f64 = 30.0 * PI / 180.0;

impl Revolution {
    /// The beams; `None` for returns without beams.
    pub fn beams(&self) -> Option<&Sweep> {
        self.sweep.as_ref().filter(|sweep| !sweep.is_empty() || self.is_empty())
    }

    /// Number of returns, n.
    pub fn len(&self) -> usize {
        self.points_m.len()
    }

    /// Whether there is no return at all.
    pub fn is_empty(&self) -> bool {
        self.points_m.is_empty()
    }

    /// What is wrong with a revolution that was not made from a message, such as one of a file that somebody altered, in words:
    /// numbers that are none, beams and returns that do not go with each other, more beams than a turn has.
    pub fn fault(&self) -> Option<String> {
        const LEAST_STEP_RAD: f64 = 1e-7;
        let n = self.len();
        if let Some(at) = self.points_m.iter().position(|point| !point.coords.iter().all(|x| x.is_finite())) {
            return Some(format!("return {at} lies nowhere"));
        }
        if let Some(entry) = self.entries.iter().find(|&&entry| entry >= n as i32) {
            return Some(format!("an entry is of return {entry} of {n}"));
        }
        let sweep = self.sweep.as_ref().filter(|sweep| !sweep.is_empty() || sweep.missing > 0)?;
        let (beams, ranges, bearings) = (sweep.beams.len(), sweep.ranges_m.len(), sweep.bearings_rad.len());
        let is_of_no_return = |beam: &Beam| matches!(beam, Beam::Return(at) if *at as usize >= n);
        let turn_rad = LEAST_STEP_RAD..=TAU;
        if beams > ranges || beams > bearings {
            Some(format!("{beams} beams with {ranges} ranges and {bearings} bearings"))
        } else if sweep.beams.iter().any(is_of_no_return) {
            Some(format!("more beams with a return than the {n} returns"))
        } else if !turn_rad.contains(&sweep.step_rad) || sweep.bearings_rad.iter().any(|rad| !rad.is_finite()) {
            Some(format!("beams that are {} rad apart", sweep.step_rad))
        } else if sweep.missing as f64 * sweep.step_rad > TAU {
            Some(format!("{} missing beams, {} rad apart", sweep.missing, sweep.step_rad))
        } else {
            None
        }
    }

    /// Makes this an empty revolution, keeping its buffers.
    pub fn clear(&mut self) {
        self.seq = 0;
        self.stamp_ns = 0;
        self.frame_id.clear();
        self.points_m.clear();
        self.entries.clear();
        self.cloud_m.clear();
        self.cloud_tilt = UnitQuaternion::default();
        self.odometry = None;
        if let Some(sweep) = &mut self.sweep {
            sweep.clear();
        }
    }

    /// Bearing of return `i`, in (-π, π].
    pub fn bearing_rad(&self, i: usize) -> f64 {
        let p = self.points_m[i];
        p.y.atan2(p.x)
    }

    /// Horizontal distance of return `i` from the sensor, metres.
    pub fn range_m(&self, i: usize) -> f64 {
        let p = self.points_m[i];
        p.x.hypot(p.y)
    }
}

impl Sweep {
    /// Number of beams, up to a full turn.
    pub fn len(&self) -> usize {
        self.beams.len()
    }

    /// Whether there are no beams.
    pub fn is_empty(&self) -> bool {
        self.beams.is_empty()
    }

    /// The beams that the vehicle does not block. A full turn with a blind sector is a limited view that begins after the widest one.
    pub fn view(&self) -> View {
        let clockwise = self.is_clockwise();
        let turn = self.len() + self.missing;
        let whole = View { first: 0, len: turn, full_turn: self.full_turn, clockwise };
        if !self.full_turn || !self.beams.contains(&Beam::Unknown) {
            return whole;
        }
        let is_unknown = |beam: usize| self.beams.get(beam).is_none_or(|seen| *seen == Beam::Unknown);
        let (begin, blind) = widest_run(turn, is_unknown);
        // A sweep that is blind all around has no end to begin after.
        if blind < turn && blind as f64 * self.step_rad > BLIND_RAD {
            View { first: (begin + blind) % turn, len: turn - blind, full_turn: false, clockwise }
        } else {
            whole
        }
    }

    /// What the beams of a view saw, in the order in which an anticlockwise look around the sensor meets them.
    pub fn anticlockwise(&self, view: View) -> impl Iterator<Item = Beam> {
        let (end, all) = (view.first + view.len, self.len());
        let missing = end.saturating_sub(all).min(self.missing);
        let (ahead, around) = (&self.beams[view.first..end.min(all)], &self.beams[..end.saturating_sub(all + missing)]);
        let of = |holds: bool| {
            let part = |beams| if holds { beams } else { &[][..] };
            let gap = repeat_n(&Beam::Unknown, if holds { missing } else { 0 });
            part(ahead).iter().chain(gap).chain(part(around))
        };
        of(!view.clockwise).chain(of(view.clockwise).rev()).copied()
    }

    /// Whether the message lists its beams clockwise in the body frame (a negative increment, or upside down).
    fn is_clockwise(&self) -> bool {
        let mut steps_rad = self.bearings_rad.windows(2).map(|pair| wrap_angle_rad(pair[1] - pair[0]));
        steps_rad.find(|step_rad| *step_rad != 0.0).is_some_and(|step_rad| step_rad < 0.0)
    }

    /// Removes all beams, keeping the buffers.
    pub fn clear(&mut self) {
        self.ranges_m.clear();
        self.bearings_rad.clear();
        self.beams.clear();
        self.step_rad = 0.0;
        self.range_max_m = 0.0;
        self.full_turn = false;
        self.missing = 0;
        self.wire_geometry = [0.0; 4];
        self.fan = None;
    }
}

/// The longest run of beams of a full turn for which `holds` is true, the first of equally long ones: its first beam and
/// its length. It may cross from the last beam to beam 0.
pub fn widest_run(beams: usize, holds: impl Fn(usize) -> bool) -> (usize, usize) {
    let Some(start) = (0..beams).find(|&beam| !holds(beam)) else { return (0, beams) };
    let (mut widest, mut run) = ((0, 0), 0);
    for beam in start..=start + beams {
        if holds(if beam < beams { beam } else { beam - beams }) {
            run += 1;
        } else {
            if run > widest.1 {
                widest = (beam - run, run);
            }
            run = 0;
        }
    }
    widest
}

/// Wraps an angle to (-π, π].
pub fn wrap_angle_rad(angle_rad: f64) -> f64 {
    let turned = angle_rad.rem_euclid(TAU);
    if turned > PI { turned - TAU } else { turned }
}

/// A bearing that a setting accepts after rounding to three decimals: π itself would become 3.142.
pub fn as_setting_rad(bearing_rad: f64) -> f64 {
    let limit_rad = PI - 1e-3;
    wrap_angle_rad(bearing_rad).clamp(-limit_rad, limit_rad)
}

/// Whether a pose has neither an infinite value nor one that is no number.
pub fn is_finite_pose(pose: &Isometry2<f64>) -> bool {
    pose.to_homogeneous().iter().all(|value| value.is_finite())
}

/// The unit vector of an angle; x is ahead, y left.
pub fn unit(angle_rad: f64) -> Vector2<f64> {
    Vector2::new(angle_rad.cos(), angle_rad.sin())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn view(beams: &[Beam], full_turn: bool) -> View {
        let step_rad = TAU / 36.0;
        Sweep { beams: beams.to_vec(), step_rad, full_turn, ..Sweep::default() }.view()
    }

    #[test]
    fn a_blind_sector_of_a_full_turn_is_outside_the_view_wherever_the_message_begins() {
        let mut beams = vec![Beam::NoReturn; 36];
        beams[..4].fill(Beam::Unknown);
        beams[20] = Beam::Unknown;
        for _ in 0..36 {
            beams.rotate_left(1);
            let View { first, len, full_turn, .. } = view(&beams, true);
            assert_eq!((len, full_turn), (32, false));
            assert!((0..len).all(|at| at == 16 || beams[(first + at) % 36] == Beam::NoReturn), "{first}");
        }
    }

    #[test]
    fn a_narrow_blind_sector_leaves_the_full_turn_and_a_limited_view_stays_as_it_is() {
        let mut beams = vec![Beam::NoReturn; 36];
        beams[10..13].fill(Beam::Unknown);
        assert_eq!(view(&beams, true), View { first: 0, len: 36, full_turn: true, clockwise: false });
        beams[10..20].fill(Beam::Unknown);
        assert_eq!(view(&beams, false), View { first: 0, len: 36, full_turn: false, clockwise: false });
        assert_eq!(
            view(&[Beam::Unknown; 36], true),
            View { first: 0, len: 36, full_turn: true, clockwise: false },
            "blind all around"
        );
    }

    #[test]
    fn beams_are_met_anticlockwise_whichever_way_and_wherever_the_message_begins() {
        let step_rad = TAU / 36.0;
        let mut beams: Vec<_> = (0..36).map(|beam| (Beam::Return(beam), f64::from(beam) * step_rad)).collect();
        beams[..4].iter_mut().for_each(|(beam, _)| *beam = Beam::Unknown);
        let expected: Vec<_> = (4..36).map(Beam::Return).collect();
        for clockwise in [false, true] {
            for _ in 0..36 {
                beams.rotate_left(1);
                let (beams, bearings_rad) = beams.iter().map(|&(beam, rad)| (beam, wrap_angle_rad(rad))).unzip();
                let sweep = Sweep { beams, bearings_rad, step_rad, full_turn: true, ..Sweep::default() };
                let view = sweep.view();
                assert_eq!(view.clockwise, clockwise);
                assert_eq!(sweep.anticlockwise(view).collect::<Vec<_>>(), expected);
            }
            beams.reverse();
        }
    }

    #[test]
    fn beams_that_are_missing_in_a_turn_are_met_as_unknown_between_the_last_and_the_first() {
        let step_rad = TAU / 36.0;
        for clockwise in [false, true] {
            let turned = |beam: u32| if clockwise { -f64::from(beam) } else { f64::from(beam) };
            let bearings_rad = (0..34).map(|beam| wrap_angle_rad(turned(beam) * step_rad)).collect();
            let beams: Vec<_> = (0..34).map(Beam::Return).collect();
            let sweep = Sweep { beams, bearings_rad, step_rad, full_turn: true, missing: 2, ..Sweep::default() };
            let met: Vec<_> = sweep.anticlockwise(sweep.view()).collect();
            let mut expected: Vec<_> = (0..34).map(Beam::Return).chain([Beam::Unknown; 2]).collect();
            if clockwise {
                expected.reverse();
            }
            assert_eq!(met, expected);
        }
    }

    #[test]
    fn beams_that_are_missing_widen_a_blind_sector_beside_them() {
        for first_of_blind in [0, 32] {
            let mut beams = vec![Beam::NoReturn; 34];
            beams[first_of_blind..first_of_blind + 2].fill(Beam::Unknown);
            let sweep = |missing| Sweep {
                beams: beams.clone(),
                step_rad: TAU / 36.0,
                full_turn: true,
                missing,
                ..Sweep::default()
            };
            let view = sweep(2).view();
            assert_eq!((view.len, view.full_turn), (32, false));
            let met: Vec<_> = sweep(2).anticlockwise(view).collect();
            assert_eq!(met, [Beam::NoReturn; 32]);
            assert!(sweep(0).view().full_turn);
        }
    }

    #[test]
    fn a_revolution_that_no_sensor_makes_is_told() {
        let sweep = Sweep {
            ranges_m: vec![1.0; 4],
            bearings_rad: vec![0.0, 1.5, 3.0, -1.5],
            beams: vec![Beam::Return(0), Beam::Return(1), Beam::NoReturn, Beam::Unknown],
            step_rad: TAU / 4.0,
            ..Sweep::default()
        };
        let points_m = vec![Point::new(1.0, 0.0, 0.0), Point::new(0.0, 1.0, 0.0)];
        let sound = Revolution { points_m, sweep: Some(sweep), ..Revolution::default() };
        assert_eq!(sound.fault(), None);
        let altered = |alter: fn(&mut Revolution, &mut Sweep)| {
            let mut revolution = sound.clone();
            let mut sweep = revolution.sweep.take().expect("beams");
            alter(&mut revolution, &mut sweep);
            Revolution { sweep: Some(sweep), ..revolution }.fault()
        };
        assert!(altered(|_, sweep| sweep.missing = 1_000_000_000).is_some());
        assert!(altered(|_, sweep| sweep.missing = usize::MAX).is_some());
        assert!(altered(|_, sweep| (sweep.beams, sweep.step_rad, sweep.missing) = (Vec::new(), 0.0, 1)).is_some());
        assert!(altered(|_, sweep| (sweep.beams, sweep.missing) = (Vec::new(), 1_000_000_000)).is_some());
        for step_rad in [0.0, -1.0, 1e-300, f64::NAN, f64::INFINITY] {
            let mut revolution = sound.clone();
            revolution.sweep.as_mut().expect("beams").step_rad = step_rad;
            assert!(revolution.fault().is_some(), "{step_rad}");
        }
        assert!(altered(|_, sweep| sweep.beams[2] = Beam::Return(2)).is_some());
        assert!(altered(|_, sweep| sweep.bearings_rad.truncate(3)).is_some());
        assert!(altered(|_, sweep| sweep.ranges_m.truncate(3)).is_some());
        assert!(altered(|revolution, _| revolution.points_m[1].x = f64::NAN).is_some());
        assert!(altered(|revolution, _| revolution.entries = vec![2]).is_some());
    }

    #[test]
    fn wrapping_keeps_the_direction_and_lands_in_the_half_open_interval() {
        for turns in -3..=3 {
            for step in 0..360 {
                let angle = f64::from(step).to_radians() + f64::from(turns) * TAU;
                let wrapped = wrap_angle_rad(angle);
                assert!(wrapped > -PI && wrapped <= PI, "{angle} wrapped to {wrapped}");
                assert!((wrapped.cos() - angle.cos()).abs() < 1e-9 && (wrapped.sin() - angle.sin()).abs() < 1e-9);
            }
        }
        assert_eq!(wrap_angle_rad(-PI), PI);
    }
}
