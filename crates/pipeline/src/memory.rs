//! Sizes that would not fit are refused before they are allocated.

use crosscut_stage::{Affinity, AffinityStage, SpectralStage, StageError};

use crate::Config;

const MB: u64 = 1 << 20;

/// How much memory the matrices may take, and how many there are at a time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MemoryBudget {
    limit_mb: u64,
    frames: u64,
    workers: u64,
}

impl MemoryBudget {
    /// One frame, one worker.
    pub(crate) fn for_one(config: &Config) -> Self {
        Self::for_many(config, 1, 1)
    }

    /// So many frames in flight, so many workers.
    pub(crate) fn for_many(config: &Config, frames: usize, workers: usize) -> Self {
        let limit_mb = config.params("pipeline").count("memory_mb") as u64;
        Self { limit_mb, frames: frames as u64, workers: workers as u64 }
    }

    /// Whether W of n returns fits, once per frame.
    pub(crate) fn admit_affinity(&self, stage: &dyn AffinityStage, n: usize) -> Result<(), StageError> {
        self.admit(n, self.frames.saturating_mul(stage.memory_bytes(n)))
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
             lower pipeline.in_flight or pipeline.workers, or choose an affinity with fewer edges",
            self.frames, self.workers, self.limit_mb
        )))
    }
}
