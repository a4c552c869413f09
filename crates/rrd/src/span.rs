//! Eigenvectors compared by what they span.
//!
//! Single eigenvectors of a repeated zero are not unique: another machine may give U Q with any orthogonal Q. Their
//! span is unique, and so is what follows from it: the inner products of the centroids, which are rows of the same
//! space.

use faer::Mat;
use faer::linalg::solvers::SolveLstsq as _;

use crate::schema;
use crate::value::{Array, Numbers};

/// The rounding of U in the recording, as a share of its largest entry: half a unit of f16 in each of the two, and as
/// much again for its effect on the projection.
const ROUNDING_OF_F16: f64 = 1.0 / 512.0;

/// How two arrays of the same shape differ apart from a rotation; `None` if they are no eigenvectors.
pub(crate) fn difference(a: &Array, b: &Array, tolerance: f64) -> Option<Result<(), String>> {
    let (off, allowed, what) = if is(a, b, schema::SPECTRAL_U.dims) {
        let rounded = matches!(a.numbers, Numbers::F32(_)) || matches!(b.numbers, Numbers::F32(_));
        let rounding = if rounded { ROUNDING_OF_F16 * matrix(a).norm_max() } else { 0.0 };
        (distance_from_span(&matrix(a), &matrix(b)), tolerance.max(rounding), "the span")
    } else if is(a, b, schema::KMEANS_CENTROIDS.dims) {
        let gram = |array| matrix(array) * matrix(array).transpose();
        (largest(&(gram(a) - gram(b))), tolerance, "inner products")
    } else {
        return None;
    };
    Some(if off <= allowed { Ok(()) } else { Err(format!("{what} by {off:.1e} at most")) })
}

fn is(a: &Array, b: &Array, dims: &[&str]) -> bool {
    a.dims == dims && b.dims == dims
}

/// The largest entry of A - B X, for the X of least squares: 0 where the columns of A lie in the span of those of B.
/// Both have the same number of columns, so the spans are then equal.
fn distance_from_span(a: &Mat<f64>, b: &Mat<f64>) -> f64 {
    if a.ncols() == 0 || a.nrows() < a.ncols() {
        return largest(&(a - b));
    }
    largest(&(a - b * b.qr().solve_lstsq(a)))
}

/// The largest absolute value; infinite if an entry is NaN.
fn largest(m: &Mat<f64>) -> f64 {
    let values = m.col_iter().flat_map(|column| column.iter().copied());
    values.map(|x| if x.is_nan() { f64::INFINITY } else { x.abs() }).fold(0.0, f64::max)
}

fn matrix(array: &Array) -> Mat<f64> {
    let values = array.to_f64();
    Mat::from_fn(array.shape[0], array.shape[1], |i, j| values[i * array.shape[1] + j])
}
