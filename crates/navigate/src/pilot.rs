//! The loop of a vehicle: a scan and its odometry in, a command out.

use crosscut_detector::{Config, Detector, Registry, Sensor};
use crosscut_flight::{Flight, Mapper};
use crosscut_stage::{Failure, Frame};

use crate::navigator::{Navigator, PilotStep};
use crate::planner::PlannerKind;
use crate::{Command, Limits};

/// The vehicle's first revolutions stand still, so that it has seen where it is.
const STANDS: u64 = 3;

/// The detector, the flight, the map and the navigator of one vehicle. The same scans give the same commands.
pub struct Pilot {
    detector: Detector,
    flight: Flight,
    mapper: Mapper,
    navigator: Navigator,
}

impl Pilot {
    /// For a vehicle with these limits, at the start of its mission.
    pub fn new(config: &Config, registry: &Registry, planner: PlannerKind, limits: Limits) -> Self {
        Self {
            detector: Detector::new(config.clone(), registry),
            flight: Flight::new(config.params("flight"), 2.0 * limits.radius_m),
            mapper: Mapper::default(),
            navigator: Navigator::new((planner.new)(), limits),
        }
    }

    /// The command after the next revolution, which `write` writes into the frame, with its odometry.
    ///
    /// # Errors
    /// When a stage fails. The vehicle then has no command and is to stand.
    pub fn step(&mut self, write: impl FnOnce(&Sensor, &mut Frame)) -> Result<PilotStep, Failure> {
        let frame = self.detector.detect_with(write)?;
        self.flight.add(frame);
        self.mapper.add(frame);
        let mut step = self.navigator.step(frame, &self.mapper);
        if frame.revolution.seq + 1 < STANDS {
            step.command = Command::default();
        }
        Ok(step)
    }

    /// The last revolution, with all that is known of it.
    pub fn frame(&self) -> &Frame {
        self.detector.frame()
    }

    /// The map so far.
    pub fn mapper(&self) -> &Mapper {
        &self.mapper
    }

    /// The poses so far.
    pub fn flight(&self) -> &Flight {
        &self.flight
    }
}
