//! A pose graph in the plane, solved by damped Gauss-Newton on faer's sparse Cholesky factorisation.
//!
//! With poses xᵢ = (tᵢ, θᵢ) and a measurement z of xⱼ as seen from xᵢ, the error of an edge is
//!
//! ```text
//! e = (R_z^T (R_i^T (t_j - t_i) - t_z), wrap(θ_j - θ_i - θ_z))
//! ```
//!
//! and the poses minimise Σ eᵀ Ω e over all edges (Grisetti et al. 2010, "A Tutorial on Graph-Based SLAM", equations 30
//! to 33). The first pose is held.

use faer::Side;
use faer::linalg::solvers::Solve as _;
use faer::sparse::{SparseColMat, Triplet};
use nalgebra::{Isometry2, Matrix3, Vector2, Vector3};

use crosscut_stage::{is_finite_pose, wrap_angle_rad};

/// A step smaller than this, in metres and radians, ends the iteration.
const CONVERGED: f64 = 1e-9;

/// A graph that needs more iterations is reported as it was after the last one.
const MAX_ITERATIONS: usize = 100;

/// What an edge measures, and how well.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Constraint {
    /// Index of the pose from which it was measured.
    pub from: usize,
    /// Index of the pose that was measured.
    pub to: usize,
    /// The pose `to` in the frame of the pose `from`.
    pub measured: Isometry2<f64>,
    /// Inverse covariance of the measurement: x and y in 1/m², yaw in 1/rad². Symmetric, positive semidefinite.
    pub information: Matrix3<f64>,
}

/// Information of a measurement with these standard deviations.
pub(crate) fn information(deviation_m: f64, deviation_rad: f64) -> Matrix3<f64> {
    let of = |deviation: f64| 1.0 / (deviation * deviation);
    Matrix3::from_diagonal(&Vector3::new(of(deviation_m), of(deviation_m), of(deviation_rad)))
}

/// Poses, and measurements of one from another.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PoseGraph {
    /// The poses, by index. The first one is held when the graph is solved.
    pub poses: Vec<Isometry2<f64>>,
    /// The measurements.
    pub edges: Vec<Constraint>,
}

/// Why a pose graph has no solution.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PoseGraphError {
    /// An edge names a pose that is not there, or joins a pose to itself.
    #[error("edge {edge} joins pose {from} to pose {to}, of {poses} poses")]
    NoSuchPose {
        /// Index of the edge.
        edge: usize,
        /// Where it begins.
        from: usize,
        /// Where it ends.
        to: usize,
        /// How many poses there are.
        poses: usize,
    },
    /// A pose or a measurement is no number.
    #[error("a pose or an edge holds a value that is not finite")]
    NotFinite,
    /// A pose is not joined to the first one, its edges leave a direction open, or an information matrix is not positive
    /// semidefinite.
    #[error("the edges do not determine every pose, or an information matrix is not positive semidefinite")]
    Undetermined,
}

/// What solving did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solved {
    /// Σ eᵀ Ω e before.
    pub error_before: f64,
    /// Σ eᵀ Ω e after.
    pub error_after: f64,
    /// How many steps were taken.
    pub iterations: usize,
}

impl Constraint {
    /// The error of the measurement at the poses `from` and `to`: metres, metres, radians.
    pub fn error(&self, from: &Isometry2<f64>, to: &Isometry2<f64>) -> Vector3<f64> {
        let seen = from.inv_mul(to);
        let off_m = self.measured.rotation.inverse() * (seen.translation.vector - self.measured.translation.vector);
        let off_rad = wrap_angle_rad(seen.rotation.angle() - self.measured.rotation.angle());
        Vector3::new(off_m.x, off_m.y, off_rad)
    }

    /// Derivatives of the error by (x, y, yaw) of `from` and of `to`.
    fn jacobians(&self, from: &Isometry2<f64>, to: &Isometry2<f64>) -> [Matrix3<f64>; 2] {
        let to_measured = (from.rotation * self.measured.rotation).inverse().to_rotation_matrix();
        let apart_m = to.translation.vector - from.translation.vector;
        // d(R_i^T)/dθ_i v = R_i^T (v_y, -v_x)
        let by_yaw = to_measured * Vector2::new(apart_m.y, -apart_m.x);
        let mut by_to = Matrix3::identity();
        by_to.fixed_view_mut::<2, 2>(0, 0).copy_from(to_measured.matrix());
        let mut by_from = -by_to;
        by_from.fixed_view_mut::<2, 1>(0, 2).copy_from(&by_yaw);
        [by_from, by_to]
    }
}

impl PoseGraph {
    /// Σ eᵀ Ω e over all edges.
    pub fn error(&self) -> f64 {
        self.error_at(&self.poses)
    }

    /// Moves all poses but the first to where the edges agree best.
    ///
    /// The poses must be near enough for Gauss-Newton to find the least error that is meant; steps that would raise the
    /// error are damped (Levenberg-Marquardt).
    ///
    /// # Errors
    /// When an edge names no pose, a value is not finite, or the edges do not determine every pose. The poses stay as they
    /// were.
    pub fn solve(&mut self) -> Result<Solved, PoseGraphError> {
        self.check()?;
        let error_before = self.error();
        let mut solved = Solved { error_before, error_after: error_before, iterations: 0 };
        let mut poses = self.poses.clone();
        let mut damping = 0.0;
        while poses.len() > 1 && solved.iterations < MAX_ITERATIONS {
            let step = self.step(&poses, damping)?;
            let moved = moved(&poses, &step);
            let error = self.error_at(&moved);
            solved.iterations += 1;
            let largest = step.iter().fold(0.0f64, |largest, part| largest.max(part.abs()));
            if error <= solved.error_after {
                (poses, solved.error_after, damping) = (moved, error, damping * 0.1);
            } else {
                damping = f64::max(damping * 10.0, 1e-6);
            }
            if largest < CONVERGED {
                break;
            }
        }
        self.poses = poses;
        Ok(solved)
    }

    fn check(&self) -> Result<(), PoseGraphError> {
        let measured = self.edges.iter().map(|edge| &edge.measured);
        let is_known = |edge: &Constraint| edge.information.iter().all(|value| value.is_finite());
        if !self.poses.iter().chain(measured).all(is_finite_pose) || !self.edges.iter().all(is_known) {
            return Err(PoseGraphError::NotFinite);
        }
        let poses = self.poses.len();
        let wrong = self.edges.iter().position(|edge| edge.from == edge.to || edge.from.max(edge.to) >= poses);
        wrong.map_or(Ok(()), |edge| {
            let Constraint { from, to, .. } = self.edges[edge];
            Err(PoseGraphError::NoSuchPose { edge, from, to, poses })
        })
    }

    fn error_at(&self, poses: &[Isometry2<f64>]) -> f64 {
        let of_edge = |edge: &Constraint| {
            let error = edge.error(&poses[edge.from], &poses[edge.to]);
            error.dot(&(edge.information * error))
        };
        self.edges.iter().map(of_edge).sum()
    }

    /// The step Δ with (H + damping · diag H) Δ = -b, three entries for each pose but the first.
    fn step(&self, poses: &[Isometry2<f64>], damping: f64) -> Result<Vec<f64>, PoseGraphError> {
        let unknowns = 3 * (poses.len() - 1);
        let mut triplets = Vec::with_capacity(36 * self.edges.len());
        let mut right = faer::Col::<f64>::zeros(unknowns);
        for edge in &self.edges {
            let (from, to) = (&poses[edge.from], &poses[edge.to]);
            let error = edge.error(from, to);
            let blocks = [edge.from, edge.to].into_iter().zip(edge.jacobians(from, to));
            for (row_pose, by_row) in blocks.clone() {
                let Some(row) = row_pose.checked_sub(1).map(|free| 3 * free) else { continue };
                let weighted = by_row.transpose() * edge.information;
                let gradient = weighted * error;
                (0..3).for_each(|i| right[row + i] -= gradient[i]);
                for (column_pose, by_column) in blocks.clone() {
                    let Some(column) = column_pose.checked_sub(1).map(|free| 3 * free) else { continue };
                    let block = weighted * by_column;
                    for (j, i) in (0..3).flat_map(|j| (0..3).map(move |i| (j, i))) {
                        let damped = if row + i == column + j { 1.0 + damping } else { 1.0 };
                        triplets.push(Triplet::new(row + i, column + j, block[(i, j)] * damped));
                    }
                }
            }
        }
        let hessian = SparseColMat::<usize, f64>::try_new_from_triplets(unknowns, unknowns, &triplets);
        let hessian = hessian.map_err(|_| PoseGraphError::Undetermined)?;
        let factor = hessian.sp_cholesky(Side::Lower).map_err(|_| PoseGraphError::Undetermined)?;
        let step: Vec<f64> = factor.solve(&right).iter().copied().collect();
        if step.iter().all(|part| part.is_finite()) { Ok(step) } else { Err(PoseGraphError::Undetermined) }
    }
}

fn moved(poses: &[Isometry2<f64>], step: &[f64]) -> Vec<Isometry2<f64>> {
    let free = poses[1..].iter().zip(step.chunks_exact(3)).map(|(pose, step)| {
        let position_m = pose.translation.vector + Vector2::new(step[0], step[1]);
        Isometry2::new(position_m, pose.rotation.angle() + step[2])
    });
    poses[..1].iter().copied().chain(free).collect()
}
