//! What one revolution becomes in Python.

use crosscut_report::ResultsLine;
use crosscut_stage::{Embedding, Frame, Step, Weights};
use numpy::IntoPyArray;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyDict, PyTuple, PyType};

use crate::arrays;

/// Which matrices a result holds.
#[derive(Clone, Copy, Default)]
pub(crate) struct Keep {
    pub(crate) w: bool,
    pub(crate) l: bool,
    pub(crate) u: bool,
}

/// The answer for one revolution, made without the interpreter's lock.
pub(crate) struct Answer {
    line: ResultsLine,
    /// All that the spectral stage gave.
    eigenvalues: Vec<f64>,
    clusters: Vec<i32>,
    w: Option<(Weights, Vec<f64>)>,
    u: Option<Embedding>,
    timings_ms: [(Step, f64); 4],
}

impl Answer {
    pub(crate) fn of(frame: &Frame, keep: Keep) -> Self {
        let ms = |step| (step, frame.timings.ns(step) as f64 / 1e6);
        Self {
            line: ResultsLine::of(frame),
            eigenvalues: frame.spectrum.eigenvalues.clone(),
            clusters: frame.partition.labels.iter().map(|label| label.map_or(-1, u32::cast_signed)).collect(),
            w: (keep.w || keep.l).then(|| (frame.affinity.weights.clone(), frame.affinity.degrees.clone())),
            u: keep.u.then(|| frame.spectrum.u.clone()),
            timings_ms: [Step::Affinity, Step::Spectral, Step::Kmeans, Step::Report].map(ms),
        }
    }

    /// As a `crosscut.Result`.
    pub(crate) fn into_result<'py>(self, py: Python<'py>, keep: Keep) -> PyResult<Bound<'py, PyAny>> {
        let Self { line, eigenvalues, clusters, w, u, timings_ms } = self;
        let [result, wall, opening] = classes(py)?;
        let walls =
            line.walls.iter().map(|w| wall.call1((w.id, w.returns, (w.bearing_rad[0], w.bearing_rad[1]), w.island)));
        let openings = line.openings.iter().map(|o| {
            let walls = (o.walls[0], o.walls[1]);
            opening.call1((o.bearing_rad, o.width_m, o.range_m, walls, o.evidence.as_str(), o.cut_by_view))
        });
        let timings = PyDict::new(py);
        for (step, ms) in timings_ms {
            timings.set_item(step.name(), ms)?;
        }
        let (mut weights, mut degrees) = (None, None);
        if let Some((kept, of_rows)) = w {
            weights = Some(arrays::weights(py, &kept)?);
            degrees = Some(of_rows.into_pyarray(py));
        }
        let laplacian = match (&weights, &degrees) {
            (Some(w), Some(d)) if keep.l => Some(py.import("crosscut._results")?.getattr("laplacian")?.call1((w, d))?),
            _ => None,
        };
        let fields = [
            line.seq.into_pyobject(py)?.into_any(),
            line.stamp_ns.into_pyobject(py)?.into_any(),
            line.returns.into_pyobject(py)?.into_any(),
            line.junctions.into_pyobject(py)?.into_any(),
            line.k.into_pyobject(py)?.into_any(),
            line.margin.into_pyobject(py)?.into_any(),
            line.confidence.into_pyobject(py)?.into_any(),
            line.place.into_pyobject(py)?.into_any(),
            eigenvalues.into_pyarray(py).into_any(),
            PyTuple::new(py, walls.collect::<PyResult<Vec<_>>>()?)?.into_any(),
            PyTuple::new(py, openings.collect::<PyResult<Vec<_>>>()?)?.into_any(),
            line.labels.into_pyarray(py).into_any(),
            clusters.into_pyarray(py).into_any(),
            PyTuple::new(py, line.notes)?.into_any(),
            timings.into_any(),
            weights.filter(|_| keep.w).into_pyobject(py)?.into_any(),
            laplacian.into_pyobject(py)?.into_any(),
            u.map(|u| arrays::embedding(py, &u)).transpose()?.into_pyobject(py)?.into_any(),
        ];
        result.call1(PyTuple::new(py, fields)?)
    }
}

/// `Result`, `Wall` and `Opening`.
fn classes(py: Python<'_>) -> PyResult<[&Bound<'_, PyType>; 3]> {
    static CLASSES: [PyOnceLock<Py<PyType>>; 3] = [const { PyOnceLock::new() }; 3];
    let [result, wall, opening] = &CLASSES;
    Ok([
        result.import(py, "crosscut._results", "Result")?,
        wall.import(py, "crosscut._results", "Wall")?,
        opening.import(py, "crosscut._results", "Opening")?,
    ])
}
