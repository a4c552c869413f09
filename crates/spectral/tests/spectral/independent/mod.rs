//! A full decomposition that shares no code with the solvers: nalgebra's Householder tridiagonalisation and implicit QR.

use crosscut_spectral::Laplacian;
use crosscut_stage::{Affinity, Spectrum};
use faer::Mat;
use nalgebra::{DMatrix, SymmetricEigen};

/// All n eigenvalues, k and U by the tolerance τ; no margin.
///
/// # Panics
/// When it does not converge.
pub(crate) fn spectrum(affinity: &Affinity, tolerance: f64) -> Spectrum {
    let mut laplacian = Laplacian::default();
    let l = laplacian.form(affinity).expect("a sound affinity");
    let n = l.nrows();
    if n == 0 {
        return Spectrum { tolerance, ..Spectrum::default() };
    }
    let matrix = DMatrix::from_fn(n, n, |i, j| l[(i, j)]);
    let evd = SymmetricEigen::try_new(matrix, f64::EPSILON, 30 * n).expect("it converges");
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&a, &b| evd.eigenvalues[a].total_cmp(&evd.eigenvalues[b]));
    let eigenvalues: Vec<f64> = order.iter().map(|&j| evd.eigenvalues[j]).collect();
    let k = eigenvalues.partition_point(|&eigenvalue| eigenvalue < tolerance).max(1);
    let u = Mat::from_fn(n, k, |i, j| evd.eigenvectors[(i, order[j])]);
    Spectrum { eigenvalues, tolerance, k, u, ..Spectrum::default() }
}
