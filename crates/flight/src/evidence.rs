//! How line points lie on walls at a pose: the point-to-line sum that scan matching and the fit of outlines minimise.
//!
//! Over the line points pᵢ that have a line point (qᵢ, nᵢ) of the walls beside them, with dᵢ = nᵢ · (R pᵢ + t - qᵢ) and the
//! kernel ρ of Geman and McClure, which turns from a square to a constant about k:
//!
//! ```text
//! Σ ρ(dᵢ),   ρ(d) = k² d² / (k² + d²)
//! ```

use nalgebra::{Isometry2, Matrix2, Matrix3, Vector2, Vector3};

use crate::line_points::LinePoint;
use crate::local_map::LocalMap;

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

impl Evidence {
    pub(crate) fn of<'a>(
        points: impl IntoIterator<Item = &'a LinePoint>,
        walls: &LocalMap,
        pose: &Isometry2<f64>,
        kernel_m: f64,
    ) -> Self {
        let mut evidence = Self::default();
        for point in points {
            let at = point.at(pose);
            let Some(wall) = walls.nearest(&at) else { continue };
            let distance_m = wall.normal.dot(&(at.position_m - wall.position_m));
            let arm_m = at.position_m.coords - pose.translation.vector;
            let by_yaw = wall.normal.dot(&Vector2::new(-arm_m.y, arm_m.x));
            let by_pose = Vector3::new(wall.normal.x, wall.normal.y, by_yaw);
            let kernel = kernel_m * kernel_m / (kernel_m * kernel_m + distance_m * distance_m);
            let weight = kernel * kernel;
            evidence.information += by_pose * by_pose.transpose() * weight;
            let along = Vector2::new(-wall.normal.y, wall.normal.x);
            evidence.noise += along * along.transpose() * (weight * wall.tilt_rad2);
            evidence.gradient += by_pose * (weight * distance_m);
            evidence.cost += kernel * distance_m * distance_m;
            evidence.matched += 1;
        }
        evidence
    }
}

/// The pose after a step in x, y and yaw.
pub(crate) fn stepped(pose: &Isometry2<f64>, step: &Vector3<f64>) -> Isometry2<f64> {
    Isometry2::new(pose.translation.vector + step.xy(), pose.rotation.angle() + step.z)
}
