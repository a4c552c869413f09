//! A vehicle's navigator: a scan and its odometry in, a command out.

use std::sync::{Mutex, PoisonError};

use crosscut_detector::{Config, Failure, Registry, nearest_and_all};
use crosscut_flight::FlightAnswer;
use crosscut_navigate::{Limits, Pilot, PilotStep, PlannerKind, planners};
use crosscut_report::VEHICLE_WIDTH_M;
use crosscut_sensor::Live;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::map::Map;
use crate::scan::Scan;
use crate::values::{Pose, xy_yaw};

/// Speed and turn rate, what the vehicle is doing, the decision taken, and how the mission ended.
pub(crate) type Command = (f64, f64, &'static str, Option<String>, Option<&'static str>);

/// The navigator of one vehicle, with its detector and its map.
#[pyclass(frozen, module = "crosscut._native")]
pub(crate) struct Navigator {
    /// The pilot, and what is known of the robot by its scans.
    state: Mutex<(Pilot, Live)>,
}

impl Navigator {
    pub(crate) fn new(
        config: &Config,
        registry: &Registry,
        planner: &str,
        [speed_max_m_s, turn_rate_max_rad_s]: [f64; 2],
    ) -> PyResult<Self> {
        for (name, limit) in [("speed_max_m_s", speed_max_m_s), ("turn_rate_max_rad_s", turn_rate_max_rad_s)] {
            if !(limit.is_finite() && limit > 0.0) {
                return Err(PyValueError::new_err(format!("{name} is above 0, not {limit}")));
            }
        }
        let kind: &PlannerKind = planners().iter().find(|kind| kind.name == planner).ok_or_else(|| {
            let all: Vec<&str> = planners().iter().map(|kind| kind.name).collect();
            PyValueError::new_err(format!("there is no planner {planner:?}; {}", nearest_and_all(planner, &all)))
        })?;
        let radius_m = 0.5 * config.params("vehicle").get(VEHICLE_WIDTH_M);
        let limits = Limits { speed_max_m_s, turn_rate_max_rad_s, radius_m };
        Ok(Self { state: Mutex::new((Pilot::new(config, registry, *kind, limits), Live::default())) })
    }

    pub(crate) fn step(&self, scan: &Scan, pose: Option<Pose>) -> Result<Command, Failure> {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let (pilot, live) = &mut *state;
        let step = pilot.step(|sensor, frame| {
            scan.write(live, sensor, 0, frame);
            if let Some(Pose(pose)) = pose {
                frame.revolution.odometry = Some(pose);
            }
        })?;
        let PilotStep { command, doing, decision, end, .. } = step;
        let why = decision.map(|decision| decision.why);
        Ok((command.speed_m_s, command.turn_rate_rad_s, doing, why, end.map(crosscut_navigate::MissionEnd::name)))
    }
}

#[pymethods]
impl Navigator {
    /// The map up to now; what the vehicle flies later is not added. Waits without the interpreter's lock for a step of another
    /// thread, whose stage in Python may need it.
    fn map(&self, py: Python<'_>) -> Map {
        Map(py.detach(|| self.state.lock().unwrap_or_else(PoisonError::into_inner).0.mapper().map()))
    }

    /// x and y in metres and yaw in radians at the last step, in the frame of the start.
    #[getter]
    fn pose(&self, py: Python<'_>) -> Option<(f64, f64, f64)> {
        py.detach(|| {
            let (pilot, _) = &*self.state.lock().unwrap_or_else(PoisonError::into_inner);
            FlightAnswer::of(pilot.frame()).pose.as_ref().map(xy_yaw)
        })
    }
}
