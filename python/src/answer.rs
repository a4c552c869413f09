//! What one revolution becomes in Python.

use crosscut_report::{HereLine, ResultsLine, SteadyLine};
use crosscut_sensor::Sensor;
use crosscut_stage::{Frame, Step, Weights};
use faer::Mat;
use numpy::IntoPyArray;
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyBytes, PyDict, PyTuple, PyType};

use crate::arrays;
use crate::kept::Kept;

/// What a result holds beside the fields of its line.
#[derive(Clone, Copy, Default)]
pub(crate) struct Keep {
    pub(crate) w: bool,
    pub(crate) l: bool,
    pub(crate) u: bool,
    pub(crate) markers: bool,
}

/// The answer for one revolution, made without the interpreter's lock.
pub(crate) struct Answer {
    line: ResultsLine,
    /// All that the spectral stage gave.
    eigenvalues: Vec<f64>,
    clusters: Vec<i32>,
    w: Option<(Weights, Vec<f64>)>,
    u: Option<Mat<f64>>,
    markers: Option<Vec<u8>>,
    timings_ms: [(Step, f64); 4],
}

impl Answer {
    pub(crate) fn of(frame: &Frame, sensor: &Sensor, keep: Keep) -> Self {
        let ms = |step| (step, frame.timings.ns(step) as f64 / 1e6);
        Self {
            line: ResultsLine::of(frame),
            eigenvalues: frame.spectrum.eigenvalues.clone(),
            clusters: frame.partition.labels.iter().map(|label| label.map_or(-1, u32::cast_signed)).collect(),
            w: (keep.w || keep.l).then(|| (frame.affinity.weights.clone(), frame.affinity.degrees.clone())),
            u: keep.u.then(|| frame.spectrum.u.clone()),
            markers: keep.markers.then(|| crosscut::scene(frame, sensor).markers()),
            timings_ms: [Step::Affinity, Step::Spectral, Step::Kmeans, Step::Report].map(ms),
        }
    }

    /// As a `crosscut.Result`.
    pub(crate) fn into_result<'py>(self, py: Python<'py>, keep: Keep, kept: Kept) -> PyResult<Bound<'py, PyAny>> {
        let Self { line, eigenvalues, clusters, w, u, markers, timings_ms } = self;
        let [result, wall, opening, _, _, _, of_pose, of_way] = classes(py)?;
        let walls = line.walls.iter().map(|of| {
            let w = &of.wall;
            wall.call1((w.id, w.returns, (w.bearing_rad[0], w.bearing_rad[1]), w.island, of.nearest_m, of.nearest_rad))
        });
        let openings = line.openings.iter().map(|o| {
            let walls = (o.walls[0], o.walls[1]);
            opening.call1((
                o.bearing_rad,
                o.width_m,
                o.range_m,
                o.p,
                walls,
                o.evidence.as_str(),
                o.known.as_str(),
                o.cut_by_view,
            ))
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
        // The constructor of a frozen dataclass takes ten times as long.
        let made = result.call_method1(intern!(py, "__new__"), (result,))?;
        let fields = made.getattr(intern!(py, "__dict__"))?.cast_into::<PyDict>()?;
        fields.set_item(intern!(py, "seq"), line.seq)?;
        fields.set_item(intern!(py, "stamp_ns"), line.stamp_ns)?;
        fields.set_item(intern!(py, "returns"), line.returns)?;
        fields.set_item(intern!(py, "junctions"), line.junctions)?;
        fields.set_item(intern!(py, "k"), line.k)?;
        fields.set_item(intern!(py, "margin"), line.margin)?;
        fields.set_item(intern!(py, "confidence"), line.confidence)?;
        fields.set_item(intern!(py, "place"), line.place)?;
        fields.set_item(intern!(py, "eigenvalues"), eigenvalues.into_pyarray(py))?;
        fields.set_item(intern!(py, "walls"), PyTuple::new(py, walls.collect::<PyResult<Vec<_>>>()?)?)?;
        fields.set_item(intern!(py, "openings"), PyTuple::new(py, openings.collect::<PyResult<Vec<_>>>()?)?)?;
        let gaps = PyDict::new(py);
        gaps.set_item(intern!(py, "seen"), line.gaps.seen)?;
        gaps.set_item(intern!(py, "proved"), line.gaps.proved)?;
        gaps.set_item(intern!(py, "judged"), line.gaps.judged)?;
        fields.set_item(intern!(py, "gaps"), gaps)?;
        let holds_for_width_m = line.holds_for_width_m.map(|[least_m, most_m]| (least_m, most_m));
        fields.set_item(intern!(py, "holds_for_width_m"), holds_for_width_m)?;
        fields.set_item(intern!(py, "labels"), line.labels.into_pyarray(py))?;
        fields.set_item(intern!(py, "clusters"), clusters.into_pyarray(py))?;
        fields.set_item(intern!(py, "notes"), PyTuple::new(py, line.notes)?)?;
        fields.set_item(intern!(py, "timings_ms"), timings)?;
        fields.set_item(intern!(py, "here"), line.here.map(|here| of_here(py, here)).transpose()?)?;
        fields.set_item(intern!(py, "steady"), line.steady.map(|steady| of_steady(py, steady)).transpose()?)?;
        let pose = line.pose.map(|pose| of_pose.call1((pose.x_m, pose.y_m, pose.yaw_rad, pose.sd_m)));
        fields.set_item(intern!(py, "pose"), pose.transpose()?)?;
        let ways = line.ways.map(|ways| {
            let ways = ways.into_iter().map(|way| {
                let direction: (f64, f64, f64) = way.direction.into();
                of_way.call1((
                    direction,
                    way.bearing_rad,
                    way.elevation_rad,
                    way.slope_rad,
                    way.clearance_m,
                    way.kind,
                    way.p,
                    way.evidence,
                    way.cut_by_view,
                ))
            });
            PyTuple::new(py, ways.collect::<PyResult<Vec<_>>>()?)
        });
        fields.set_item(intern!(py, "ways"), ways.transpose()?)?;
        fields.set_item(intern!(py, "ways_view_rad"), line.ways_view_rad.map(|[low, high]| (low, high)))?;
        fields.set_item(intern!(py, "W"), weights.filter(|_| keep.w))?;
        fields.set_item(intern!(py, "L"), laplacian)?;
        fields.set_item(intern!(py, "U"), u.map(|u| arrays::embedding(py, &u)).transpose()?)?;
        fields.set_item(intern!(py, "markers"), markers.map(|markers| PyBytes::new(py, &markers)))?;
        fields.set_item(intern!(py, "_kept"), Py::new(py, kept)?)?;
        Ok(made)
    }
}

/// As a `crosscut.Here`.
fn of_here(py: Python<'_>, here: HereLine) -> PyResult<Bound<'_, PyAny>> {
    let [_, _, _, of_here, ..] = classes(py)?;
    of_here.call1((here.kind, PyTuple::new(py, here.ways)?, here.confidence))
}

/// As a `crosscut.Steady`.
fn of_steady(py: Python<'_>, steady: SteadyLine) -> PyResult<Bound<'_, PyAny>> {
    let [_, _, _, _, of_steady, followed, ..] = classes(py)?;
    let openings = steady.openings.iter().map(|o| followed.call1((o.track, o.bearing_rad, o.width_m, o.p, o.seen_ns)));
    let openings = PyTuple::new(py, openings.collect::<PyResult<Vec<_>>>()?)?;
    let here = steady.here.map(|here| self::of_here(py, here)).transpose()?;
    of_steady.call1((steady.junctions, here, openings))
}

/// The classes of a result and of its parts.
fn classes(py: Python<'_>) -> PyResult<[&Bound<'_, PyType>; 8]> {
    static CLASSES: [(&str, PyOnceLock<Py<PyType>>); 8] = [
        ("Result", PyOnceLock::new()),
        ("Wall", PyOnceLock::new()),
        ("Opening", PyOnceLock::new()),
        ("Here", PyOnceLock::new()),
        ("Steady", PyOnceLock::new()),
        ("FollowedOpening", PyOnceLock::new()),
        ("Pose", PyOnceLock::new()),
        ("WayOn", PyOnceLock::new()),
    ];
    let [result, wall, opening, here, steady, followed, pose, way] = &CLASSES;
    let import = |(name, class): &'static (&str, PyOnceLock<Py<PyType>>)| class.import(py, "crosscut._results", name);
    Ok([
        import(result)?,
        import(wall)?,
        import(opening)?,
        import(here)?,
        import(steady)?,
        import(followed)?,
        import(pose)?,
        import(way)?,
    ])
}
