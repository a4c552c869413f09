//! Recordings for the Rerun viewer of frames that an engine of Python filled.

use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

use crosscut_detector::Frame;
use crosscut_detector::recording::DETAIL;
use crosscut_flight::{Flight as Poses, FlightAnswer};
use crosscut_recorder::{Recorder as Recording, RecorderOptions};
use crosscut_report::VEHICLE_WIDTH_M;
use crosscut_stage::{Observer as _, ObserverError, Value};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::engine::Engine;
use crate::error::Class;
use crate::kept::Kept;

/// A recording that is being written.
#[pyclass(frozen, module = "crosscut._native")]
pub(crate) struct Recorder {
    /// `None` once it is closed.
    open: Mutex<Option<Open>>,
}

struct Open {
    recording: Recording,
    /// Of scans that no flight has processed.
    poses: Poses,
}

impl Open {
    fn add(&mut self, mut frame: Frame) -> Result<(), ObserverError> {
        if frame.extra.get::<FlightAnswer>().is_none() {
            self.poses.add(&mut frame);
        }
        self.recording.observe(&frame)
    }
}

impl Recorder {
    /// Runs `body` on what is open, without the interpreter's lock.
    fn with<T: Send>(&self, py: Python<'_>, body: impl FnOnce(&mut Option<Open>) -> T + Send) -> T {
        py.detach(|| body(&mut self.open.lock().unwrap_or_else(PoisonError::into_inner)))
    }

    fn add(&self, py: Python<'_>, frame: Frame) -> PyResult<()> {
        match self.with(py, move |open| open.as_mut().map(|open| open.add(frame))) {
            None => Err(Class::Error.error(py, "the recorder is closed")),
            Some(added) => added.map_err(|error| Class::Error.error(py, error)),
        }
    }
}

#[pymethods]
impl Recorder {
    #[new]
    fn new(py: Python<'_>, path: PathBuf, engine: &Engine, name: String, detail: Option<String>) -> PyResult<Self> {
        let mut config = engine.config().clone();
        if let Some(detail) = detail {
            let detail =
                DETAIL.spec.check(Value::String(detail)).map_err(|error| PyValueError::new_err(error.to_string()))?;
            config = config.with("recording", DETAIL.spec.name, detail);
        }
        let options = RecorderOptions { path: Some(path), ..crosscut::recorder_options(name, &config) };
        let recording = py.detach(|| Recording::new(options)).map_err(|error| Class::Error.because(py, &error))?;
        let poses = Poses::new(config.params("flight"), config.params("vehicle").get(VEHICLE_WIDTH_M));
        Ok(Self { open: Mutex::new(Some(Open { recording, poses })) })
    }

    /// Adds the frame of a result.
    fn log(&self, py: Python<'_>, kept: &Kept) -> PyResult<()> {
        let Some(frame) = kept.take() else {
            let text = "this result has no matrices to record: it was made before the recorder was opened, by another engine, \
                        or it was recorded already";
            return Err(Class::Error.error(py, text));
        };
        self.add(py, frame)
    }

    /// Ends the file.
    fn close(&self, py: Python<'_>) -> PyResult<()> {
        match self.with(py, |open| open.take().map(|mut open| open.recording.finish())) {
            Some(Err(error)) => Err(Class::Error.error(py, error)),
            _ => Ok(()),
        }
    }
}
