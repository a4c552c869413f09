//! The command line within the interpreter's process.

use std::collections::BTreeMap;
use std::ffi::OsString;

use crosscut_detector::Registry;
use pyo3::prelude::*;

use crate::robots::Heard;
use crate::stages;

/// Runs the command in `args`, of which the first is the program's name, and returns its exit code. `stages` are callables
/// by `python:module.name`; each is a further kind of every stage. `build` identifies the code of this package and of them.
/// `hear` hears live robots.
#[pyfunction]
pub(crate) fn program(
    py: Python<'_>,
    args: Vec<OsString>,
    stages: BTreeMap<String, Bound<'_, PyAny>>,
    build: Option<String>,
    hear: Py<PyAny>,
) -> u8 {
    let mut registry = Registry::standard();
    for (kind, function) in stages {
        stages::add_named(&kind, function, &mut registry);
    }
    let robots = Heard(hear);
    py.detach(|| crosscut::run(args, &registry, build.as_deref(), Some(&robots)))
}
