//! What follows a full decomposition: the count of zeros and U.

use crosscut_stage::{Spectrum, StageError};
use faer::Mat;

use crate::zeros::count_zeros;

/// Counts the zeros among `out.eigenvalues` (all n, ascending), those below `tolerance`, and makes U of the k eigenvectors that belong to them.
///
/// `eigenvector(j)` gives the n entries of the unit eigenvector of λ_j.
pub(crate) fn embed<'a>(
    tolerance: f64,
    eigenvector: impl Fn(usize) -> &'a [f64],
    out: &mut Spectrum,
) -> Result<(), StageError> {
    let n = out.eigenvalues.len();
    if !out.eigenvalues.iter().all(|eigenvalue| eigenvalue.is_finite()) {
        return Err(StageError::NoConvergence { n });
    }
    count_zeros(out, n, tolerance);
    out.u.resize_with(n, out.k, |_, _| 0.0);
    for j in 0..out.k {
        let column = eigenvector(j);
        let sign = sign_of_largest(column);
        for (u, v) in out.u.col_as_slice_mut(j).iter_mut().zip(column) {
            *u = sign * v;
        }
    }
    Ok(())
}

/// Makes `u` a matrix of zeros in the memory that it has.
pub(crate) fn make_zero(u: &mut Mat<f64>, nrows: usize, ncols: usize) {
    u.resize_with(nrows, ncols, |_, _| 0.0);
    u.fill(0.0);
}

/// The sign of the entry of largest magnitude, the first of equals.
pub(crate) fn sign_of_largest(vector: &[f64]) -> f64 {
    let largest = vector.iter().fold(0.0f64, |largest, &x| if x.abs() > largest.abs() { x } else { largest });
    1.0f64.copysign(largest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_entry_of_largest_magnitude_decides_the_sign() {
        assert_eq!(sign_of_largest(&[0.1, -0.7, 0.7]), -1.0);
        assert_eq!(sign_of_largest(&[0.1, 0.7, -0.7]), 1.0);
        assert_eq!(sign_of_largest(&[0.0, 0.0]), 1.0);
    }
}
