//! Matches without odometry, which may lie farther from the steady motion than the kernel is wide.

use nalgebra::{Isometry2, Matrix3, Unit, Vector2, Vector3};

use crosscut_stage::Point;

use super::{ALIKE, Aligned, DEVIATION_M, Held, KERNEL_M, Matched, OTHER_LEAD, Prediction, ScanMatcher, USUAL_AFTER};
use crate::evidence::stepped;
use crate::line_points::{least_axis, line_points};
use crate::local_map::LocalMap;
use crate::motion::difference;
use crate::search::{self, Kernel, SAME_M, Shift};

/// Where nothing is known of the motion, a scan is looked for this far along the direction in which walls hold it least, metres.
const REACH_M: f64 = 2.5;

/// Beside a match of walls that lie worse than usual, and beside a motion that is known, metres.
const REACH_POOR_M: f64 = 1.5;
const REACH_KNOWN_M: f64 = 0.5;

/// A match that walls hold is where they show it if each other shift is worse by this, in squares of standard deviations.
const LEAST_LEAD: f64 = 1.0;

/// A shift costs at most this for being none that the motion before lets expect, in squares of standard deviations.
const MOST_OF_MOTION: f64 = 2.0;

/// Where a vehicle is whose motion is not known, along a direction that walls do not show (standard deviation), metres.
const UNKNOWN_M: f64 = 0.35;

/// What is made up for motions that were not known is off by this share of it (standard deviation).
const MADE_UP_SHARE: f64 = 0.5;

/// How far a match may end from a start that was searched for (standard deviations).
const START_M: f64 = 0.3;
const START_RAD: f64 = 0.1;

/// What line points show of how far along a direction the vehicle is.
#[derive(Default)]
struct Shown {
    shift: Option<Shift>,
    /// By the walls, beyond doubt.
    is_sure: bool,
    /// By those of the revolution before.
    is_fresh: bool,
    /// Another shift fits better, though not by enough to follow it, metres.
    doubt_m: f64,
}

impl ScanMatcher {
    /// The pose by scans alone, `best` being the match nearest to the steady motion. Where that is poor, or the motion is not
    /// known, others are searched for; where walls do not hold the pose along a direction, the line points that show it decide.
    pub(super) fn by_scans(&mut self, points_m: &[Point], prediction: &Prediction, mut best: Aligned) -> Matched {
        let is_known = self.unaided.is_motion_known;
        let all = self.line_points.len() as f64;
        let is_poor = best.matched.lost || self.usual.are_worse(best.walls / all);
        if is_poor || (!is_known && self.usual.revolutions < USUAL_AFTER) {
            best = self.searched(prediction, best);
        }
        let is_off = difference(&best.matched.pose, &prediction.pose).xy().norm() > KERNEL_M;
        let axis = match best.matched.held {
            _ if best.matched.lost => None,
            Held::ButAlong(axis) => Some(axis),
            _ if is_poor || !is_known || is_off => Some(most_axis(&best.matched.covariance)),
            _ => None,
        };
        let mut shown =
            axis.map_or_else(Shown::default, |along| self.shown(points_m, &along, &best, is_poor, prediction));
        if let Some((along, shift)) = axis.zip(shown.shift) {
            let shifted = self.shifted(&best, &along, &shift);
            shown.shift = shown.shift.filter(|_| !shifted.matched.lost);
            if shown.shift.is_some() {
                best = shifted;
            }
        }
        self.walls_of_point = best.walls / all;
        let is_shown = shown.shift.is_some();
        let off = difference(&best.matched.pose, &prediction.pose);
        let surprise = if is_known { prediction.surprise(&off) } else { 0.0 };
        let mut matched = best.matched;
        if self.usual.is_unusual(matched.matched, if is_shown { 0.0 } else { surprise }) {
            matched = Matched { matched: matched.matched, ..prediction.lost() };
        }
        matched.surprise = surprise;
        if matched.lost {
            return matched;
        }
        if let Some(along) = axis.filter(|_| !is_shown) {
            let unknown_m = if is_known { shown.doubt_m.abs() } else { UNKNOWN_M };
            if unknown_m > KERNEL_M {
                matched.held = Held::ButAlong(along);
                let along = along.into_inner().push(0.0);
                matched.covariance += along * along.transpose() * unknown_m * unknown_m;
            }
        }
        self.follow(&mut matched, &shown, axis);
        matched
    }

    /// The best of a match and of those from the starts around it.
    fn searched(&mut self, prediction: &Prediction, mut best: Aligned) -> Aligned {
        let is_known = self.unaided.is_motion_known;
        let expected = if best.matched.lost { prediction.pose } else { best.matched.pose };
        let start = Vector3::new(START_M, START_M, START_RAD);
        for pose in self.unaided.search.around(&self.line_points, &self.map, &expected) {
            let other = self.align(&Prediction::by_information(pose, start.map(|of| of.powi(-2))), None);
            let is_better = OTHER_LEAD + other.weighed(prediction, is_known) < best.weighed(prediction, is_known);
            if is_better || (best.matched.lost && !other.matched.lost) {
                best = other;
            }
        }
        best
    }

    /// What line points show along a direction: of those that lie on walls, or else on what came into view with the revolution
    /// before.
    fn shown(
        &mut self,
        points_m: &[Point],
        along: &Unit<Vector2<f64>>,
        best: &Aligned,
        is_poor: bool,
        prediction: &Prediction,
    ) -> Shown {
        let pose = &best.matched.pose;
        // What shows the way may be few line points: none is left out.
        line_points(points_m, 1, &mut self.unaided.shown);
        self.unaided.shown.retain(|point| search::shows(&point.at(pose), along));
        let is_held = best.matched.held == Held::Everywhere;
        let is_near = |shift: &Shift| is_held && shift.by_m.abs() < SAME_M && shift.lead > LEAST_LEAD;
        let is_taken = |shift: &Shift| shift.lead > OTHER_LEAD || is_near(shift);
        let by_walls = self.shift(pose, along, is_poor, prediction, &LocalMap::default());
        let taken = by_walls.filter(is_taken);
        let is_fresh = taken.is_none() && !self.unaided.fresh.is_empty();
        let shift = match is_fresh {
            true => self.shift(pose, along, is_poor, prediction, &self.unaided.fresh).filter(is_taken),
            false => taken,
        };
        let doubted = by_walls.filter(|of| shift.is_none() && of.lead > 0.0);
        Shown {
            shift,
            is_sure: taken.is_some_and(|shift| shift.lead > OTHER_LEAD),
            is_fresh,
            doubt_m: doubted.map_or(0.0, |of| of.by_m),
        }
    }

    /// The shift along a direction in which the line points that show it lie best on the walls.
    fn shift(
        &self,
        pose: &Isometry2<f64>,
        along: &Unit<Vector2<f64>>,
        is_poor: bool,
        prediction: &Prediction,
        fresh: &LocalMap,
    ) -> Option<Shift> {
        let is_known = self.unaided.is_motion_known;
        let shown: Vec<_> = self.unaided.shown.iter().map(|point| point.at(pose)).collect();
        let predicted_m = along.dot(&(prediction.pose.translation.vector - pose.translation.vector));
        let variance_m2 = along.dot(&(prediction.covariance.fixed_view::<2, 2>(0, 0) * along.into_inner()));
        let cost = |shift_m: f64| match is_known {
            true => ((shift_m - predicted_m).powi(2) / variance_m2).min(MOST_OF_MOTION),
            false => 0.0,
        };
        let reach_m = match (is_known, is_poor) {
            (false, _) => REACH_M,
            (_, true) => REACH_POOR_M,
            _ => REACH_KNOWN_M,
        };
        let kernel = Kernel { width_m: KERNEL_M, deviation_m: DEVIATION_M, alike: ALIKE };
        search::along(&shown, along, reach_m, [&self.map, fresh], cost, kernel)
    }

    /// The match at a shift, which holds it along its direction.
    fn shifted(&mut self, best: &Aligned, along: &Unit<Vector2<f64>>, shift: &Shift) -> Aligned {
        let along = along.into_inner().push(0.0);
        let pose = stepped(&best.matched.pose, &(along * shift.by_m));
        let mut prediction =
            Prediction::by_information(pose, Vector3::new(START_M, START_M, START_RAD).map(|of| of.powi(-2)));
        let information = prediction.information[0] + along * along.transpose() / shift.variance_m2;
        prediction.information = [information; 2];
        let mut shifted = self.align(&prediction, None);
        shifted.matched.held = Held::Everywhere;
        shifted
    }

    /// What is carried to the next revolution.
    fn follow(&mut self, matched: &mut Matched, shown: &Shown, axis: Option<Unit<Vector2<f64>>>) {
        let is_held = matched.held == Held::Everywhere;
        let of = &mut self.unaided;
        of.must_remember = shown.shift.is_some() && shown.is_fresh;
        of.fresh.clear();
        if shown.shift.is_none() && axis.is_some() {
            of.shown.iter().for_each(|point| of.fresh.insert(point.at(&matched.pose)));
        }
        matched.guess_known_m = (is_held && shown.is_sure && !of.is_adrift).then_some(0.0);
        let step = self.pose.inv_mul(&matched.pose);
        match (axis, shown.shift) {
            (Some(along), Some(shift)) if shown.is_fresh && !of.is_motion_known => {
                // The vehicle most likely moved so before, too.
                let made_up = along.into_inner() * (shift.by_m * f64::from(of.unknown));
                if made_up.norm() < REACH_M {
                    matched.pose.translation.vector += made_up;
                    matched.guess_known_m = Some(MADE_UP_SHARE * made_up.norm());
                    of.next_step = Some(step);
                }
            }
            _ if is_held && of.unknown > 0 => {
                let share = 1.0 / f64::from(of.unknown + 1);
                of.next_step = Some(Isometry2::new(step.translation.vector * share, step.rotation.angle() * share));
            }
            _ => {}
        }
        of.unknown = if of.is_motion_known || is_held { 0 } else { of.unknown + 1 };
        of.is_motion_known |= shown.shift.is_some() || axis.is_none();
        of.is_adrift &= !is_held;
    }
}

impl Prediction {
    /// A pose that nothing predicted, with what holds a match to it.
    fn by_information(pose: Isometry2<f64>, information: Vector3<f64>) -> Self {
        let information = Matrix3::from_diagonal(&information);
        let covariance = Matrix3::from_diagonal(&information.diagonal().map(|of| 1.0 / of));
        Self { pose, of_motion: covariance, covariance, information: [information; 2] }
    }
}

/// The direction in which a position is known least.
fn most_axis(covariance: &Matrix3<f64>) -> Unit<Vector2<f64>> {
    least_axis(&-covariance.fixed_view::<2, 2>(0, 0).into_owned()).1
}
