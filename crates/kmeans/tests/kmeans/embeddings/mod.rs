//! Arbitrary embeddings.

use std::ops::Range;

use crosscut_stage::Spectrum;
use faer::Mat;
use proptest::collection::vec;
use proptest::prelude::Strategy;

/// The spectrum with this U.
pub(crate) fn spectrum(u: Mat<f64>) -> Spectrum {
    Spectrum { k: u.ncols(), u, ..Spectrum::default() }
}

/// Any U with 1 to 4 columns.
pub(crate) fn arbitrary(n: Range<usize>) -> impl Strategy<Value = Spectrum> {
    (vec([-1.0..1.0f64, -1.0..1.0f64, -1.0..1.0f64, -1.0..1.0f64], n), 1..5usize)
        .prop_map(|(rows, k)| spectrum(Mat::from_fn(rows.len(), k, |i, j| rows[i][j])))
}
