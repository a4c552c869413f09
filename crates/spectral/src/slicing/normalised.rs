//! The Laplacian of a dense W that is not formed.

use crosscut_stage::{Affinity, StageError};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};

use crate::degrees::check_degrees;

/// W, n×n, and D, of which L = I - D^-1/2 W D^-1/2 is made, the paper's equation (2).
pub(crate) struct Normalised<'a> {
    pub(crate) w: &'a Mat<f64>,
    pub(crate) degrees: &'a [f64],
    /// The diagonal of D^-1/2.
    pub(crate) scale: Vec<f64>,
}

impl<'a> Normalised<'a> {
    /// L of `affinity`, whose dense weights are `w`.
    ///
    /// # Errors
    /// When a degree is not finite or not above 0.
    pub(crate) fn new(affinity: &'a Affinity, w: &'a Mat<f64>) -> Result<Self, StageError> {
        check_degrees(affinity)?;
        let scale = affinity.degrees.iter().map(|degree| degree.sqrt().recip()).collect();
        Ok(Self { w, degrees: &affinity.degrees, scale })
    }

    /// # Errors
    /// When a weight is not finite.
    pub(crate) fn check_finite(&self) -> Result<(), StageError> {
        let finite = |&j: &usize| self.w.col_as_slice(j).iter().all(|weight| weight.is_finite());
        match (0..self.w.ncols()).find(|j| !finite(j)) {
            Some(index) => Err(StageError::NotFinite { what: "the affinity", index }),
            None => Ok(()),
        }
    }

    /// L of some returns alone.
    pub(crate) fn form(&self, members: &[u32]) -> Mat<f64> {
        Mat::from_fn(members.len(), members.len(), |row, column| {
            let [i, j] = [row, column].map(|at| members[at] as usize);
            f64::from(u8::from(i == j)) - self.w[(i, j)] * (self.scale[i] * self.scale[j])
        })
    }

    /// L x of some returns alone, those of the rows of x.
    pub(crate) fn times(&self, members: &[u32], x: &Mat<f64>) -> Mat<f64> {
        let start = members.iter().min().map_or(0, |&first| first as usize);
        let n = members.iter().max().map_or(0, |&last| last as usize + 1 - start);
        let mut scaled = Mat::zeros(n, x.ncols());
        for j in 0..x.ncols() {
            let scaled = scaled.col_as_slice_mut(j);
            members
                .iter()
                .zip(x.col_as_slice(j))
                .for_each(|(&i, x)| scaled[i as usize - start] = self.scale[i as usize] * x);
        }
        let image = product(self.w.submatrix(start, start, n, n), scaled.as_ref());
        let mut out = x.clone();
        for j in 0..x.ncols() {
            let (out, image) = (out.col_as_slice_mut(j), image.col_as_slice(j));
            members.iter().zip(out).for_each(|(&i, out)| *out -= self.scale[i as usize] * image[i as usize - start]);
        }
        out
    }
}

/// a b.
pub(crate) fn product(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> Mat<f64> {
    let mut out = Mat::zeros(a.nrows(), b.ncols());
    matmul(out.as_mut(), Accum::Replace, a, b, 1.0, Par::Seq);
    out
}
