//! Along a passage: the way ahead, until a place is reached.

use nalgebra::{Isometry2, Point2};

use crosscut_flight::{Here, HereKind, Way};
use crosscut_stage::{unit, wrap_angle_rad};

use super::{BEFORE_FACE_M, BEYOND_LOOK_M, Navigator};
use crate::surround::Field;

/// Without a way ahead for this many revolutions, the vehicle turns back.
const MOST_WITHOUT_WAY: u64 = 30;

impl Navigator {
    /// Along a passage, until a place is reached.
    pub(super) fn follow(&mut self, seen: Option<&Here>, steady: Option<&Here>, pose: &Isometry2<f64>, field: &Field) {
        let here_m = Point2::from(pose.translation.vector);
        let from_left_m = self.left.map_or(f64::INFINITY, |left| (left.at_m - here_m).norm());
        if let Some(here) = steady {
            let has_left = self.left.is_none_or(|left| from_left_m > left.look_m + BEYOND_LOOK_M);
            let node = here.node();
            self.is_armed |= has_left && node.is_none();
            // Of junctions that stand close, no passage is seen in between: this one is another if the vehicle is in its middle.
            let is_in_middle = seen.is_some_and(|seen| seen.is_middle && seen.node() == node);
            let is_other = match node {
                Some(HereKind::Junction) => {
                    self.is_armed
                        || has_left && is_in_middle
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

    /// The way of a place that continues the present course, not back.
    pub(super) fn way_ahead(&self, here: &Here, pose: &Isometry2<f64>) -> Option<Way> {
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
    pub(super) fn back_rad(&self, here_m: Point2<f64>, far_m: f64) -> Option<f64> {
        let towards = self.trail.back_m(here_m, far_m)? - here_m;
        Some(towards.y.atan2(towards.x))
    }
}

/// How far it is free in about the course, and in which direction it is free the farthest.
pub(super) fn freest(field: &Field, course_rad: f64, radius_m: f64) -> (f64, f64) {
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
