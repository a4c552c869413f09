//! All stages on one scan, or on a batch of them.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError, TryLockError};
use std::time::Instant;

use crosscut_detector::{Config, Engine as Stages, Failure, Frame, Layer, Preset, Registry};
use crosscut_sensor::{Live, Sensor};
use pyo3::exceptions::{PyException, PyValueError};
use pyo3::prelude::*;

use crate::answer::{Answer, Keep};
use crate::error::Class;
use crate::flight::Flight;
use crate::kept::Kept;
use crate::navigator::{Command, Navigator};
use crate::recording::{Recording, Wanted};
use crate::scan::Scan;
use crate::stages::Callables;
use crate::values::{Pose, Real};

/// The stages of one configuration, with their buffers.
#[pyclass(frozen, module = "crosscut._native")]
pub(crate) struct Engine {
    config: Config,
    registry: Registry,
    keep: Keep,
    callables: Callables,
    /// A batch ends after its current scan.
    stopped: AtomicBool,
    /// Results keep their frames, for a recorder.
    keeps_frames: AtomicBool,
    work: Mutex<Work>,
}

struct Work {
    stages: Stages,
    sensor: Sensor,
    frame: Frame,
}

impl Work {
    fn process(&mut self, scan: &Scan, seq: u64) -> Result<(), Failure> {
        scan.write(&mut Live::default(), &self.sensor, seq, &mut self.frame);
        self.forget_flight();
        self.stages.process(&mut self.frame)
    }

    /// What a flight added to the scan before.
    fn forget_flight(&mut self) {
        self.frame.extra.clear();
    }

    /// The answer that is in the frame, and the frame if it is to be kept.
    fn answer(&mut self, keep: Keep, keeps_frame: bool) -> (Answer, Option<Frame>) {
        let answer = Answer::of(&self.frame, &self.sensor, keep);
        (answer, keeps_frame.then(|| std::mem::take(&mut self.frame)))
    }
}

impl Engine {
    #[cfg(feature = "rerun")]
    pub(crate) fn config(&self) -> &Config {
        &self.config
    }

    /// The text of `/report/why` for a scan, with these notes. It has stages of its own, so that it disturbs no scan in progress.
    #[cfg(feature = "rerun")]
    pub(crate) fn why(&self, py: Python<'_>, scan: &Scan, seq: u64, notes: Vec<String>) -> PyResult<String> {
        let text = py.detach(|| {
            let stages = Stages::new(&self.config, &self.registry);
            let mut work = Work { stages, sensor: self.config.sensor(), frame: Frame::default() };
            work.process(scan, seq)?;
            work.frame.notes.clear();
            work.frame.notes.extend(notes.into_iter().map(|note| (crosscut_stage::NoteCode::N101, note)));
            Ok(crosscut_recorder::why(&work.frame))
        });
        text.map_err(|failure: Failure| self.failed(py, &failure))
    }

    #[cfg(not(feature = "rerun"))]
    pub(crate) fn why(&self, py: Python<'_>, _: &Scan, _: u64, _: Vec<String>) -> PyResult<String> {
        Err(Class::Error.error(py, "this package was built without recordings, which give the reasons"))
    }

    /// Runs `body` without the interpreter's lock.
    fn working<T: Send>(&self, py: Python<'_>, body: impl FnOnce(&mut Work) -> T + Send) -> PyResult<T> {
        let done = py.detach(|| match self.work.try_lock() {
            Ok(mut work) => Some(body(&mut work)),
            Err(TryLockError::Poisoned(poisoned)) => Some(body(&mut poisoned.into_inner())),
            Err(TryLockError::WouldBlock) => None,
        });
        done.ok_or_else(|| Class::Error.error(py, "this engine is busy; use one engine per thread"))
    }

    /// The failure of a stage; the exception that a stage in Python raised is its cause. An interrupt stays one.
    fn failed(&self, py: Python<'_>, failure: &Failure) -> PyErr {
        let raised = self.callables.raised();
        match raised {
            Some(raised) if !raised.is_instance_of::<PyException>(py) => raised,
            raised => {
                let error = Class::Stage.error(py, failure);
                error.set_cause(py, raised);
                error
            }
        }
    }
}

#[pymethods]
impl Engine {
    /// `settings` are of the form `section.key=value`; a stage that is `None` is chosen by the settings.
    #[new]
    fn new(
        py: Python<'_>,
        preset: &str,
        settings: Vec<String>,
        stages: [Option<Py<PyAny>>; 3],
        keep: Vec<String>,
    ) -> PyResult<Self> {
        let refused = |error| Class::Settings.error(py, error);
        let mut kept = Keep::default();
        for name in &keep {
            match name.as_str() {
                "W" => kept.w = true,
                "L" => kept.l = true,
                "U" => kept.u = true,
                "markers" => kept.markers = true,
                other => return Err(PyValueError::new_err(format!("keep holds W, L, U and markers, not {other}"))),
            }
        }
        let mut registry = Registry::standard();
        let callables = Callables::new(py, stages, &mut registry)?;
        let settings: Vec<_> = callables.settings().chain(settings).collect();
        let layers =
            [Preset::named(preset).map_err(refused)?.into(), Layer::settings("settings", &settings).map_err(refused)?];
        let config = Config::resolve(&registry, &layers).map_err(refused)?;
        let sensor = config.sensor();
        let work = Work { stages: Stages::new(&config, &registry), sensor, frame: Frame::default() };
        let work = Mutex::new(work);
        let (stopped, keeps_frames) = (AtomicBool::new(false), AtomicBool::new(false));
        Ok(Self { config, registry, keep: kept, callables, stopped, keeps_frames, work })
    }

    fn process<'py>(this: &Bound<'py, Self>, scan: &Bound<'py, Scan>, seq: u64) -> PyResult<Bound<'py, PyAny>> {
        let (mut results, error) = Self::process_batch(this, vec![scan.clone().unbind()], seq)?;
        match (results.pop(), error) {
            (Some(result), None) => Ok(result),
            (_, error) => Err(error.expect("a scan without an answer has an error")),
        }
    }

    /// The results up to the first failure, and that failure.
    fn process_batch<'py>(
        this: &Bound<'py, Self>,
        scans: Vec<Py<Scan>>,
        first_seq: u64,
    ) -> PyResult<(Vec<Bound<'py, PyAny>>, Option<PyErr>)> {
        let (py, engine) = (this.py(), this.get());
        let (answers, failure) = engine.working(py, |work| {
            let mut answers = Vec::with_capacity(scans.len());
            for (scan, seq) in scans.iter().zip(first_seq..) {
                if engine.stopped.load(Ordering::Relaxed) {
                    break;
                }
                if let Err(failure) = work.process(scan.get(), seq) {
                    return (answers, Some(failure));
                }
                answers.push(work.answer(engine.keep, engine.keeps_frames.load(Ordering::Relaxed)));
            }
            (answers, None)
        })?;
        let results = answers.into_iter().zip(scans).zip(first_seq..).map(|(((answer, frame), scan), seq)| {
            answer.into_result(py, engine.keep, Kept::new(this.clone().unbind(), scan, seq, frame))
        });
        Ok((results.collect::<PyResult<_>>()?, failure.map(|failure| engine.failed(py, &failure))))
    }

    /// How long the stages take on these scans without anything of Python, for `lab/run python_speed`.
    fn seconds_in_rust(&self, py: Python<'_>, scans: Vec<Py<Scan>>) -> f64 {
        py.detach(|| {
            let mut work = self.work.lock().unwrap_or_else(PoisonError::into_inner);
            let start = Instant::now();
            for scan in &scans {
                work.process(scan.get(), 0).ok(); // a scan that fails takes its time too
            }
            start.elapsed().as_secs_f64()
        })
    }

    /// From now on results keep their frames, or no longer.
    fn keep_frames(&self, keeps_frames: bool) {
        self.keeps_frames.store(keeps_frames, Ordering::Relaxed);
    }

    fn stop(&self) {
        self.stopped.store(true, Ordering::Relaxed);
    }

    fn flight(&self) -> Flight {
        Flight::new(&self.config)
    }

    /// As `process`; then the scan becomes a part of `flight`. `pose` is that of the vehicle by its odometry.
    fn fly<'py>(
        this: &Bound<'py, Self>,
        scan: Py<Scan>,
        seq: u64,
        pose: Option<Pose>,
        flight: Py<Flight>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (py, engine) = (this.py(), this.get());
        let added = engine.working(py, |work| {
            flight.get().write(scan.get(), &work.sensor, seq, &mut work.frame);
            work.forget_flight();
            if let Some(Pose(pose)) = pose {
                work.frame.revolution.odometry = Some(pose);
            }
            // As the scans before it show the robot.
            let seen = Scan::recorded(work.frame.revolution.clone(), work.frame.notes.clone());
            work.stages.process(&mut work.frame)?;
            flight.get().add(&mut work.frame);
            Ok((work.answer(engine.keep, engine.keeps_frames.load(Ordering::Relaxed)), seen))
        })?;
        let ((answer, frame), seen) = added.map_err(|failure| engine.failed(py, &failure))?;
        answer.into_result(py, engine.keep, Kept::new(this.clone().unbind(), Py::new(py, seen)?, seq, frame))
    }

    /// The navigator of a vehicle with these limits: largest speed and largest turn rate.
    fn navigator(&self, planner: &str, limits: [Real; 2]) -> PyResult<Navigator> {
        Navigator::new(&self.config, &self.registry, planner, limits.map(|Real(limit)| limit))
    }

    /// The command of a navigator after the next scan. `pose` is that of the vehicle by its odometry.
    fn navigate(
        &self,
        py: Python<'_>,
        scan: Py<Scan>,
        pose: Option<Pose>,
        navigator: Py<Navigator>,
    ) -> PyResult<Command> {
        let command = py.detach(|| navigator.get().step(scan.get(), pose));
        command.map_err(|failure| self.failed(py, &failure))
    }

    fn read(&self, py: Python<'_>, wanted: Wanted) -> PyResult<Recording> {
        Recording::open(py, wanted, &self.config)
    }

    /// The configuration as TOML, with unit, range and origin of each value.
    #[getter(config)]
    fn config_text(&self) -> String {
        self.config.to_string()
    }
}
