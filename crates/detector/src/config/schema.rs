//! Which sections, kinds and parameters there are.

use crosscut_stage::{Count, Kind, ParamSpec, StageKind};

use crate::{Registry, recording};

pub(crate) const WORKERS: Count = Count::new("workers", "lanes", 0)
    .to(1024)
    .doc("revolutions worked on side by side; 0 = one per processor; at most in_flight; never changes a result");

pub(crate) const IN_FLIGHT: Count = Count::new("in_flight", "frames", 8)
    .from(1)
    .to(4096)
    .doc("frames in the pool: bounds memory and holds ingest back when stages are slower");

pub(crate) const MEMORY_MB: Count = Count::new("memory_mb", "MB", 4096)
    .from(1)
    .doc("if W and the working memory of the solver would need more, they are refused before they are allocated");

/// Section `pipeline` of the configuration.
const PIPELINE_PARAMS: &[ParamSpec] = &[WORKERS.spec, IN_FLIGHT.spec, MEMORY_MB.spec];

/// One section.
pub(super) struct Section {
    pub(super) name: &'static str,
    pub(super) body: Body,
}

/// What a section may hold.
pub(super) enum Body {
    /// Always the same parameters.
    Fixed(&'static [ParamSpec]),
    /// A `kind`, and the parameters of that kind. The first is the default.
    Kinds(Vec<Choice>),
}

/// One kind of a stage.
#[derive(Clone, Copy)]
pub(super) struct Choice {
    pub(super) name: &'static str,
    pub(super) doc: &'static str,
    pub(super) params: &'static [ParamSpec],
}

/// All sections: `ingest`, `csv`, `affinity`, `spectral`, `kmeans`, `report`, `vehicle`, `flight`, `pipeline`,
/// `recording`.
pub(super) fn sections(registry: &Registry) -> [Section; 10] {
    let fixed = |name, params| Section { name, body: Body::Fixed(params) };
    [
        fixed("ingest", crosscut_sensor::PARAMS),
        fixed("csv", crosscut_sensor::CSV_PARAMS),
        chosen(&registry.affinity),
        chosen(&registry.spectral),
        chosen(&registry.kmeans),
        fixed("report", crosscut_report::PARAMS),
        fixed("vehicle", crosscut_sensor::VEHICLE_PARAMS),
        fixed("flight", crosscut_flight::PARAMS),
        fixed("pipeline", PIPELINE_PARAMS),
        fixed("recording", recording::PARAMS),
    ]
}

fn chosen<S: StageKind + ?Sized>(kinds: &[Kind<S>]) -> Section {
    let choices = kinds.iter().map(|kind| Choice { name: kind.name, doc: kind.doc, params: kind.params });
    Section { name: S::SECTION, body: Body::Kinds(choices.collect()) }
}
