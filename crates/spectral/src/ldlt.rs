//! A dense symmetric matrix factorised at a shift.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::ldlt::{factor, solve};
use faer::{Mat, MatMut, MatRef, Par, Spec};

/// A - shift·I = M Δ Mᵀ without exchange of rows: M below its unit diagonal, Δ on it. For indefinite matrices this can be
/// inaccurate; what comes of it has to be checked.
#[derive(Clone, Debug)]
pub(crate) struct Ldlt {
    factor: Mat<f64>,
    shift: f64,
    negative: usize,
}

impl Default for Ldlt {
    fn default() -> Self {
        Self { factor: Mat::new(), shift: 0.0, negative: 0 }
    }
}

impl Ldlt {
    /// Factorises `matrix` - `shift`·I, of whose lower triangle alone it reads. `false` if a pivot is 0.
    pub(crate) fn factorise(&mut self, matrix: MatRef<'_, f64>, shift: f64) -> bool {
        let n = matrix.nrows();
        self.shift = shift;
        self.factor.resize_with(n, n, |_, _| 0.0);
        for j in 0..n {
            let lower = &mut self.factor.col_as_slice_mut(j)[j..];
            lower.copy_from_slice(&matrix.col(j).try_as_col_major().expect("stored by columns").as_slice()[j..]);
            lower[0] -= shift;
        }
        let scratch = factor::cholesky_in_place_scratch::<f64>(n, Par::Seq, Spec::default());
        let done = factor::cholesky_in_place(
            self.factor.as_mut(),
            factor::LdltRegularization::default(),
            Par::Seq,
            MemStack::new(&mut MemBuffer::new(scratch)),
            Spec::default(),
        );
        self.negative = (0..n).filter(|&i| self.factor[(i, i)] < 0.0).count();
        done.is_ok()
    }

    /// The shift of the last factorisation.
    pub(crate) fn shift(&self) -> f64 {
        self.shift
    }

    /// The number of eigenvalues below the shift, by Sylvester's law.
    pub(crate) fn below(&self) -> usize {
        self.negative
    }

    /// Solves (A - shift·I) X = `x` in place.
    pub(crate) fn solve(&self, x: MatMut<'_, f64>) {
        let nothing = &mut [];
        solve::solve_in_place(self.factor.as_ref(), self.factor.diagonal(), x, Par::Seq, MemStack::new(nothing));
    }
}
