//! A stage that can be chosen by name, and its properties, which are known before it is built.

use crate::{AffinityStage, Invariance, KmeansStage, ParamError, ParamSpec, Params, SpectralStage, Value};

/// One way to do a stage: its name in the configuration, its parameters, its properties, and how to build it.
///
/// A constant beside the stage declares it, and a line in the list of kinds makes it known:
///
/// ```
/// use crosscut_stage::{Affinity, AffinityStage, Invariance, Kind, Notes, Revolution, StageError};
///
/// /// Every return on its own: W = I.
/// struct Alone;
///
/// const KIND: Kind<dyn AffinityStage> =
///     Kind::affinity("alone", "every return on its own", |_| Box::new(Alone));
///
/// impl AffinityStage for Alone {
///     fn weigh(&mut self, revolution: &Revolution, out: &mut Affinity, _: &mut Notes) -> Result<(), StageError> {
///         let w = out.weights.make_sparse();
///         (0..revolution.len() as u32).for_each(|i| w.push_row(&[i], &[1.0]));
///         Ok(())
///     }
/// }
/// ```
pub struct Kind<S: StageKind + ?Sized> {
    /// The name, as in `affinity.kind = "rbf"`.
    pub name: &'static str,
    /// What it does, in one line.
    pub doc: &'static str,
    /// Its parameters.
    pub params: &'static [ParamSpec],
    /// Its properties, known before it is built.
    pub properties: S::Properties,
    build: fn(&Params) -> Box<S>,
}

impl<S: StageKind + ?Sized> Kind<S> {
    const fn new(name: &'static str, doc: &'static str, build: fn(&Params) -> Box<S>) -> Self {
        Self { name, doc, params: &[], properties: S::DEFAULT, build }
    }

    /// Its parameters, in the order in which the configuration prints them.
    pub const fn params(mut self, params: &'static [ParamSpec]) -> Self {
        self.params = params;
        self
    }

    /// Builds the stage from checked values of its parameters.
    pub fn build(&self, params: &Params) -> Box<S> {
        (self.build)(params)
    }

    /// Builds the stage with these values, by name; the other parameters have their defaults.
    ///
    /// # Errors
    /// When there is no parameter of a name, or its value is not allowed.
    pub fn with(&self, values: &[(&str, Value)]) -> Result<Box<S>, ParamError> {
        let mut params = Params::defaults(self.params);
        values.iter().try_for_each(|(name, value)| params.set(name, value.clone()))?;
        Ok(self.build(&params))
    }
}

impl<S: StageKind + ?Sized> Clone for Kind<S> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<S: StageKind + ?Sized> Copy for Kind<S> {}

/// A trait whose stages the registry holds by name.
pub trait StageKind {
    /// The section of the configuration, which is the name of the step.
    const SECTION: &'static str;
    /// The properties that a kind declares; the shared tests check them.
    type Properties: Copy + 'static;
    /// The properties of a kind that declares none.
    const DEFAULT: Self::Properties;
}

/// The properties that a kind of affinity declares.
#[derive(Clone, Copy, Debug)]
pub struct AffinityProperties {
    /// The affinity needs the beams of a sweep, and refuses points without any. Its W has few entries in a row.
    pub needs_beams: bool,
    /// The affinity takes the whole cloud where a message is one ([`Revolution::cloud_m`](crate::Revolution::cloud_m)). The rows
    /// of its W are directions ([`Dual`](crate::Dual)), at most a few thousand, with few entries in a row.
    pub takes_cloud: bool,
    /// Changes of a revolution that leave W alone.
    pub blind_to: &'static [Invariance],
}

impl StageKind for dyn AffinityStage {
    const SECTION: &'static str = "affinity";
    type Properties = AffinityProperties;
    const DEFAULT: AffinityProperties = AffinityProperties { needs_beams: false, takes_cloud: false, blind_to: &[] };
}

impl Kind<dyn AffinityStage> {
    /// A kind without parameters, built by `build` from checked values.
    pub const fn affinity(name: &'static str, doc: &'static str, build: fn(&Params) -> Box<dyn AffinityStage>) -> Self {
        Self::new(name, doc, build)
    }

    /// Makes the kind one that refuses points without beams.
    pub const fn needs_beams(mut self) -> Self {
        self.properties.needs_beams = true;
        self
    }

    /// Makes the kind one of directions, which takes the whole cloud.
    pub const fn takes_cloud(mut self) -> Self {
        self.properties.takes_cloud = true;
        self
    }

    /// Changes of a revolution that leave W alone.
    pub const fn blind_to(mut self, changes: &'static [Invariance]) -> Self {
        self.properties.blind_to = changes;
        self
    }
}

/// The properties that a kind of solver declares.
#[derive(Clone, Copy, Debug)]
pub struct SpectralProperties {
    /// Which eigenvalues it gives.
    pub eigenvalues: Eigenvalues,
    /// Never allocates an n×n matrix for a sparse W.
    pub stays_sparse: bool,
}

/// Which eigenvalues of the Laplacian a solver gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Eigenvalues {
    /// All n.
    All,
    /// The zeros, the next, and perhaps more.
    Lowest,
    /// The zeros alone, which are exact: those of the graph without weak edges. There is no margin.
    Zeros,
}

impl StageKind for dyn SpectralStage {
    const SECTION: &'static str = "spectral";
    type Properties = SpectralProperties;
    const DEFAULT: SpectralProperties = SpectralProperties { eigenvalues: Eigenvalues::Lowest, stays_sparse: false };
}

impl Kind<dyn SpectralStage> {
    /// A kind without parameters, built by `build` from checked values.
    pub const fn spectral(name: &'static str, doc: &'static str, build: fn(&Params) -> Box<dyn SpectralStage>) -> Self {
        Self::new(name, doc, build)
    }

    /// Which eigenvalues it gives; a kind that does not state it gives the zeros and the next.
    pub const fn eigenvalues(mut self, eigenvalues: Eigenvalues) -> Self {
        self.properties.eigenvalues = eigenvalues;
        self
    }

    /// Makes the kind one that never allocates an n×n matrix for a sparse W.
    pub const fn stays_sparse(mut self) -> Self {
        self.properties.stays_sparse = true;
        self
    }
}

impl StageKind for dyn KmeansStage {
    const SECTION: &'static str = "kmeans";
    type Properties = ();
    const DEFAULT: () = ();
}

impl Kind<dyn KmeansStage> {
    /// A kind without parameters, built by `build` from checked values.
    pub const fn kmeans(name: &'static str, doc: &'static str, build: fn(&Params) -> Box<dyn KmeansStage>) -> Self {
        Self::new(name, doc, build)
    }
}
