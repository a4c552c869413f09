//! A revolution whose W and decomposition would not fit is refused before they are allocated.

use crosscut_spectral::MOST_MATRICES;
use crosscut_stage::StageError;

use crate::Config;
use crate::config::MEMORY_MB;

const MB: u64 = 1 << 20;

impl Config {
    /// How much memory messages may take that wait for others: those that are read ahead, and those of chunks that overlap.
    pub fn waiting_bytes(&self) -> u64 {
        (self.params("pipeline").get(MEMORY_MB) as u64).saturating_mul(MB / 4)
    }

    /// Whether as many dense n×n matrices fit as this many frames and workers may hold. W is dense in each frame unless
    /// `is_w_sparse`; a solver may have matrices of its own.
    pub(crate) fn admit(
        &self,
        n: usize,
        [frames, workers]: [usize; 2],
        is_w_sparse: bool,
        solver_has_matrices: bool,
    ) -> Result<(), StageError> {
        let of_frames = if is_w_sparse { 0 } else { frames as u64 };
        let of_workers = if solver_has_matrices { MOST_MATRICES * workers as u64 } else { 0 };
        let entries = (n as u64).saturating_mul(n as u64);
        let bytes = entries.saturating_mul(8).saturating_mul(of_frames + of_workers);
        let (needed_mb, limit_mb) = (bytes.div_ceil(MB), self.params("pipeline").get(MEMORY_MB) as u64);
        if needed_mb <= limit_mb {
            return Ok(());
        }
        Err(StageError::TooLarge(format!(
            "{n} returns would need {needed_mb} MB ({frames} frames in flight, {workers} workers), pipeline.memory_mb is \
             {limit_mb}; raise it, lower pipeline.in_flight or pipeline.workers, or choose an affinity with few edges, such as \
             \"passage\", and spectral.kind = \"blocks\" or \"components\""
        )))
    }
}
