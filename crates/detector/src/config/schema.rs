//! Which sections, kinds and parameters there are.

use crosscut_stage::{Count, Kind, ParamSpec, StageKind};

use super::error::ConfigError;
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

/// One section: its parameters, which are those of a kind where it has kinds, of which the first is the default.
pub(super) struct Section {
    pub(super) name: &'static str,
    pub(super) params: &'static [ParamSpec],
    pub(super) kinds: Vec<Choice>,
}

/// One kind of a stage.
#[derive(Clone, Copy, Debug)]
pub(super) struct Choice {
    pub(super) name: &'static str,
    pub(super) doc: &'static str,
    pub(super) params: &'static [ParamSpec],
}

/// All sections: `ingest`, `csv`, `affinity`, `spectral`, `kmeans`, `report`, `vehicle`, `flight`, `pipeline`,
/// `recording`.
///
/// # Errors
/// When the registry has no kind of a stage, or two of one name.
pub(super) fn sections(registry: &Registry) -> Result<[Section; 10], ConfigError> {
    let fixed = |name, params| Section { name, params, kinds: Vec::new() };
    Ok([
        fixed("ingest", crosscut_sensor::PARAMS),
        fixed("csv", crosscut_sensor::CSV_PARAMS),
        chosen(&registry.affinity)?,
        chosen(&registry.spectral)?,
        chosen(&registry.kmeans)?,
        fixed("report", crosscut_report::PARAMS),
        fixed("vehicle", crosscut_sensor::VEHICLE_PARAMS),
        fixed("flight", crosscut_flight::PARAMS),
        fixed("pipeline", PIPELINE_PARAMS),
        fixed("recording", recording::PARAMS),
    ])
}

fn chosen<S: StageKind + ?Sized>(kinds: &[Kind<S>]) -> Result<Section, ConfigError> {
    let section = S::SECTION;
    let first = kinds.first().ok_or(ConfigError::NoKinds { section })?;
    let is_twice = |(at, kind): &(usize, &Kind<S>)| kinds[..*at].iter().any(|other| other.name == kind.name);
    if let Some((_, kind)) = kinds.iter().enumerate().find(is_twice) {
        return Err(ConfigError::KindTwice { section, kind: kind.name });
    }
    let kinds = kinds.iter().map(|kind| Choice { name: kind.name, doc: kind.doc, params: kind.params });
    Ok(Section { name: section, params: first.params, kinds: kinds.collect() })
}
