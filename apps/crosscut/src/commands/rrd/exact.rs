//! W, L, U and what follows from them in full precision, recomputed from the recorded scans with the recorded
//! configuration.

use std::path::Path;

use anyhow::Context;
use crosscut_detector::{Config, Engine, Layer, Registry};
use crosscut_rrd::schema::{self, Entity};
use crosscut_rrd::{Array, Latest, Numbers, Recording, Revolutions, Row, Rows, Value};
use crosscut_spectral::Laplacian;
use crosscut_stage::Frame;

use super::selection::Selection;
use crate::exit::UsageError;

/// Recomputed eigenvalues may differ from the recorded ones by this much: other machines round otherwise.
const ROUNDING: f64 = 1e-9;

/// Reads the values of an entity from a frame.
type ReadValues = fn(&Frame) -> anyhow::Result<Array>;

/// The entities that can be recomputed.
const ENTITIES: [(Entity, ReadValues); 7] = [
    (schema::SCAN_RETURNS, |frame| {
        let points = frame.revolution.points_m.iter().flat_map(|p| [p.x, p.y, p.z]);
        Ok(array([frame.revolution.len(), 3], ["return", "axis"], points.collect()))
    }),
    (schema::AFFINITY_W, |frame| {
        let n = frame.affinity.weights.n();
        let mut w = vec![0.0; n * n];
        frame.affinity.weights.for_each(|i, j, weight| w[i * n + j] = weight);
        Ok(array([n, n], ["row", "column"], w))
    }),
    (schema::AFFINITY_DEGREES, |frame| Ok(vector("return", frame.affinity.degrees.clone()))),
    (schema::SPECTRAL_L, |frame| {
        let n = frame.affinity.weights.n();
        let mut laplacian = Laplacian::default();
        let l = laplacian.form(&frame.affinity)?;
        Ok(array([n, n], ["row", "column"], (0..n * n).map(|at| l[(at / n, at % n)]).collect()))
    }),
    (schema::SPECTRAL_EIGENVALUES, |frame| Ok(vector("eigenvalue", frame.spectrum.eigenvalues.clone()))),
    (schema::SPECTRAL_U, |frame| {
        let u = &frame.spectrum.u;
        let rows = (0..u.nrows()).flat_map(|i| (0..u.ncols()).map(move |j| u[(i, j)]));
        Ok(array([u.nrows(), u.ncols()], ["return", "eigenvector"], rows.collect()))
    }),
    (schema::KMEANS_LABELS, |frame| {
        let labels = frame.partition.labels.iter().map(|label| label.map_or(-1, i64::from));
        let numbers = Numbers::I64(labels.collect());
        Ok(Array { shape: vec![numbers.len()], dims: vec!["return".to_owned()], numbers })
    }),
];

/// Whether the entity can be recomputed.
pub(super) fn is_recomputable(entity: &str) -> bool {
    ENTITIES.iter().any(|(known, _)| known.path == entity)
}

fn vector(dim: &str, values: Vec<f64>) -> Array {
    Array { shape: vec![values.len()], dims: vec![dim.to_owned()], numbers: Numbers::F64(values) }
}

fn array(shape: [usize; 2], dims: [&str; 2], values: Vec<f64>) -> Array {
    Array { shape: shape.to_vec(), dims: dims.map(str::to_owned).to_vec(), numbers: Numbers::F64(values) }
}

/// The recorded configuration and sensor, ready to recompute an entity.
pub(super) struct Recomputation<'a> {
    scans: Revolutions<'a>,
    engine: Engine,
    frame: Frame,
    read_values: ReadValues,
    eigenvalues: Latest<'a>,
}

impl<'a> Recomputation<'a> {
    /// Prepares to recompute `entity` with the recorded configuration.
    pub(super) fn new(recording: &'a Recording, entity: &str, registry: &Registry) -> anyhow::Result<Self> {
        let Some((_, read_values)) = ENTITIES.into_iter().find(|(known, _)| known.path == entity) else {
            let names = ENTITIES.map(|(known, _)| known.path).join(", ");
            return Err(UsageError(format!("{entity} cannot be recomputed; {names} can")).into());
        };
        let toml = recording.config_toml().context("the recording has no /config")?;
        let layer = Layer::recorded(Path::new("/config"), &toml)?;
        let config = Config::resolve(registry, &[layer]).context("it was recorded by another version of crosscut")?;
        Ok(Self {
            scans: recording.revolutions().context("the recording does not hold all of its scans: record it again")?,
            engine: Engine::new(&config, registry),
            frame: Frame::default(),
            read_values,
            eigenvalues: recording.latest(schema::SPECTRAL_EIGENVALUES),
        })
    }

    /// Calls `take` with the value at every selected revolution. Returns where eigenvalues disagree with the recording.
    pub(super) fn run(
        mut self,
        rows: Rows,
        selection: &Selection,
        mut take: impl FnMut(&Row, Value) -> anyhow::Result<()>,
    ) -> anyhow::Result<Vec<String>> {
        let mut lost = Vec::new();
        for row in rows {
            let row = row?;
            if selection.holds(&row) {
                lost.extend(self.process(&row)?);
                take(&row, Value::Numbers((self.read_values)(&self.frame)?))?;
            }
        }
        Ok(lost)
    }

    /// Runs all stages on a recorded revolution. Returns how its eigenvalues disagree with the recorded ones.
    fn process(&mut self, row: &Row) -> anyhow::Result<Option<String>> {
        let scan = loop {
            let scan = self.scans.next().context("the recording ends before its rows do")??;
            if scan.revolution.seq == row.revolution.cast_unsigned() {
                break scan;
            }
        };
        (self.frame.revolution, self.frame.notes) = (scan.revolution, scan.notes);
        self.engine.process(&mut self.frame)?;
        let recorded = self.eigenvalues.at(row.revolution)?.map(Value::to_f64).unwrap_or_default();
        Ok(disagreement(&recorded, &self.frame.spectrum.eigenvalues).map(|off| {
            format!(
                "revolution {}: recomputed eigenvalues are off by {off:.1e}: made by another version?",
                row.revolution
            )
        }))
    }
}

/// The largest distance of recorded from recomputed eigenvalues, if it is more than rounding.
fn disagreement(recorded: &[f64], recomputed: &[f64]) -> Option<f64> {
    if recorded.len() > recomputed.len() {
        return Some(f64::INFINITY);
    }
    let off = recorded.iter().zip(recomputed).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    (off > ROUNDING).then_some(off)
}
