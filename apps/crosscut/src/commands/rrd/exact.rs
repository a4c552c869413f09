//! W, L, U and what follows from them in full precision: the recorded ranges once more through the recorded
//! configuration.

use std::iter::Peekable;
use std::path::Path;

use anyhow::{Context, bail};
use crosscut_ingest::{Sensor, UPSIDE_DOWN};
use crosscut_messages::{Header, LaserScan, Time};
use crosscut_pipeline::{Config, Engine, Layer, Registry};
use crosscut_recorder::{Array, Numbers, ReadError, Recording, Row, Rows, Value};
use crosscut_spectral::Laplacian;
use crosscut_stage::{Frame, wrap_angle_rad};

use super::selection::Selection;
use crate::exit::UsageError;

/// Recomputed eigenvalues may differ from the recorded ones by this much: other machines round otherwise.
const ROUNDING: f64 = 1e-9;

/// A part of a frame as numbers.
type Part = fn(&Frame) -> anyhow::Result<Array>;

/// What can be recomputed: the entity, and the part of a frame that it is.
const ENTITIES: [(&str, Part); 7] = [
    ("/scan/returns", |frame| {
        let points = frame.revolution.points_m.iter().flat_map(|p| [p.x, p.y, p.z]);
        Ok(array([frame.revolution.len(), 3], ["return", "axis"], points.collect()))
    }),
    ("/affinity/W", |frame| {
        let n = frame.affinity.weights.n();
        let mut w = vec![0.0; n * n];
        frame.affinity.weights.for_each(|i, j, weight| w[i * n + j] = weight);
        Ok(array([n, n], ["row", "column"], w))
    }),
    ("/affinity/degrees", |frame| Ok(vector("return", frame.affinity.degrees.clone()))),
    ("/spectral/L", |frame| {
        let n = frame.affinity.weights.n();
        let mut laplacian = Laplacian::default();
        let l = laplacian.form(&frame.affinity)?;
        Ok(array([n, n], ["row", "column"], (0..n * n).map(|at| l[(at / n, at % n)]).collect()))
    }),
    ("/spectral/eigenvalues", |frame| Ok(vector("eigenvalue", frame.spectrum.eigenvalues.clone()))),
    ("/spectral/U", |frame| {
        let u = &frame.spectrum.u;
        let rows = (0..u.nrows()).flat_map(|i| (0..u.ncols()).map(move |j| u[(i, j)]));
        Ok(array([u.nrows(), u.ncols()], ["return", "eigenvector"], rows.collect()))
    }),
    ("/kmeans/labels", |frame| {
        let labels = frame.partition.labels.iter().map(|label| label.map_or(-1, i64::from));
        let numbers = Numbers::I64(labels.collect());
        Ok(Array { shape: vec![numbers.len()], dims: vec!["return".to_owned()], numbers })
    }),
];

/// Whether the entity can be recomputed.
pub(super) fn can_be(entity: &str) -> bool {
    ENTITIES.iter().any(|(name, _)| *name == entity)
}

fn vector(dim: &str, values: Vec<f64>) -> Array {
    Array { shape: vec![values.len()], dims: vec![dim.to_owned()], numbers: Numbers::F64(values) }
}

fn array(shape: [usize; 2], dims: [&str; 2], values: Vec<f64>) -> Array {
    Array { shape: shape.to_vec(), dims: dims.map(str::to_owned).to_vec(), numbers: Numbers::F64(values) }
}

/// The engine that made the recording, and its ranges.
pub(super) struct Recomputation<'a> {
    sensor: Sensor,
    upside_down: bool,
    engine: Engine,
    frame: Frame,
    of_frame: Part,
    bearings_rad: LatestAt<'a>,
    wire: LatestAt<'a>,
    eigenvalues: LatestAt<'a>,
}

impl<'a> Recomputation<'a> {
    /// Prepares to recompute `entity` with the recorded configuration.
    pub(super) fn new(recording: &'a Recording, entity: &str) -> anyhow::Result<Self> {
        let Some((_, of_frame)) = ENTITIES.into_iter().find(|(name, _)| *name == entity) else {
            let names = ENTITIES.map(|(name, _)| name).join(", ");
            return Err(UsageError(format!("{entity} cannot be recomputed; {names} can")).into());
        };
        let toml = recording.config_toml().context("the recording has no /config")?;
        let registry = Registry::standard();
        let layer = Layer::file(Path::new("/config"), &toml)?;
        let config = Config::resolve(&registry, &[layer]).context("it was recorded by another version of crosscut")?;
        Ok(Self {
            sensor: Sensor::new(config.params("ingest")),
            upside_down: config.params("ingest").get(UPSIDE_DOWN),
            engine: Engine::new(&config, &registry),
            frame: Frame::default(),
            of_frame,
            bearings_rad: LatestAt::new(recording, "/scan/beams", "Tensor:data")?,
            wire: LatestAt::new(recording, "/scan/beams/wire", "Tensor:data")?,
            eigenvalues: LatestAt::new(recording, "/spectral/eigenvalues", "BarChart:values")?,
        })
    }

    /// Calls `take` with the value at every selected revolution; what does not agree with the recording is returned.
    pub(super) fn run(
        mut self,
        ranges: Rows,
        selection: &Selection,
        mut take: impl FnMut(&Row, Value) -> anyhow::Result<()>,
    ) -> anyhow::Result<Vec<String>> {
        let mut lost = Vec::new();
        for row in ranges {
            let row = row?;
            if selection.holds(&row) {
                lost.extend(self.process(&row)?);
                take(&row, Value::Numbers((self.of_frame)(&self.frame)?))?;
            }
        }
        Ok(lost)
    }

    /// The revolution through all stages; what does not agree with what was recorded.
    fn process(&mut self, row: &Row) -> anyhow::Result<Option<String>> {
        let ranges_m = f32s(&row.value("Tensor:data")?).context("/scan/ranges are not f32")?;
        let Some(wire) = self.wire.at(row.revolution)?.as_ref().and_then(f32s) else {
            bail!("revolution {} has no beam geometry", row.revolution);
        };
        let [angle_min, angle_increment, range_min, range_max] = wire[..] else {
            bail!("/scan/beams/wire is not 4 numbers")
        };
        let bearings_rad = self.bearings_rad.at(row.revolution)?.as_ref().map(numbers).unwrap_or_default();
        let turned_rad = if self.upside_down { -turn_rad(&bearings_rad) } else { turn_rad(&bearings_rad) };
        let scan = LaserScan {
            header: Header { stamp: Time::from_ns(row.stamp_ns.unwrap_or(0).cast_unsigned()), ..Header::default() },
            angle_min,
            // Not recorded. Where the increment is of no use, bearings follow from it; rounded to f32, it is the same.
            angle_max: (f64::from(angle_min) + turned_rad) as f32,
            angle_increment,
            range_min,
            range_max,
            ranges: ranges_m,
            ..LaserScan::default()
        };
        let Frame { revolution, notes, .. } = &mut self.frame;
        notes.clear();
        self.sensor.revolution(&scan, revolution, notes);
        revolution.seq = row.revolution.cast_unsigned();
        let sweep = revolution.sweep.as_ref().context("the sensor makes a sweep of every scan")?;
        if bearings_rad != sweep.bearings_rad {
            bail!("the bearings of revolution {} do not follow from what is recorded of its message", row.revolution);
        }
        self.engine.process(&mut self.frame)?;
        let recorded = self.eigenvalues.at(row.revolution)?.as_ref().map(numbers).unwrap_or_default();
        Ok(disagreement(&recorded, &self.frame.spectrum.eigenvalues).map(|off| {
            format!(
                "revolution {}: recomputed eigenvalues are off by {off:.1e}: made by another version?",
                row.revolution
            )
        }))
    }
}

/// The angle from the first bearing on to the last, over all between them: more than half a turn, too.
fn turn_rad(bearings_rad: &[f64]) -> f64 {
    bearings_rad.windows(2).map(|pair| wrap_angle_rad(pair[1] - pair[0])).sum()
}

/// How far the recorded eigenvalues lie from the recomputed ones, if that is more than rounding.
fn disagreement(recorded: &[f64], recomputed: &[f64]) -> Option<f64> {
    if recorded.len() > recomputed.len() {
        return Some(f64::INFINITY);
    }
    let off = recorded.iter().zip(recomputed).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    (off > ROUNDING).then_some(off)
}

/// A component as it holds at ascending revolutions: what was logged last.
struct LatestAt<'a> {
    rows: Peekable<Rows<'a>>,
    component: &'static str,
    latest: Option<Value>,
}

impl<'a> LatestAt<'a> {
    fn new(recording: &'a Recording, entity: &str, component: &'static str) -> Result<Self, ReadError> {
        Ok(Self { rows: recording.rows(entity)?.peekable(), component, latest: None })
    }

    fn at(&mut self, revolution: i64) -> Result<&Option<Value>, ReadError> {
        while let Some(row) = self.rows.next_if(|row| row.as_ref().map_or(true, |row| row.revolution <= revolution)) {
            self.latest = Some(row?.value(self.component)?);
        }
        Ok(&self.latest)
    }
}

fn f32s(value: &Value) -> Option<Vec<f32>> {
    match value {
        Value::Numbers(Array { numbers: Numbers::F32(values), .. }) => Some(values.clone()),
        _ => None,
    }
}

fn numbers(value: &Value) -> Vec<f64> {
    match value {
        Value::Numbers(array) => array.to_f64(),
        _ => Vec::new(),
    }
}
