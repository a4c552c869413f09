//! Poses by matching each revolution to the walls seen before it, point to line.
//!
//! The pose minimises, over the returns i that lie on a line and have a line point (qᵢ, nᵢ) of the local map beside them,
//!
//! ```text
//! Σ ρ(nᵢ · (R pᵢ + t - qᵢ)) / σ²  +  (x - x̂)ᵀ P⁻¹ (x - x̂)
//! ```
//!
//! with ρ of Geman and McClure and x̂, P the predicted pose and its covariance. The second term decides where the walls
//! do not: along a straight smooth tunnel.

use nalgebra::{Isometry2, Matrix3, Point2, Vector3};

use crosscut_stage::{Revolution, wrap_angle_rad};

use crate::evidence::{Evidence, stepped};
use crate::line_points::{LinePoint, line_points};
use crate::local_map::LocalMap;

/// A typical distance of a return from the line that it belongs to: noise of the range and roughness of walls.
const DEVIATION_M: f64 = 0.05;

/// ρ turns from a square to a constant about here, so that returns of what moves or was not seen before weigh little.
const KERNEL_M: f64 = 0.15;

/// The iteration ends at a step shorter than this, metres and radians.
const CONVERGED: f64 = 1e-4;
const MAX_ITERATIONS: usize = 25;

/// Line points farther than this from the vehicle are forgotten.
const MAP_RADIUS_M: f64 = 40.0;

/// A revolution adds its line points to the map once the vehicle has moved or turned this far since the last that did.
const KEYFRAME_M: f64 = 0.5;
const KEYFRAME_RAD: f64 = 0.15;

/// Below this share of matched line points the pose is not believed.
const LEAST_MATCHED: f64 = 0.3;

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

/// Where a revolution was taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Matched {
    /// The pose in the frame of the first revolution.
    pub pose: Isometry2<f64>,
    /// Covariance of the motion since the revolution before, x, y (m²) and yaw (rad²) in the map's axes. It takes the returns
    /// as independent of each other, so that it is rather too small.
    pub covariance: Matrix3<f64>,
    /// Share of the line points of the revolution that have one of the map beside them.
    pub matched: f64,
    /// How far the motion lies from the predicted one, in standard deviations of the two together. Far above 3 after a
    /// wheel slipped, or when scans are missing.
    pub surprise: f64,
    /// Too few were matched: the pose is the predicted one, and the map begins here.
    pub lost: bool,
}

/// Matches revolutions, in order, against the walls seen shortly before.
#[derive(Clone, Debug, Default)]
pub struct ScanMatcher {
    map: LocalMap,
    line_points: Vec<LinePoint>,
    pose: Isometry2<f64>,
    keyframe: Isometry2<f64>,
    last_step: Isometry2<f64>,
}

impl ScanMatcher {
    /// The pose of the next revolution. Without a `predicted` motion the vehicle is taken to move on steadily.
    pub fn add(&mut self, revolution: &Revolution, predicted: Option<Motion>) -> Matched {
        line_points(&revolution.points_m, &mut self.line_points);
        let steady = self.steady_motion();
        let Motion { step, covariance } = predicted.unwrap_or(steady);
        let predicted = self.pose * step;
        let prior = turned(&covariance, self.pose.rotation.angle());
        // A revolution without walls, such as one of a covered lidar, is not lost: the next may match again.
        let matched = if self.map.is_empty() || self.line_points.is_empty() {
            Matched { pose: predicted, covariance: prior, matched: 1.0, surprise: 0.0, lost: false }
        } else {
            // Walls off by more than the kernel do not pull: after a slip the minimum lies near the steady motion.
            let others = [self.pose * steady.step, self.pose];
            let is_far = |other: &Isometry2<f64>| difference(other, &predicted).amax() > KERNEL_M;
            let starts = std::iter::once(predicted).chain(others.into_iter().filter(is_far));
            let aligned = starts.map(|start| self.align(start, &predicted, prior));
            let best = aligned.min_by(|(cost, _), (other, _)| cost.total_cmp(other));
            best.expect("the first start is always there").1
        };
        self.last_step = self.pose.inv_mul(&matched.pose);
        self.pose = matched.pose;
        if matched.lost {
            self.map.clear();
        }
        self.remember();
        matched
    }

    fn steady_motion(&self) -> Motion {
        let step = self.last_step;
        let deviation_m = STEADY_M + STEADY_SHARE * step.translation.vector.norm();
        let deviation_rad = STEADY_RAD + STEADY_SHARE * step.rotation.angle().abs();
        let variances = Vector3::new(deviation_m, deviation_m, deviation_rad).map(|deviation| deviation * deviation);
        Motion { step, covariance: Matrix3::from_diagonal(&variances) }
    }

    /// The minimum of the sum near `start`, and its value; infinite if the pose is lost.
    fn align(&self, start: Isometry2<f64>, predicted: &Isometry2<f64>, prior: Matrix3<f64>) -> (f64, Matched) {
        let lost = Matched { pose: *predicted, covariance: prior, matched: 0.0, surprise: 0.0, lost: true };
        let Some(prior_information) = prior.try_inverse() else { return (f64::INFINITY, lost) };
        let mut pose = start;
        for _ in 0..MAX_ITERATIONS {
            let walls = self.evidence_at(&pose);
            let off = difference(&pose, predicted);
            let information = walls.information + prior_information;
            let Some(factor) = information.cholesky() else { return (f64::INFINITY, lost) };
            let step = factor.solve(&-(walls.gradient + prior_information * off));
            pose = stepped(&pose, &step);
            if step.amax() < CONVERGED {
                break;
            }
        }
        let walls = self.evidence_at(&pose);
        let matched = walls.matched as f64 / self.line_points.len() as f64;
        let off = difference(&pose, predicted);
        let from_prediction = off.dot(&(prior_information * off)).max(0.0);
        let unmatched = (self.line_points.len() - walls.matched) as f64;
        let cost = walls.cost + unmatched * (KERNEL_M / DEVIATION_M).powi(2) + from_prediction;
        let apart = (prior + matching_covariance()).try_inverse().unwrap_or(prior_information);
        let surprise = off.dot(&(apart * off)).max(0.0).sqrt();
        match (walls.information + prior_information).try_inverse() {
            Some(covariance) if matched >= LEAST_MATCHED => {
                (cost, Matched { pose, covariance, matched, surprise, lost: false })
            }
            _ => (f64::INFINITY, Matched { matched, ..lost }),
        }
    }

    /// The walls' part of the sum at a pose.
    fn evidence_at(&self, pose: &Isometry2<f64>) -> Evidence {
        const WEIGHT: f64 = 1.0 / (DEVIATION_M * DEVIATION_M);
        let Evidence { cost, information, gradient, matched } =
            Evidence::of(&self.line_points, &self.map, pose, KERNEL_M);
        Evidence { cost: cost * WEIGHT, information: information * WEIGHT, gradient: gradient * WEIGHT, matched }
    }

    /// Adds the revolution to the map if the vehicle has moved or turned enough since the last one that was added.
    fn remember(&mut self) {
        let since = self.keyframe.inv_mul(&self.pose);
        let is_far = since.translation.vector.norm() > KEYFRAME_M || since.rotation.angle().abs() > KEYFRAME_RAD;
        if !is_far && !self.map.is_empty() {
            return;
        }
        self.keyframe = self.pose;
        self.map.keep_around(&Point2::from(self.pose.translation.vector), MAP_RADIUS_M);
        for point in &self.line_points {
            self.map.insert(point.at(&self.pose));
        }
    }
}

/// Covariance of the motion between two poses that are matched to the same walls.
fn matching_covariance() -> Matrix3<f64> {
    let deviations = Vector3::new(MATCHING_M, MATCHING_M, MATCHING_RAD);
    Matrix3::from_diagonal(&deviations.component_mul(&deviations))
}

/// x, y and yaw of a pose less those of another, in the axes of the map.
fn difference(pose: &Isometry2<f64>, other: &Isometry2<f64>) -> Vector3<f64> {
    let off_m = pose.translation.vector - other.translation.vector;
    Vector3::new(off_m.x, off_m.y, wrap_angle_rad(pose.rotation.angle() - other.rotation.angle()))
}

/// A covariance of x, y and yaw in axes that lie `yaw_rad` clockwise of its own.
fn turned(covariance: &Matrix3<f64>, yaw_rad: f64) -> Matrix3<f64> {
    let turn = nalgebra::Rotation2::new(yaw_rad).to_homogeneous();
    turn * covariance * turn.transpose()
}
