//! The full self-adjoint decomposition of the faer library, on one thread, in memory that is kept.

use std::hint::black_box;

use crosscut_stage::StageError;
use faer::diag::DiagMut;
use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::evd::{ComputeEigenvectors, self_adjoint_evd, self_adjoint_evd_scratch};
use faer::prelude::ReborrowMut;
use faer::traits::pulp::Arch;
use faer::{Mat, MatMut, MatRef, Par, Spec};

/// Smaller entries are negligible beside a Laplacian's rounding of 1e-16 and a tolerance of 1e-14.
const NEGLIGIBLE: f64 = 1e-30;

/// A matrix with 0 for negligible entries. Few returns, far from each other, have weights such as 1e-260, with which the QR
/// iteration of a full decomposition may not end, or end with NaN.
pub(crate) fn without_negligible(matrix: MatRef<'_, f64>) -> Mat<f64> {
    let entry = |x: f64| if x.abs() < NEGLIGIBLE { 0.0 } else { x };
    Mat::from_fn(matrix.nrows(), matrix.ncols(), |i, j| entry(matrix[(i, j)]))
}

/// Householder tridiagonalisation, then divide and conquer (implicit QR below 128 rows), on one thread: the bits of
/// faer's eigenvectors depend on the number of threads.
pub(crate) struct Decomposition {
    eigenvectors: Mat<f64>,
    scratch: MemBuffer,
}

impl Default for Decomposition {
    fn default() -> Self {
        Self { eigenvectors: Mat::new(), scratch: MemBuffer::new(StackReq::empty()) }
    }
}

impl Decomposition {
    /// Writes the n eigenvalues of a symmetric matrix, ascending, and keeps its eigenvectors.
    ///
    /// # Errors
    /// When it does not converge, or to NaN.
    pub(crate) fn decompose(&mut self, matrix: MatRef<'_, f64>, eigenvalues: &mut Vec<f64>) -> Result<(), StageError> {
        let n = matrix.nrows();
        self.eigenvectors.resize_with(n, n, |_, _| 0.0);
        evd(matrix, eigenvalues, Some(self.eigenvectors.as_mut()), &mut self.scratch)
    }

    /// Writes the n eigenvalues of a symmetric matrix, ascending, without its eigenvectors.
    ///
    /// # Errors
    /// When it does not converge, or to NaN.
    pub(crate) fn values(&mut self, matrix: MatRef<'_, f64>, eigenvalues: &mut Vec<f64>) -> Result<(), StageError> {
        evd(matrix, eigenvalues, None, &mut self.scratch)
    }

    /// The unit eigenvector of the eigenvalue at `j`.
    pub(crate) fn eigenvector(&self, j: usize) -> &[f64] {
        self.eigenvectors.col_as_slice(j)
    }
}

/// The eigenvalues of a symmetric matrix, and its eigenvectors if there is a place for them; makes `scratch` as large as
/// it has to be. Where it does not converge, it is repeated without negligible entries.
fn evd(
    matrix: MatRef<'_, f64>,
    eigenvalues: &mut Vec<f64>,
    mut eigenvectors: Option<MatMut<'_, f64>>,
    scratch: &mut MemBuffer,
) -> Result<(), StageError> {
    let n = matrix.nrows();
    eigenvalues.clear();
    eigenvalues.resize(n, 0.0);
    if n == 0 {
        return Ok(());
    }
    make_room(scratch, self_adjoint_evd_scratch::<f64>(n, ComputeEigenvectors::Yes, Par::Seq, Spec::default()));
    let mut converges = |matrix: MatRef<'_, f64>| {
        let (out, stack) = (DiagMut::from_slice_mut(eigenvalues), MemStack::new(scratch));
        let eigenvectors = eigenvectors.as_mut().map(MatMut::rb_mut);
        let done = self_adjoint_evd(matrix, out, eigenvectors, Par::Seq, stack, Spec::default());
        done.is_ok() && eigenvalues.iter().all(|eigenvalue| eigenvalue.is_finite())
    };
    let converged = converges(matrix) || converges(without_negligible(matrix).as_ref());
    clear_vector_registers();
    if converged { Ok(()) } else { Err(StageError::NoConvergence { n }) }
}

/// Ends what faer's products of matrices leave behind: the upper halves of the vector registers in use, with which code
/// for any x86-64 in the same thread, such as the next affinity, takes many times as long. A function that is compiled for
/// these registers clears them as it returns.
fn clear_vector_registers() {
    let halves = |numbers: [f64; 8]| numbers.map(|x| 0.5 * x);
    Arch::new().dispatch(|| black_box(halves(black_box([1.0; 8]))));
}

/// Makes `scratch` as large as it has to be.
pub(crate) fn make_room(scratch: &mut MemBuffer, needed: StackReq) {
    if scratch.len() < needed.size_bytes() {
        *scratch = MemBuffer::new(needed);
    }
}
