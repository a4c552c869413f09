//! Which sections, kinds and parameters there are.

use crosscut_stage::{Kind, ParamSpec, Shape, StageKind};

use crate::Registry;

/// Section `pipeline` of the configuration.
pub const PIPELINE_PARAMS: &[ParamSpec] = &[
    ParamSpec {
        name: "workers",
        unit: "lanes",
        shape: Shape::Integer { default: 0, min: 0, max: 1024 },
        doc: "revolutions worked on side by side; 0 = one per processor; at most in_flight; never changes a result",
    },
    ParamSpec {
        name: "in_flight",
        unit: "frames",
        shape: Shape::Integer { default: 8, min: 1, max: 4096 },
        doc: "frames in the pool: bounds memory and holds ingest back when stages are slower",
    },
    ParamSpec {
        name: "memory_mb",
        unit: "MB",
        shape: Shape::Integer { default: 4096, min: 1, max: i64::MAX },
        doc: "matrices that would need more are refused before they are allocated",
    },
];

/// All sections of the configuration with what they may hold.
pub struct Schema {
    pub(super) sections: Vec<Section>,
}

/// One section.
pub(super) struct Section {
    pub(super) name: &'static str,
    pub(super) body: Body,
}

/// What a section may hold.
pub(super) enum Body {
    /// Always the same parameters.
    Fixed(&'static [ParamSpec]),
    /// A `kind`, and the parameters of that kind. The first is what is taken when nothing is said.
    Kinds(Vec<Choice>),
}

/// One kind of a stage.
#[derive(Clone, Copy)]
pub(super) struct Choice {
    pub(super) name: &'static str,
    pub(super) doc: &'static str,
    pub(super) params: &'static [ParamSpec],
}

impl Schema {
    /// The sections of the method: `affinity`, `spectral`, `kmeans`, `report`, `vehicle`, `pipeline`.
    pub fn new(registry: &Registry) -> Self {
        let fixed = |name, params| Section { name, body: Body::Fixed(params) };
        Self {
            sections: vec![
                chosen(&registry.affinity),
                chosen(&registry.spectral),
                chosen(&registry.kmeans),
                fixed("report", crosscut_report::PARAMS),
                fixed("vehicle", crosscut_report::VEHICLE_PARAMS),
                fixed("pipeline", PIPELINE_PARAMS),
            ],
        }
    }

    /// With one more section before the others, for what comes before the method.
    pub fn with_section(mut self, name: &'static str, params: &'static [ParamSpec]) -> Self {
        self.sections.insert(0, Section { name, body: Body::Fixed(params) });
        self
    }
}

fn chosen<S: StageKind + ?Sized>(kinds: &[Kind<S>]) -> Section {
    let choices = kinds.iter().map(|kind| Choice { name: kind.name, doc: kind.doc, params: kind.params });
    Section { name: S::SECTION, body: Body::Kinds(choices.collect()) }
}
