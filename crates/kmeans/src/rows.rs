//! U by rows: one point of Rᵏ per return.

use crosscut_stage::{Spectrum, StageError};
use faer::Mat;

/// Larger n·k² are refused: each restart takes up to ten times as many operations, which are minutes without an end by
/// Ctrl-C.
const MOST_OPERATIONS: u64 = 10_000_000_000;

/// n points of Rᵏ, one after the other, in a buffer that is used again.
#[derive(Clone, Debug, Default)]
pub(crate) struct Rows {
    values: Vec<f64>,
    n: usize,
    k: usize,
}

impl Rows {
    /// Takes the rows of U.
    ///
    /// # Errors
    /// When U has not k columns, has a value that is not finite, or would take too much time.
    pub(crate) fn copy_from(&mut self, spectrum: &Spectrum) -> Result<(), StageError> {
        check_columns(spectrum)?;
        let u = &spectrum.u;
        if !u.is_all_finite() {
            return Err(not_finite(u));
        }
        (self.n, self.k) = (u.nrows(), u.ncols());
        let numbers = (self.n as u64).saturating_mul(self.k as u64);
        let (bytes, operations) = (numbers.saturating_mul(8), numbers.saturating_mul(self.k as u64));
        if operations > MOST_OPERATIONS {
            return Err(StageError::TooLarge(format!(
                "k-means on {}x{} numbers of U would need {} MB and more than {:.0e} operations: kmeans \
                 `components` needs neither",
                self.n,
                self.k,
                bytes.div_ceil(1 << 20),
                operations as f64
            )));
        }
        self.values.clear();
        self.values.resize(self.n * self.k, 0.0);
        for i in 0..self.n {
            (0..self.k).for_each(|j| self.values[i * self.k + j] = u[(i, j)]);
        }
        Ok(())
    }

    /// Number of points, n.
    pub(crate) fn len(&self) -> usize {
        self.n
    }

    /// Their dimension, k.
    pub(crate) fn dimension(&self) -> usize {
        self.k
    }

    /// Point `i`.
    pub(crate) fn row(&self, i: usize) -> &[f64] {
        &self.values[i * self.k..][..self.k]
    }

    /// Every point; k > 0.
    pub(crate) fn iter(&self) -> impl ExactSizeIterator<Item = &[f64]> {
        self.values.chunks_exact(self.k)
    }
}

/// Whether U has k columns.
///
/// # Errors
/// When not.
pub(crate) fn check_columns(spectrum: &Spectrum) -> Result<(), StageError> {
    let (columns, k) = (spectrum.u.ncols(), spectrum.k);
    if columns == k {
        return Ok(());
    }
    Err(StageError::Mismatch(format!("U has {columns} columns, but k is {k}")))
}

/// Says which row of U has a value that is not finite.
pub(crate) fn not_finite(u: &Mat<f64>) -> StageError {
    let index = (0..u.nrows()).find(|&i| !u.row(i).is_all_finite()).unwrap_or_default();
    StageError::NotFinite { what: "the embedding U", index }
}

/// ‖a - b‖².
pub(crate) fn distance_squared(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| (x - y) * (x - y)).sum()
}
