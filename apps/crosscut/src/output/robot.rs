//! Answers on their way to a live robot.

use std::time::{Duration, Instant};

use crosscut_flight::Mapper;
use crosscut_report::ResultsLine;
use crosscut_sensor::Sensor;
use crosscut_stage::Frame;

use crate::input::live::{Answer, Robot};
use crate::output::answers::scene;
use crate::output::maps;

/// The map is sent this often.
const MAP_EVERY: Duration = Duration::from_secs(1);

/// A robot that is heard, and that its answers are sent to if they are wanted.
pub(crate) struct Answered {
    robot: Box<dyn Robot>,
    sends: bool,
    sensor: Sensor,
    map_sent: Instant,
    /// Why the first answer that was not sent could not be.
    pub(crate) failure: Option<String>,
}

impl Answered {
    pub(crate) fn new(robot: Box<dyn Robot>, sends: bool, sensor: Sensor) -> Self {
        Self { robot, sends, sensor, map_sent: Instant::now(), failure: None }
    }

    pub(crate) fn take(&mut self, frame: &Frame, mapper: &Mapper) {
        if !self.sends {
            return;
        }
        let mut line = Vec::new();
        if ResultsLine::of(frame).write(&mut line).is_ok() {
            self.send(Answer::Results(String::from_utf8_lossy(&line).trim_end()));
        }
        self.send(Answer::Markers(&scene(frame, &self.sensor).markers()));
        if self.map_sent.elapsed() >= MAP_EVERY {
            self.map_sent = Instant::now();
            self.send_map(mapper);
        }
    }

    pub(crate) fn send_map(&mut self, mapper: &Mapper) {
        if self.sends {
            self.send(Answer::Map(&maps::json(&mapper.map()).to_string()));
        }
    }

    fn send(&mut self, answer: Answer<'_>) {
        if let Err(why) = self.robot.send(answer) {
            self.failure.get_or_insert(why);
        }
    }
}
