//! `faer`: the full self-adjoint decomposition of the faer library.
//!
//! Every eigenvalue and eigenvector of L. Memory is kept from one revolution to the next.

use crosscut_stage::{Affinity, Eigenvalues, Kind, Notes, SpectralStage, Spectrum, StageError};

use crate::decomposition::Decomposition;
use crate::embedding::sign_of_largest;
use crate::laplacian::Laplacian;
use crate::zeros::{ZERO_TOLERANCE, count_zeros};

/// The full decomposition, against which the other solvers are checked.
pub const KIND: Kind<dyn SpectralStage> =
    Kind::spectral("faer", "all eigenvalues by the full decomposition of the dense Laplacian", |params| {
        Box::new(FaerEvd::new(params.get(ZERO_TOLERANCE)))
    })
    .params(&[ZERO_TOLERANCE.spec])
    .eigenvalues(Eigenvalues::All);

pub(crate) struct FaerEvd {
    tolerance: f64,
    laplacian: Laplacian,
    decomposition: Decomposition,
}

impl FaerEvd {
    pub(crate) fn new(tolerance: f64) -> Self {
        Self { tolerance, laplacian: Laplacian::default(), decomposition: Decomposition::default() }
    }
}

impl SpectralStage for FaerEvd {
    fn spectrum(&mut self, affinity: &Affinity, out: &mut Spectrum, _: &mut Notes) -> Result<(), StageError> {
        self.decomposition.decompose(self.laplacian.form(affinity)?, &mut out.eigenvalues)?;
        let n = out.eigenvalues.len();
        count_zeros(out, n, self.tolerance);
        out.u.resize_with(n, out.k, |_, _| 0.0);
        for j in 0..out.k {
            let column = self.decomposition.eigenvector(j);
            let sign = sign_of_largest(column);
            out.u.col_as_slice_mut(j).iter_mut().zip(column).for_each(|(u, v)| *u = sign * v);
        }
        Ok(())
    }
}
