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
pub(crate) struct MatchEvidence {
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
    at: PosedPoint,
    near: Near,
    /// Where those near it were looked up.
    near_at: PosedPoint,
}

/// Where a line point was, and the yaw of the pose.
#[derive(Clone, Copy, Debug, Default)]
struct PosedPoint {
    at_m: Point2<f64>,
    yaw_rad: f64,
}

impl Lookup {
    fn holds(&self, at: &PosedPoint) -> bool {
        (at.at_m - self.at.at_m).norm_squared() < self.holds_m2 && (at.yaw_rad - self.at.yaw_rad).abs() < TURNED_RAD
    }

    /// Finds the wall beside a line point, which lies at `at`.
    fn find(&mut self, point: &LinePoint, at: PosedPoint, walls: &LocalMap) {
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
    pub(crate) fn at(&mut self, pose: &Isometry2<f64>, walls: &LocalMap, kernel_m: f64) -> MatchEvidence {
        let mut evidence = MatchEvidence::default();
        let yaw_rad = pose.rotation.angle();
        for (point, lookup) in self.points.iter().zip(&mut self.lookups) {
            let at = PosedPoint { at_m: pose * point.position_m, yaw_rad };
            if !lookup.holds(&at) {
                lookup.find(&point.at(pose), at, walls);
            }
            if let Some(wall) = &lookup.wall {
                evidence.add(&at.at_m, wall, &pose.translation.vector, kernel_m);
            }
        }
        evidence.mirrored()
    }
}

impl MatchEvidence {
    fn mirrored(mut self) -> Self {
        self.information.fill_lower_triangle_with_upper_triangle();
        self.noise.fill_lower_triangle_with_upper_triangle();
        self
    }

    /// Adds a line point at `at_m`, seen from `from_m`, and the wall beside it.
    fn add(&mut self, at_m: &Point2<f64>, wall: &LinePoint, from_m: &Vector2<f64>, kernel_m: f64) {
        let distance_m = wall.normal.dot(&(at_m - wall.position_m));
        let arm_m = at_m.coords - from_m;
        let by_yaw = wall.normal.dot(&Vector2::new(-arm_m.y, arm_m.x));
        let by_pose = Vector3::new(wall.normal.x, wall.normal.y, by_yaw);
        let kernel = kernel_m * kernel_m / (kernel_m * kernel_m + distance_m * distance_m);
        let weight = kernel * kernel;
        let along = Vector2::new(-wall.normal.y, wall.normal.x);
        let noise = weight * wall.tilt_rad2;
        // Of symmetric matrices the upper triangle; `mirrored` adds the lower one.
        for (row, column) in [(0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2)] {
            self.information[(row, column)] += by_pose[row] * by_pose[column] * weight;
        }
        for (row, column) in [(0, 0), (0, 1), (1, 1)] {
            self.noise[(row, column)] += along[row] * along[column] * noise;
        }
        self.gradient += by_pose * (weight * distance_m);
        self.cost += kernel * distance_m * distance_m;
        self.matched += 1;
    }
}

/// The pose after a step in x, y and yaw.
pub(crate) fn stepped(pose: &Isometry2<f64>, step: &Vector3<f64>) -> Isometry2<f64> {
    Isometry2::new(pose.translation.vector + step.xy(), pose.rotation.angle() + step.z)
}

#[cfg(test)]
mod tests {
    use nalgebra::Unit;

    use super::*;

    #[test]
    fn walls_kept_from_pose_to_pose_are_those_that_a_search_finds() {
        let spread = |i: u32, step: f64| (f64::from(i) * step).sin() * 3.0;
        let point = |i: u32| LinePoint {
            position_m: Point2::new(spread(i, 1.7), spread(i, 2.9)),
            normal: Unit::new_normalize(Vector2::new(spread(i, 0.3), spread(i, 0.7) + 0.1)),
            tilt_rad2: f64::from(i),
        };
        let mut walls = LocalMap::default();
        (0..600).for_each(|i| walls.insert(point(i)));
        let mut matching = Matching::default();
        matching.begin((1000..1200).map(point));
        let mut pose = Isometry2::identity();
        let (mut kept, mut looked_up) = (0, 0);
        for step in 0..200 {
            let before = matching.lookups.clone();
            matching.at(&pose, &walls, 0.15);
            for ((point, lookup), before) in matching.points.iter().zip(&matching.lookups).zip(before) {
                assert_eq!(lookup.wall.as_ref(), walls.nearest(&point.at(&pose)), "step {step}");
                let is_kept = before.at.at_m == lookup.at.at_m && step > 0;
                (kept, looked_up) = (kept + i32::from(is_kept), looked_up + i32::from(!is_kept));
            }
            // Steps of all lengths, from 30 cm down to 0.1 mm, as of an iteration.
            let length = 0.3 * 0.3f64.powi(step % 8);
            let part = |of: u32| length * spread(step as u32 * 7 + of, 1.3) / 3.0;
            pose = stepped(&pose, &Vector3::new(part(1), part(2), part(3)));
        }
        assert!(kept > 10_000 && looked_up > 5000, "{kept} kept, {looked_up} looked up");
    }
}
