//! W and the working memory of the solver are refused before they are allocated, if they would not fit.

use crosscut_stage::{Affinity, Params, SpectralStage, StageError, Storage};

use crate::Config;
use crate::config::MEMORY_MB;

const MB: u64 = 1 << 20;

impl Config {
    /// How much memory messages may take that wait for others: those that are read ahead, and those of chunks that overlap.
    pub fn waiting_bytes(&self) -> u64 {
        (self.params("pipeline").get(MEMORY_MB) as u64).saturating_mul(MB / 4)
    }
}

/// How much memory W and the solvers may take, and how many there are at a time.
#[derive(Clone, Debug)]
pub(crate) struct MemoryBudget {
    limit_mb: u64,
    frames: u64,
    workers: u64,
    /// How W is stored by the affinity with these parameters.
    w: (Storage, Params),
}

impl MemoryBudget {
    /// For an affinity that stores W so, and this many frames in flight and workers.
    pub(crate) fn new(config: &Config, storage: Storage, frames: usize, workers: usize) -> Self {
        Self {
            limit_mb: config.params("pipeline").get(MEMORY_MB) as u64,
            frames: frames as u64,
            workers: workers as u64,
            w: (storage, config.params("affinity").clone()),
        }
    }

    /// Whether W of n returns fits, once per frame.
    pub(crate) fn admit_affinity(&self, n: usize) -> Result<(), StageError> {
        let (storage, params) = &self.w;
        self.admit(n, self.frames.saturating_mul(storage.bytes(params, n)))
    }

    /// Whether the decomposition fits beside W, once per worker.
    pub(crate) fn admit_spectral(&self, stage: &dyn SpectralStage, affinity: &Affinity) -> Result<(), StageError> {
        let (n, stored) = (affinity.weights.n(), affinity.weights.stored());
        let held = self.frames.saturating_mul(affinity.weights.memory_bytes());
        self.admit(n, held.saturating_add(self.workers.saturating_mul(stage.memory_bytes(n, stored))))
    }

    fn admit(&self, n: usize, bytes: u64) -> Result<(), StageError> {
        let needed_mb = bytes.div_ceil(MB);
        if needed_mb <= self.limit_mb {
            return Ok(());
        }
        Err(StageError::TooLarge(format!(
            "{n} returns would need {needed_mb} MB ({} frames in flight, {} workers), pipeline.memory_mb is {}; raise it, \
             lower pipeline.in_flight or pipeline.workers, or choose an affinity with few edges, such as \"passage\", and \
             spectral.kind = \"blocks\" or \"components\"",
            self.frames, self.workers, self.limit_mb
        )))
    }
}
