//! What stays of a scan behind its result.

use std::sync::Mutex;

use crosscut_detector::Frame;
use pyo3::prelude::*;

use crate::engine::Engine;
use crate::scan::Scan;

/// The scan of a result and the engine that answered it; with the frame as the stages left it while a recorder waits for it.
#[pyclass(frozen, module = "crosscut._native")]
pub(crate) struct Kept {
    engine: Py<Engine>,
    scan: Py<Scan>,
    seq: u64,
    #[cfg_attr(not(feature = "rerun"), expect(dead_code, reason = "a build without recordings has no recorder"))]
    frame: Mutex<Option<Frame>>,
}

impl Kept {
    pub(crate) fn new(engine: Py<Engine>, scan: Py<Scan>, seq: u64, frame: Option<Frame>) -> Self {
        Self { engine, scan, seq, frame: Mutex::new(frame) }
    }

    /// The frame, once.
    #[cfg(feature = "rerun")]
    pub(crate) fn take(&self) -> Option<Frame> {
        self.frame.lock().unwrap_or_else(std::sync::PoisonError::into_inner).take()
    }
}

#[pymethods]
impl Kept {
    /// Why the count is what it is; the stages run again for it. `notes` are those of the result.
    fn why(&self, py: Python<'_>, notes: Vec<String>) -> PyResult<String> {
        self.engine.get().why(py, self.scan.get(), self.seq, notes)
    }
}
