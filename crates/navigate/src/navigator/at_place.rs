//! Within a place: to where it is decided, and out by the chosen way.

use nalgebra::{Isometry2, Point2};

use crosscut_flight::{Here, HereKind, Mapper, Way};
use crosscut_stage::{unit, wrap_angle_rad};

use super::following::freest;
use super::{BEFORE_FACE_M, BEYOND_LOOK_M, Doing, Navigator};
use crate::surround::Field;

/// The revolutions that a place is looked at before a decision, at least, and at most before one without the map.
const LEAST_LOOKS: u64 = 6;
const MOST_LOOKS: u64 = 40;

/// Revolutions to reach the middle of a junction, and the face of a dead end.
const MOST_TO_MIDDLE: u64 = 90;
const MOST_TO_FACE: u64 = 150;

/// A place that was seen ceases to be one after this many revolutions without it.
const MOST_AWAY: u64 = 12;

/// An attempt to leave may take this many revolutions.
const MOST_TO_LEAVE: u64 = 250;

impl Navigator {
    pub(super) fn arrive(&mut self, kind: HereKind, from_m: Point2<f64>) {
        self.without_way = 0;
        self.doing = Doing::Arrive { kind, began: self.now, from_m, last_seen: self.now };
    }

    /// On the way to where it is decided: whether the vehicle is there, and knows as much as it will.
    pub(super) fn is_to_decide(
        &mut self,
        steady: Option<&Here>,
        pose: &Isometry2<f64>,
        field: &Field,
        mapper: &Mapper,
    ) -> bool {
        let Doing::Arrive { kind, began, from_m, last_seen } = self.doing else { return false };
        let is_seen = steady.is_some_and(|here| here.kind == kind);
        let last_seen = if is_seen { self.now } else { last_seen };
        self.doing = Doing::Arrive { kind, began, from_m, last_seen };
        if self.now - last_seen > MOST_AWAY {
            self.doing = Doing::Follow;
            return false;
        }
        // Of a junction the map may say more for as long as the way to its middle takes.
        let most = MOST_LOOKS + if kind == HereKind::Junction { MOST_TO_MIDDLE } else { 0 };
        self.has_arrived(kind, began, from_m, steady, pose, field) && (mapper.is_in_node() || self.now - began > most)
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
                here.node() == Some(kind) && here.ways.iter().any(is_ahead)
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
    pub(super) fn leave(&mut self, seen: Option<&Here>, steady: Option<&Here>, pose: &Isometry2<f64>, began: u64) {
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
            self.note_try(&left, led_into);
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
}
