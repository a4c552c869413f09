//! Motions from one revolution to the next, and how well each source of them is known.

use nalgebra::{Isometry2, Matrix3, Vector3};

use crosscut_stage::wrap_angle_rad;

/// The scale of the odometry's variance follows this share of each innovation, within these bounds.
const EARNED: f64 = 0.05;
const LEAST_EARNED: f64 = 0.25;
const MOST_EARNED: f64 = 100.0;

/// Wheels slip, so that what odometry shows weighs no more than this against the walls, as a square of standard deviations.
pub(crate) const MOST_OF_ODOMETRY: f64 = 25.0;

/// Standard deviations of a motion that is predicted from the one before: a share of it, and at least this much.
const STEADY_SHARE: f64 = 0.3;
const STEADY_M: f64 = 0.05;
const STEADY_RAD: f64 = 0.05;

/// Two poses that are matched to the same walls are off by this from each other although nothing slipped (standard
/// deviations): walls are rough, and the scan bends while the vehicle turns.
const MATCHING_M: f64 = 0.02;
const MATCHING_RAD: f64 = 0.01;

/// A motion from one revolution to the next, and how well it is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// The later pose in the frame of the earlier one.
    pub step: Isometry2<f64>,
    /// Of x, y (m²) and yaw (rad²) in the frame of the earlier pose.
    pub covariance: Matrix3<f64>,
}

/// How many times the variance of its motions that odometry is stated to have it has shown, by position and by heading.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Earned([f64; 2]);

impl Default for Earned {
    fn default() -> Self {
        Self([1.0; 2])
    }
}

impl Earned {
    pub(crate) fn scaled(&self, covariance: &Matrix3<f64>) -> Matrix3<f64> {
        let [position, heading] = self.0.map(f64::sqrt);
        let scale = Matrix3::from_diagonal(&Vector3::new(position, position, heading));
        scale * covariance * scale
    }

    /// Takes how far a match lies off a motion with a covariance that was scaled.
    pub(crate) fn add(&mut self, off: &Vector3<f64>, covariance: &Matrix3<f64>) {
        let expected = covariance + matching_covariance();
        let square = |at: usize| off[at] * off[at] / expected[(at, at)];
        for (scale, times) in self.0.iter_mut().zip([0.5 * (square(0) + square(1)), square(2)]) {
            *scale = (*scale * (1.0 + EARNED * (times.min(MOST_OF_ODOMETRY) - 1.0))).clamp(LEAST_EARNED, MOST_EARNED);
        }
    }
}

/// Covariance of a motion that is predicted from the one before.
pub(crate) fn steadily(step: &Isometry2<f64>) -> Matrix3<f64> {
    let deviation_m = STEADY_M + STEADY_SHARE * step.translation.vector.norm();
    let deviation_rad = STEADY_RAD + STEADY_SHARE * step.rotation.angle().abs();
    let deviations = Vector3::new(deviation_m, deviation_m, deviation_rad);
    Matrix3::from_diagonal(&deviations.component_mul(&deviations))
}

/// Of two covariances without correlations, the greater variance of each value.
pub(crate) fn loosest(a: &Matrix3<f64>, b: &Matrix3<f64>) -> Matrix3<f64> {
    Matrix3::from_diagonal(&a.diagonal().sup(&b.diagonal()))
}

/// Covariance of the motion between two poses that are matched to the same walls.
pub(crate) fn matching_covariance() -> Matrix3<f64> {
    let deviations = Vector3::new(MATCHING_M, MATCHING_M, MATCHING_RAD);
    Matrix3::from_diagonal(&deviations.component_mul(&deviations))
}

/// x, y and yaw of a pose less those of another, in the axes of the map.
pub(crate) fn difference(pose: &Isometry2<f64>, other: &Isometry2<f64>) -> Vector3<f64> {
    let off_m = pose.translation.vector - other.translation.vector;
    Vector3::new(off_m.x, off_m.y, wrap_angle_rad(pose.rotation.angle() - other.rotation.angle()))
}

/// A covariance of x, y and yaw in axes that lie `yaw_rad` clockwise of its own.
pub(crate) fn turned(covariance: &Matrix3<f64>, yaw_rad: f64) -> Matrix3<f64> {
    let turn = nalgebra::Rotation2::new(yaw_rad).to_homogeneous();
    turn * covariance * turn.transpose()
}
