//! A flight: its poses so far, and the map that its scans make.

use std::sync::{Mutex, MutexGuard, PoisonError};

use crosscut_detector::Config;
use crosscut_flight::{Flight as Poses, FlightAnswer, Mapper};
use crosscut_report::VEHICLE_WIDTH_M;
use crosscut_sensor::{Live, Sensor};
use crosscut_stage::Frame;
use nalgebra::Isometry2;
use pyo3::prelude::*;

use crate::map::Map;
use crate::scan::Scan;
use crate::values::xy_yaw;

/// The flight of one vehicle.
#[pyclass(frozen, module = "crosscut._native")]
pub(crate) struct Flight {
    state: Mutex<State>,
}

struct State {
    /// What is known of a live robot by its scans.
    live: Live,
    poses: Poses,
    mapper: Mapper,
    /// That of the last scan.
    pose: Option<Isometry2<f64>>,
}

impl Flight {
    pub(crate) fn new(config: &Config) -> Self {
        let params = config.params("flight");
        let poses = Poses::new(params, config.params("vehicle").get(VEHICLE_WIDTH_M));
        let state = State { live: Live::default(), poses, mapper: Mapper::default(), pose: None };
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
        state.poses.add(frame);
        state.mapper.add(frame);
        state.pose = FlightAnswer::of(frame).pose;
    }
}

#[pymethods]
impl Flight {
    /// x and y in metres and yaw in radians of the last scan, in the frame of the first one.
    #[getter]
    fn pose(&self) -> Option<(f64, f64, f64)> {
        self.state().pose.as_ref().map(xy_yaw)
    }

    /// The map so far; later scans do not change it.
    fn map(&self, py: Python<'_>) -> Map {
        Map(py.detach(|| self.state().mapper.map()))
    }
}
