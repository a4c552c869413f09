//! Which stages there are, by name.

use crosscut_stage::{AffinityStage, Kind, KmeansStage, SpectralStage};

/// The stages that a configuration can choose from.
///
/// Append a stage of your own and it can be chosen by its name like any other:
///
/// ```
/// use crosscut_pipeline::Registry;
/// use crosscut_stage::{Affinity, AffinityStage, Kind, Notes, Revolution, StageError};
///
/// struct Alone;
///
/// impl AffinityStage for Alone {
///     fn affinity(&mut self, r: &Revolution, out: &mut Affinity, _: &mut Notes) -> Result<(), StageError> {
///         let w = out.weights.make_dense(r.len());
///         w.fill(0.0);
///         w.diagonal_mut().fill(1.0);
///         out.degrees = vec![1.0; r.len()];
///         Ok(())
///     }
///
///     fn memory_bytes(&self, n: usize) -> u64 {
///         (n * n * 8) as u64
///     }
/// }
///
/// let mut registry = Registry::standard();
/// registry.affinity.push(Kind { name: "alone", doc: "every return on its own", params: &[], build: |_| Box::new(Alone) });
/// ```
#[derive(Clone)]
pub struct Registry {
    /// First stage: W.
    pub affinity: Vec<Kind<dyn AffinityStage>>,
    /// Second stage: eigenvalues and embedding.
    pub spectral: Vec<Kind<dyn SpectralStage>>,
    /// Third stage: clusters.
    pub kmeans: Vec<Kind<dyn KmeansStage>>,
}

impl Registry {
    /// All stages that crosscut ships.
    pub fn standard() -> Self {
        Self {
            affinity: crosscut_affinity::KINDS.to_vec(),
            spectral: crosscut_spectral::KINDS.to_vec(),
            kmeans: crosscut_kmeans::KINDS.to_vec(),
        }
    }
}
