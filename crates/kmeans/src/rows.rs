//! U by rows: one point of Rᵏ per return.

use crosscut_stage::{Spectrum, StageError};

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
    /// When U has not k columns, or has a value that is not finite.
    pub(crate) fn copy_from(&mut self, spectrum: &Spectrum) -> Result<(), StageError> {
        let (u, k) = (&spectrum.u, spectrum.k);
        if u.ncols() != k {
            return Err(StageError::Unsupported(format!("U has {} columns, but k is {k}", u.ncols())));
        }
        (self.n, self.k) = (u.nrows(), k);
        self.values.clear();
        for i in 0..self.n {
            self.values.extend((0..k).map(|j| u[(i, j)]));
        }
        match self.values.iter().position(|value| !value.is_finite()) {
            Some(at) => Err(StageError::NotFinite { what: "the embedding U", index: at / k }),
            None => Ok(()),
        }
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

    /// The variance of the points along an axis of Rᵏ, averaged over the axes; n and k > 0.
    pub(crate) fn mean_variance(&self) -> f64 {
        let (n, k) = (self.n as f64, self.k);
        let variance = |axis: usize| {
            let along = || self.values.iter().skip(axis).step_by(k);
            let mean = along().sum::<f64>() / n;
            along().map(|x| (x - mean).powi(2)).sum::<f64>() / n
        };
        (0..k).map(variance).sum::<f64>() / k as f64
    }
}

/// ‖a - b‖².
pub(crate) fn distance_squared(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| (x - y) * (x - y)).sum()
}
