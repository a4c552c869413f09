//! `nalgebra`: the full symmetric decomposition of the nalgebra library, a second opinion on `faer`.
//!
//! Householder tridiagonalisation, then implicit QR with Wilkinson shifts. The library takes its matrix by value, so that
//! memory is allocated again for each revolution.

use crosscut_stage::{Affinity, Eigenvalues, Kind, Notes, SpectralStage, Spectrum, StageError};
use faer::MatRef;
use nalgebra::{DMatrix, Dyn, SymmetricEigen};

use crate::decomposition::without_negligible;
use crate::embedding::embed;
use crate::laplacian::{Laplacian, dense_bytes};
use crate::zero_rule::{ZERO_TOLERANCE, ZeroRule};

/// Implicit QR takes two or three iterations an eigenvalue; LAPACK gives up after 30.
const ITERATIONS_PER_EIGENVALUE: usize = 30;

/// The solver that checks the others.
pub const KIND: Kind<dyn SpectralStage> = Kind::spectral(
    "nalgebra",
    "all eigenvalues, by a decomposition that shares no code with `faer`: slower, to check it by",
    |params| Box::new(NalgebraEvd { rule: ZeroRule::of(params), laplacian: Laplacian::default() }),
)
.params(&[ZERO_TOLERANCE.spec])
.eigenvalues(Eigenvalues::All);

struct NalgebraEvd {
    rule: ZeroRule,
    laplacian: Laplacian,
}

impl SpectralStage for NalgebraEvd {
    fn spectrum(&mut self, affinity: &Affinity, out: &mut Spectrum, _: &mut Notes) -> Result<(), StageError> {
        let laplacian = self.laplacian.form(affinity)?;
        let n = laplacian.nrows();
        out.eigenvalues.clear();
        if n == 0 {
            return embed(self.rule, |_| &[], out);
        }
        let evd = decompose(laplacian)
            .or_else(|| decompose(without_negligible(laplacian).as_ref()))
            .ok_or(StageError::NoConvergence { n })?;
        let mut order: Vec<usize> = (0..n).collect();
        order.sort_by(|&a, &b| evd.eigenvalues[a].total_cmp(&evd.eigenvalues[b]));
        out.eigenvalues.extend(order.iter().map(|&j| evd.eigenvalues[j]));
        let entries = evd.eigenvectors.as_slice();
        embed(self.rule, |j| &entries[order[j] * n..][..n], out)
    }

    fn memory_bytes(&self, n: usize, _: usize) -> u64 {
        // L, the copy that is tridiagonalised in place, and the eigenvectors.
        dense_bytes(n).saturating_mul(3)
    }
}

/// The decomposition; `None` where it does not converge, or to NaN.
fn decompose(matrix: MatRef<'_, f64>) -> Option<SymmetricEigen<f64, Dyn>> {
    let n = matrix.nrows();
    let matrix = DMatrix::from_fn(n, n, |i, j| matrix[(i, j)]);
    let evd = SymmetricEigen::try_new(matrix, f64::EPSILON, ITERATIONS_PER_EIGENVALUE * n)?;
    evd.eigenvalues.iter().chain(&evd.eigenvectors).all(|x| x.is_finite()).then_some(evd)
}
