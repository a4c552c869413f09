//! Scans of a recording, one after the other.

use std::num::NonZero;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

use crosscut_detector::Config;
use crosscut_ingest::{CsvGeometry, ReadOptions, Recording as Ingest};
use crosscut_messages::ScanType;
use crosscut_stage::{Notes, Revolution, Source};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::error::Class;
use crate::scan::Scan;
use crate::values::Whole;

/// An iterator over the scans of a recording.
#[pyclass(frozen, module = "crosscut")]
pub(crate) struct Recording {
    ingest: Mutex<Ingest>,
}

/// Which scans of which files, as `crosscut.read` takes them.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Wanted {
    paths: Vec<PathBuf>,
    topics: Vec<String>,
    read_as: Option<String>,
    from_s: Option<f64>,
    to_s: Option<f64>,
    every: Whole,
}

impl Recording {
    /// Opens what is wanted, with the settings of the sensor in `config`.
    pub(crate) fn open(py: Python<'_>, wanted: Wanted, config: &Config) -> PyResult<Self> {
        let read_as = match &wanted.read_as {
            Some(name) => Some(ScanType::of_name(name).ok_or_else(|| {
                let names: Vec<_> = ScanType::ALL.into_iter().map(ScanType::name).collect();
                PyValueError::new_err(format!("read_as is one of {}, not {name}", names.join(", ")))
            })?),
            None => None,
        };
        let options = ReadOptions {
            topic: wanted.topics.first().cloned(),
            beside: wanted.topics.iter().skip(1).cloned().collect(),
            read_as,
            from_s: wanted.from_s,
            to_s: wanted.to_s,
            every: NonZero::new(wanted.every.0).ok_or_else(|| PyValueError::new_err("every is 1 or more"))?,
            csv: CsvGeometry::new(config.params("csv")),
            waiting_bytes: config.waiting_bytes(),
        };
        let sensor = config.sensor();
        let opened = py.detach(|| Ingest::open(&wanted.paths, &options, sensor));
        Ok(Self { ingest: Mutex::new(opened.map_err(|error| Class::Read.because(py, &error))?) })
    }

    /// Runs `body` on the recording, without the interpreter's lock.
    fn with<T: Send>(&self, py: Python<'_>, body: impl FnOnce(&mut Ingest) -> T + Send) -> T {
        py.detach(|| body(&mut self.ingest.lock().unwrap_or_else(PoisonError::into_inner)))
    }
}

#[pymethods]
impl Recording {
    fn __iter__(this: Py<Self>) -> Py<Self> {
        this
    }

    fn __next__(&self, py: Python<'_>) -> PyResult<Option<Scan>> {
        let (mut revolution, mut notes) = (Revolution::default(), Notes::default());
        match self.with(py, |ingest| ingest.next(&mut revolution, &mut notes)) {
            Ok(true) => Ok(Some(Scan::recorded(revolution, notes))),
            Ok(false) => Ok(None),
            Err(error) => Err(Class::Read.because(py, &error)),
        }
    }

    #[getter]
    fn topic(&self, py: Python<'_>) -> String {
        self.with(py, |ingest| ingest.topic().to_owned())
    }

    #[getter]
    fn losses(&self, py: Python<'_>) -> Vec<String> {
        self.with(py, |ingest| ingest.losses().iter().map(ToString::to_string).collect())
    }
}
