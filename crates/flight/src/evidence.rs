//! How line points lie on walls at a pose: the point-to-line sum that scan matching and the fit of outlines minimise.
//!
//! Over the line points pᵢ that have a line point (qᵢ, nᵢ) of the walls beside them, with dᵢ = nᵢ · (R pᵢ + t - qᵢ) and the
//! kernel ρ of Geman and McClure, which turns from a square to a constant about k:
//!
//! ```text
//! Σ ρ(dᵢ),   ρ(d) = k² d² / (k² + d²)
//! ```

use nalgebra::{Isometry2, Matrix2, Matrix3, Point2, Vector2, Vector3};

use crate::line_points::LinePoint;
use crate::local_map::{LocalMap, Near, ROUNDING_M, TURNED_RAD};

/// The sum at a pose, with its gradient and curvature (Gauss-Newton) by x, y and yaw.
#[derive(Default)]
pub(crate) struct Evidence {
    pub(crate) cost: f64,
    pub(crate) information: Matrix3<f64>,
    pub(crate) gradient: Vector3<f64>,
    /// The part of the curvature by x and y that noise of the normals makes by itself, on average.
    pub(crate) noise: Matrix2<f64>,
    /// How many line points have one of the walls beside them.
    pub(crate) matched: usize,
}

/// Line points that are matched to walls at one pose after the other. What lies beside each is looked up again only once it
/// has moved so far that something else may.
#[derive(Clone, Debug, Default)]
pub(crate) struct Matching {
    points: Vec<LinePoint>,
    lookups: Vec<Lookup>,
}

/// What was found beside a line point, and for how long that is so.
#[derive(Clone, Copy, Debug, Default)]
struct Lookup {
    wall: Option<LinePoint>,
    /// The wall is the nearest while the line point is within this distance of `at`.
    holds_m2: f64,
    at: Place,
    near: Near,
    /// Where those near it were looked up.
    near_at: Place,
}

/// Where a line point was, and the yaw of the pose.
#[derive(Clone, Copy, Debug, Default)]
struct Place {
    at_m: Point2<f64>,
    yaw_rad: f64,
}

impl Lookup {
    fn holds(&self, at: &Place) -> bool {
        (at.at_m - self.at.at_m).norm_squared() < self.holds_m2 && (at.yaw_rad - self.at.yaw_rad).abs() < TURNED_RAD
    }

    /// Finds the wall beside a line point, which lies at `at`.
    fn find(&mut self, point: &LinePoint, at: Place, walls: &LocalMap) {
        let others_m = self.near.others_m - (at.at_m - self.near_at.at_m).norm() - ROUNDING_M;
        let mut found = walls.nearest_of(&self.near, point);
        let mut beyond_m = others_m - found.apart_m;
        if beyond_m <= 0.0 || (at.yaw_rad - self.near_at.yaw_rad).abs() >= TURNED_RAD {
            (self.near, self.near_at) = (walls.near(point), at);
            found = walls.nearest_of(&self.near, point);
            beyond_m = self.near.others_m - found.apart_m - ROUNDING_M;
        }
        let (wall, holds_m) = match beyond_m > 0.0 {
            true => (found.wall, found.holds_m.min(0.5 * beyond_m)),
            // Many that do not face the same way are nearer.
            false => (walls.nearest(point), 0.0),
        };
        *self = Self { wall: wall.copied(), holds_m2: holds_m * holds_m, at, ..*self };
    }
}

impl Matching {
    /// Begins with other line points, or with other walls.
    pub(crate) fn begin(&mut self, points: impl IntoIterator<Item = LinePoint>) {
        self.points.clear();
        self.points.extend(points);
        self.lookups.clear();
        self.lookups.resize(self.points.len(), Lookup::default());
    }

    /// How many line points there are.
    pub(crate) fn len(&self) -> usize {
        self.points.len()
    }

    /// How the line points lie on walls at a pose; the same walls since [`Matching::begin`].
    pub(crate) fn at(&mut self, pose: &Isometry2<f64>, walls: &LocalMap, kernel_m: f64) -> Evidence {
        let mut evidence = Evidence::default();
        let yaw_rad = pose.rotation.angle();
        for (point, lookup) in self.points.iter().zip(&mut self.lookups) {
            let at = Place { at_m: pose * point.position_m, yaw_rad };
            if !lookup.holds(&at) {
                lookup.find(&point.at(pose), at, walls);
            }
            if let Some(wall) = &lookup.wall {
                evidence.add(&at.at_m, wall, &pose.translation.vector, kernel_m);
            }
        }
        evidence
    }
}

impl Evidence {
    /// Adds a line point at `at_m`, seen from `from_m`, and the wall beside it.
    fn add(&mut self, at_m: &Point2<f64>, wall: &LinePoint, from_m: &Vector2<f64>, kernel_m: f64) {
        let distance_m = wall.normal.dot(&(at_m - wall.position_m));
        let arm_m = at_m.coords - from_m;
        let by_yaw = wall.normal.dot(&Vector2::new(-arm_m.y, arm_m.x));
        let by_pose = Vector3::new(wall.normal.x, wall.normal.y, by_yaw);
        let kernel = kernel_m * kernel_m / (kernel_m * kernel_m + distance_m * distance_m);
        let weight = kernel * kernel;
        self.information += by_pose * by_pose.transpose() * weight;
        let along = Vector2::new(-wall.normal.y, wall.normal.x);
        self.noise += along * along.transpose() * (weight * wall.tilt_rad2);
        self.gradient += by_pose * (weight * distance_m);
        self.cost += kernel * distance_m * distance_m;
        self.matched += 1;
    }
}

/// The pose after a step in x, y and yaw.
pub(crate) fn stepped(pose: &Isometry2<f64>, step: &Vector3<f64>) -> Isometry2<f64> {
    Isometry2::new(pose.translation.vector + step.xy(), pose.rotation.angle() + step.z)
}
