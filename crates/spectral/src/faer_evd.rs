//! `faer`: the full self-adjoint decomposition of the faer library.

use crosscut_stage::{Affinity, Kind, Notes, ParamError, SpectralStage, Spectrum, StageError};
use faer::diag::DiagMut;
use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::evd::{ComputeEigenvectors, self_adjoint_evd, self_adjoint_evd_scratch};
use faer::{Mat, Par, Spec};

use crate::embedding::embed;
use crate::laplacian::{Laplacian, dense_bytes};
use crate::zero_rule::{ZERO_TOLERANCE, ZeroRule};

pub(crate) const KIND: Kind<dyn SpectralStage> = Kind {
    name: "faer",
    doc: "all eigenvalues by the full decomposition of the dense Laplacian, as in the paper",
    params: &[ZERO_TOLERANCE],
    build: |params| Box::new(FaerEvd::with(ZeroRule::of(params))),
};

/// Householder tridiagonalisation, then divide and conquer (implicit QR below 128 returns), on one thread: the bits of
/// faer's eigenvectors depend on the number of threads. Memory is kept from one revolution to the next.
pub struct FaerEvd {
    rule: ZeroRule,
    laplacian: Laplacian,
    eigenvectors: Mat<f64>,
    scratch: MemBuffer,
}

impl FaerEvd {
    /// Takes as zero what `rule` says.
    ///
    /// # Errors
    /// When a number of the rule is out of range.
    pub fn new(rule: ZeroRule) -> Result<Self, ParamError> {
        rule.checked().map(Self::with)
    }

    pub(crate) fn with(rule: ZeroRule) -> Self {
        let scratch = MemBuffer::new(StackReq::empty());
        Self { rule, laplacian: Laplacian::default(), eigenvectors: Mat::new(), scratch }
    }
}

impl SpectralStage for FaerEvd {
    fn spectrum(&mut self, affinity: &Affinity, out: &mut Spectrum, _: &mut Notes) -> Result<(), StageError> {
        let laplacian = self.laplacian.form(affinity)?;
        let n = laplacian.nrows();
        out.eigenvalues.clear();
        out.eigenvalues.resize(n, 0.0);
        if n > 0 {
            self.eigenvectors.resize_with(n, n, |_, _| 0.0);
            let needed = scratch(n);
            if self.scratch.len() < needed.unaligned_bytes_required() {
                self.scratch = MemBuffer::new(needed);
            }
            self_adjoint_evd(
                laplacian,
                DiagMut::from_slice_mut(&mut out.eigenvalues),
                Some(self.eigenvectors.as_mut()),
                Par::Seq,
                MemStack::new(&mut self.scratch),
                Spec::default(),
            )
            .map_err(|_| StageError::NoConvergence { n })?;
        }
        embed(self.rule, |j| self.eigenvectors.col_as_slice(j), out)
    }

    fn memory_bytes(&self, n: usize) -> u64 {
        // faer adds without looking for overflow; what 2^28 returns would need is more than any machine has.
        let scratch_bytes = if n == 0 { 0 } else { scratch(n.min(1 << 28)).unaligned_bytes_required() as u64 };
        dense_bytes(n).saturating_mul(2).saturating_add(scratch_bytes)
    }
}

/// Working memory of one decomposition, n > 0.
fn scratch(n: usize) -> StackReq {
    self_adjoint_evd_scratch::<f64>(n, ComputeEigenvectors::Yes, Par::Seq, Spec::default())
}
