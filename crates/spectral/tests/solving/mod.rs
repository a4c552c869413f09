//! A solver run on one graph.

use crosscut_stage::{Affinity, Notes, SpectralStage, Spectrum};

/// What `stage` finds, and how many notes it makes.
pub(crate) fn spectrum(stage: &mut dyn SpectralStage, affinity: &Affinity) -> (Spectrum, usize) {
    let (mut out, mut notes) = (Spectrum::default(), Notes::default());
    stage.spectrum(affinity, &mut out, &mut notes).expect("a sound affinity");
    (out, notes.iter().len())
}
