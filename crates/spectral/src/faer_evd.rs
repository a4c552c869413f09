//! `faer`: the full self-adjoint decomposition of the faer library.

use crosscut_stage::{Affinity, Kind, Notes, ParamError, SpectralStage, Spectrum, StageError};

use crate::decomposition::Decomposition;
use crate::embedding::embed;
use crate::laplacian::{Laplacian, dense_bytes};
use crate::zero_rule::{ZERO_TOLERANCE, ZeroRule};

pub(crate) const KIND: Kind<dyn SpectralStage> = Kind {
    name: "faer",
    doc: "all eigenvalues by the full decomposition of the dense Laplacian, as in the paper",
    params: &[ZERO_TOLERANCE],
    build: |params| Box::new(FaerEvd::with(ZeroRule::of(params))),
};

/// Every eigenvalue and eigenvector of L. Memory is kept from one revolution to the next.
pub struct FaerEvd {
    rule: ZeroRule,
    laplacian: Laplacian,
    decomposition: Decomposition,
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
        Self { rule, laplacian: Laplacian::default(), decomposition: Decomposition::default() }
    }
}

impl SpectralStage for FaerEvd {
    fn spectrum(&mut self, affinity: &Affinity, out: &mut Spectrum, _: &mut Notes) -> Result<(), StageError> {
        self.decomposition.decompose(self.laplacian.form(affinity)?, &mut out.eigenvalues)?;
        embed(self.rule, |j| self.decomposition.eigenvector(j), out)
    }

    fn memory_bytes(&self, n: usize, _: usize) -> u64 {
        // L, and what its decomposition takes.
        dense_bytes(n).saturating_add(Decomposition::memory_bytes(n))
    }
}
