//! A stage that can be chosen by name.

use crate::{AffinityStage, KmeansStage, ParamSpec, Params, SpectralStage};

/// One way to do a stage: its name in the configuration, its parameters, and how to build it.
pub struct Kind<S: ?Sized> {
    /// The name, as in `affinity.kind = "rbf"`.
    pub name: &'static str,
    /// What it does, in one line.
    pub doc: &'static str,
    /// Its parameters.
    pub params: &'static [ParamSpec],
    /// Builds it from checked parameters.
    pub build: fn(&Params) -> Box<S>,
}

impl<S: ?Sized> Clone for Kind<S> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<S: ?Sized> Copy for Kind<S> {}

/// Stages that the registry holds by name.
pub trait StageKind {
    /// The section of the configuration, which is the name of the step.
    const SECTION: &'static str;
}

impl StageKind for dyn AffinityStage {
    const SECTION: &'static str = "affinity";
}

impl StageKind for dyn SpectralStage {
    const SECTION: &'static str = "spectral";
}

impl StageKind for dyn KmeansStage {
    const SECTION: &'static str = "kmeans";
}
