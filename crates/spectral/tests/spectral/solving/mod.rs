//! A solver run on one graph.

use crosscut_stage::{Affinity, Kind, Notes, SpectralStage, Spectrum};

/// A solver with this zero tolerance.
pub(crate) fn solver(kind: &Kind<dyn SpectralStage>, tolerance: f64) -> Box<dyn SpectralStage> {
    kind.with(&[("zero_tolerance", tolerance.into())]).expect("allowed")
}

/// What `stage` finds, and how many notes it makes.
pub(crate) fn spectrum(stage: &mut dyn SpectralStage, affinity: &Affinity) -> (Spectrum, usize) {
    let (mut out, mut notes) = (Spectrum::default(), Notes::default());
    stage.spectrum(affinity, &mut out, &mut notes).expect("a sound affinity");
    (out, notes.iter().len())
}
