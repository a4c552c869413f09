//! The map of a flight.

use std::sync::{Mutex, MutexGuard, PoisonError};

use crosscut_flight::{Flight, Mapper, check_live};
use crosscut_sensor::{Live, Sensor};
use crosscut_pipeline::Config;
use crosscut_report::VEHICLE_WIDTH_M;
use crosscut_stage::Frame;
use nalgebra::Isometry2;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

use crate::error::Class;
use crate::scan::Scan;

/// Poses and map of a flight so far.
#[pyclass(frozen, module = "crosscut._native")]
pub(crate) struct FlightMap {
    state: Mutex<State>,
}

struct State {
    /// What is known of a live robot by its scans.
    live: Live,
    flight: Flight,
    mapper: Mapper,
    /// That of the last scan.
    pose: Option<Isometry2<f64>>,
}

impl FlightMap {
    pub(crate) fn new(py: Python<'_>, config: &Config) -> PyResult<Self> {
        let params = config.params("flight");
        check_live(params).map_err(|error| Class::Settings.because(py, &error))?;
        let flight = Flight::new(params, config.params("vehicle").get(VEHICLE_WIDTH_M));
        Ok(Self::of(&flight, &Mapper::default(), None))
    }

    /// A flight that was followed elsewhere.
    pub(crate) fn of(flight: &Flight, mapper: &Mapper, pose: Option<Isometry2<f64>>) -> Self {
        let state = State { live: Live::default(), flight: flight.clone(), mapper: mapper.clone(), pose };
        Self { state: Mutex::new(state) }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Writes the next scan into `frame`, as the scans before it show the robot.
    pub(crate) fn write(&self, scan: &Scan, sensor: &Sensor, seq: u64, frame: &mut Frame) {
        scan.write(&mut self.state().live, sensor, seq, frame);
    }

    /// Takes the next frame, which the stages have filled.
    pub(crate) fn add(&self, frame: &mut Frame) {
        let mut state = self.state();
        state.flight.add(frame);
        state.mapper.add(frame);
        state.pose = frame.pose;
    }
}

#[pymethods]
impl FlightMap {
    /// x and y in metres and yaw in radians of the last scan, in the frame of the first one.
    #[getter]
    fn pose(&self) -> Option<(f64, f64, f64)> {
        self.state().pose.map(|pose| (pose.translation.x, pose.translation.y, pose.rotation.angle()))
    }

    /// The nodes, and the passages as (from, to, attributes); both with the names of `crosscut map`'s JSON.
    fn graph<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyList>, Bound<'py, PyList>)> {
        let map = py.detach(|| self.state().mapper.map());
        let (nodes, passages) = (PyList::empty(py), PyList::empty(py));
        for node in &map.nodes {
            let ways = PyList::empty(py);
            for way in &node.ways {
                let entry = PyDict::new(py);
                entry.set_item("bearing_rad", way.bearing_rad)?;
                entry.set_item("width_m", way.width_m)?;
                entry.set_item("taken", way.taken)?;
                entry.set_item("edge", way.passage)?;
                ways.append(entry)?;
            }
            let entry = PyDict::new(py);
            entry.set_item("kind", node.kind.name())?;
            entry.set_item("x_m", node.position_m.x)?;
            entry.set_item("y_m", node.position_m.y)?;
            entry.set_item("ways", ways)?;
            entry.set_item("visits", node.visits.iter().map(|v| (v[0], v[1])).collect::<Vec<_>>())?;
            nodes.append(entry)?;
        }
        for passage in &map.passages {
            let entry = PyDict::new(py);
            entry.set_item("length_m", passage.length_m)?;
            entry.set_item("length_sd_m", passage.length_sd_m)?;
            entry.set_item("width_m", passage.width_m)?;
            entry.set_item("via_m", passage.via_m.iter().map(|place| (place.x, place.y)).collect::<Vec<_>>())?;
            passages.append((passage.from, passage.to, entry))?;
        }
        Ok((nodes, passages))
    }

    /// The map as `run --map` writes it.
    fn json(&self, py: Python<'_>) -> String {
        py.detach(|| crosscut::map_json(&self.state().mapper.map()))
    }

    /// The map in a line.
    fn summary(&self, py: Python<'_>) -> String {
        py.detach(|| self.state().mapper.map().summary())
    }
}
