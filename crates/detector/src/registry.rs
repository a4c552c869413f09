//! The stages that can be chosen, by name.

use crosscut_stage::{AffinityStage, Kind, KmeansStage, SpectralStage};

/// The stages that a configuration can choose from.
///
/// Append a stage of your own under a new name, and it is chosen by this name like any other:
///
/// ```
/// use crosscut_detector::Registry;
/// use crosscut_stage::{Affinity, AffinityStage, Kind, Notes, Revolution, StageError};
///
/// struct Alone;
///
/// const ALONE: Kind<dyn AffinityStage> =
///     Kind::affinity("alone", "every return on its own", |_| Box::new(Alone));
///
/// impl AffinityStage for Alone {
///     fn weigh(&mut self, r: &Revolution, out: &mut Affinity, _: &mut Notes) -> Result<(), StageError> {
///         let w = out.weights.make_sparse();
///         (0..r.len() as u32).for_each(|i| w.push_row(&[i], &[1.0]));
///         Ok(())
///     }
/// }
///
/// let mut registry = Registry::standard();
/// registry.affinity.push(ALONE);
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
