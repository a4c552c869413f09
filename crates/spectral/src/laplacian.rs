//! The normalised Laplacian, the paper's equation (2).

use crosscut_stage::{Affinity, StageError};
use faer::{Mat, MatRef};

use crate::degrees::check_degrees;

/// Forms L = I - D^-1/2 W D^-1/2, dense, in a matrix that is used again the next time.
#[derive(Clone, Debug)]
pub struct Laplacian {
    matrix: Mat<f64>,
    /// The diagonal of D^-1/2.
    inverse_sqrt_degrees: Vec<f64>,
}

impl Default for Laplacian {
    fn default() -> Self {
        Self { matrix: Mat::new(), inverse_sqrt_degrees: Vec::new() }
    }
}

impl Laplacian {
    /// L of `affinity`, n×n, exactly symmetric if W is; the same bits for dense and sparse weights.
    ///
    /// # Errors
    /// When a degree is not above 0, or a value is not finite.
    pub fn form(&mut self, affinity: &Affinity) -> Result<MatRef<'_, f64>, StageError> {
        let n = affinity.weights.n();
        check_degrees(affinity)?;
        self.inverse_sqrt_degrees.clear();
        self.inverse_sqrt_degrees.extend(affinity.degrees.iter().map(|degree| degree.sqrt().recip()));
        self.matrix.resize_with(n, n, |_, _| 0.0);
        let scale = &self.inverse_sqrt_degrees;
        // s_i s_j is formed first: it is the same number for (i, j) and (j, i), so symmetry survives the rounding.
        let entry = |i: usize, j: usize, weight: f64| f64::from(u8::from(i == j)) - weight * (scale[i] * scale[j]);
        self.matrix.fill(0.0);
        self.matrix.diagonal_mut().fill(1.0);
        affinity.weights.for_each(|i, j, weight| self.matrix[(i, j)] = entry(i, j, weight));
        match (0..n).find(|&j| !self.matrix.col_as_slice(j).iter().all(|l| l.is_finite())) {
            Some(index) => Err(StageError::NotFinite { what: "the affinity", index }),
            None => Ok(self.matrix.as_ref()),
        }
    }
}
