//! One scan: as a driver gives it, or as a recording shows it.

use crosscut_messages::{LaserScan, MOST_BEAMS, MOST_POINTS, ScanDecoder, ScanMessage};
use crosscut_sensor::{Live, Odometry, Sensor};
use crosscut_stage::{Frame, Notes, Point, Revolution};
use nalgebra::Isometry2;
use numpy::IntoPyArray;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::arrays::{self, Matrix};
use crate::error::Class;
use crate::values::{Real, Whole};

/// One scan. Made of ranges, of points, or by `crosscut.read`.
#[pyclass(frozen, module = "crosscut")]
pub(crate) struct Scan {
    /// Its number, if it has one.
    seq: Option<u64>,
    content: Content,
}

enum Content {
    /// A message, which the sensor of an engine makes a revolution, and the poses of the vehicle around it.
    Message { message: ScanMessage, stamp_ns: u64, odometry: Odometry },
    /// A revolution, with what ingest noted of it.
    Revolution(Revolution, Notes),
    /// The points of a cloud in the body frame, of which the vehicle of an engine sees a level revolution.
    Points(Revolution),
}

impl Scan {
    pub(crate) fn recorded(revolution: Revolution, notes: Notes) -> Self {
        Self { seq: Some(revolution.seq), content: Content::Revolution(revolution, notes) }
    }

    fn of_message(message: ScanMessage, stamp_ns: u64, seq: Option<u64>) -> Self {
        Self { seq, content: Content::Message { message, stamp_ns, odometry: Odometry::default() } }
    }

    /// When it was taken, from and to, if it is a message.
    pub(crate) fn span_ns(&self) -> Option<[u64; 2]> {
        match &self.content {
            Content::Message { message, .. } => Some(Live::span_ns(message)),
            Content::Revolution(..) | Content::Points(_) => None,
        }
    }

    /// The scan with these poses of the vehicle, and the pose in the middle of it.
    pub(crate) fn beside(&self, odometry: &Odometry) -> (Self, Option<Isometry2<f64>>) {
        let (content, pose) = match &self.content {
            Content::Message { message, stamp_ns, .. } => {
                let (message, stamp_ns, odometry) = (message.clone(), *stamp_ns, odometry.clone());
                let pose = Live::pose(&message, &odometry);
                (Content::Message { message, stamp_ns, odometry }, pose)
            }
            Content::Revolution(revolution, notes) => {
                (Content::Revolution(revolution.clone(), notes.clone()), revolution.odometry)
            }
            Content::Points(points) => (Content::Points(points.clone()), None),
        };
        (Self { seq: self.seq, content }, pose)
    }

    /// Writes the revolution into `frame`, with its notes; `live` knows the scans before, `seq` numbers a scan that has no
    /// number.
    pub(crate) fn write(&self, live: &mut Live, sensor: &Sensor, seq: u64, frame: &mut Frame) {
        frame.notes.clear();
        match &self.content {
            Content::Message { message, stamp_ns, odometry } => {
                live.show(message, odometry, sensor, &mut frame.revolution, &mut frame.notes);
                frame.revolution.stamp_ns = *stamp_ns;
            }
            Content::Revolution(revolution, notes) => {
                frame.revolution.clone_from(revolution);
                frame.notes.clone_from(notes);
            }
            Content::Points(points) => {
                frame.revolution.clone_from(points);
                sensor.level(&mut frame.revolution, &mut frame.notes);
            }
        }
        frame.revolution.seq = self.seq.unwrap_or(seq);
    }

    /// The ranges and the geometry of the message, untouched; `None` for a cloud that was not recorded.
    fn wire(&self) -> Option<(&[f32], [f32; 4])> {
        match &self.content {
            Content::Message { message: ScanMessage::Scan(scan), .. } => {
                Some((&scan.ranges, [scan.angle_min, scan.angle_increment, scan.range_min, scan.range_max]))
            }
            Content::Message { message: ScanMessage::Cloud(_), .. } | Content::Points(_) => None,
            Content::Revolution(revolution, _) => {
                revolution.sweep.as_ref().map(|sweep| (&sweep.ranges_m[..], sweep.wire_geometry))
            }
        }
    }
}

#[pymethods]
impl Scan {
    #[new]
    #[pyo3(signature = (ranges, angle_min, angle_increment, *, range_min=Real(0.0), range_max=Real(f64::INFINITY), stamp_ns=Whole(0), seq=None, frame_id=String::new()), text_signature = "(ranges, angle_min, angle_increment, *, range_min=0.0, range_max=..., stamp_ns=..., seq=None, frame_id=...)")]
    #[expect(clippy::too_many_arguments)] // keywords in Python
    fn new(
        ranges: &Bound<'_, PyAny>,
        angle_min: Real,
        angle_increment: Real,
        range_min: Real,
        range_max: Real,
        stamp_ns: Whole,
        seq: Option<Whole>,
        frame_id: String,
    ) -> PyResult<Self> {
        let ranges: Vec<f32> = arrays::vector(ranges, MOST_BEAMS)?;
        let (Real(angle_min), Real(angle_increment)) = (angle_min, angle_increment);
        let mut scan = LaserScan {
            angle_min: angle_min as f32,
            angle_max: (angle_min + ranges.len().saturating_sub(1) as f64 * angle_increment) as f32,
            angle_increment: angle_increment as f32,
            range_min: range_min.0 as f32,
            range_max: range_max.0 as f32,
            ranges,
            ..LaserScan::default()
        };
        scan.header.frame_id = frame_id;
        Ok(Self::of_message(ScanMessage::Scan(scan), stamp_ns.0, seq.map(|seq| seq.0)))
    }

    #[staticmethod]
    #[pyo3(signature = (points, *, stamp_ns=Whole(0), seq=None, frame_id=String::new()))]
    fn from_points(points: &Bound<'_, PyAny>, stamp_ns: Whole, seq: Option<Whole>, frame_id: String) -> PyResult<Self> {
        let points = Self::without_beams(points)?;
        let Content::Revolution(points, _) = points.content else { return Ok(points) };
        let content = Content::Points(Revolution { stamp_ns: stamp_ns.0, frame_id, ..points });
        Ok(Self { seq: seq.map(|seq| seq.0), content })
    }

    /// Points as they are, all of them returns without beams: for affinities that need none.
    #[staticmethod]
    #[pyo3(name = "_without_beams")]
    fn without_beams(points: &Bound<'_, PyAny>) -> PyResult<Self> {
        let matrix = Matrix::of(points, |[n, dimensions]| n <= MOST_POINTS && (2..=3).contains(&dimensions))?;
        let [n, dimensions] = matrix.shape();
        if !(2..=3).contains(&dimensions) {
            return Err(PyValueError::new_err(format!("points have 2 or 3 columns, not {dimensions}")));
        }
        if n > MOST_POINTS {
            return Err(PyValueError::new_err(format!("{n} points are more than {MOST_POINTS}")));
        }
        let mut points_m = vec![Point::origin(); n];
        matrix.for_each(|i, axis, value| points_m[i][axis] = value);
        if let Some(at) = points_m.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
            return Err(PyValueError::new_err(format!("point {at} is not finite")));
        }
        let revolution = Revolution { points_m, ..Revolution::default() };
        Ok(Self { seq: None, content: Content::Revolution(revolution, Notes::default()) })
    }

    /// A message as it is on the wire, of any type and encoding that recordings may have.
    #[staticmethod]
    #[pyo3(signature = (message, message_type="sensor_msgs/msg/LaserScan", *, encoding="cdr", seq=None))]
    fn from_message(
        py: Python<'_>,
        message: &[u8],
        message_type: &str,
        encoding: &str,
        seq: Option<Whole>,
    ) -> PyResult<Self> {
        let unknown = || PyValueError::new_err(format!("{message_type} in {encoding} is no scan that can be read"));
        let decoder = ScanDecoder::for_schema(message_type, "", encoding).ok_or_else(unknown)?;
        let mut decoded = ScanMessage::default();
        decoder.decode_into(message, &mut decoded).map_err(|error| Class::Read.because(py, &error))?;
        let stamp_ns = decoded.header().stamp.to_ns().unwrap_or(0);
        Ok(Self::of_message(decoded, stamp_ns, seq.map(|seq| seq.0)))
    }

    #[getter]
    fn seq(&self) -> Option<u64> {
        self.seq
    }

    #[getter]
    fn stamp_ns(&self) -> u64 {
        match &self.content {
            Content::Message { stamp_ns, .. } => *stamp_ns,
            Content::Revolution(revolution, _) | Content::Points(revolution) => revolution.stamp_ns,
        }
    }

    #[getter]
    fn frame_id(&self) -> &str {
        match &self.content {
            Content::Message { message, .. } => &message.header().frame_id,
            Content::Revolution(revolution, _) | Content::Points(revolution) => &revolution.frame_id,
        }
    }

    #[getter]
    fn ranges<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyAny>> {
        self.wire().map(|(ranges_m, _)| ranges_m.to_vec().into_pyarray(py).into_any())
    }

    #[getter]
    fn angle_min(&self) -> Option<f32> {
        self.wire().map(|(_, [angle_min, ..])| angle_min)
    }

    #[getter]
    fn angle_increment(&self) -> Option<f32> {
        self.wire().map(|(_, [_, angle_increment, ..])| angle_increment)
    }

    #[getter]
    fn range_min(&self) -> Option<f32> {
        self.wire().map(|(_, [_, _, range_min, _])| range_min)
    }

    #[getter]
    fn range_max(&self) -> Option<f32> {
        self.wire().map(|(_, [.., range_max])| range_max)
    }

    #[getter]
    fn points<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        if let Content::Points(points) = &self.content {
            return arrays::points(py, &points.points_m);
        }
        let mut frame = Frame::default();
        self.write(&mut Live::default(), &Sensor::default(), 0, &mut frame);
        arrays::points(py, &frame.revolution.points_m)
    }

    #[getter]
    fn notes(&self) -> Vec<String> {
        match &self.content {
            Content::Message { .. } | Content::Points(_) => Vec::new(),
            Content::Revolution(_, notes) => notes.iter().map(str::to_owned).collect(),
        }
    }

    fn __repr__(&self) -> String {
        let seq = self.seq.map(|seq| format!("seq={seq}, ")).unwrap_or_default();
        let content = match (self.wire(), &self.content) {
            (Some((ranges_m, _)), _) => format!("beams={}", ranges_m.len()),
            (None, Content::Message { message: ScanMessage::Cloud(cloud), .. }) => {
                format!("points={}", cloud.points_m.len())
            }
            (None, Content::Revolution(points, _) | Content::Points(points)) => format!("points={}", points.len()),
            (None, Content::Message { .. }) => unreachable!("a scan has ranges"),
        };
        format!("Scan({seq}{content}, stamp_ns={})", self.stamp_ns())
    }
}
