//! The command line within the interpreter's process.

use std::ffi::OsString;

use crosscut_pipeline::Registry;
use pyo3::prelude::*;

use crate::stages;

/// Runs the command in `args`, of which the first is the program's name, and returns its exit code. `stages` are further
/// kinds: the section, `python:module.name` and the callable.
#[pyfunction]
pub(crate) fn program(py: Python<'_>, args: Vec<OsString>, stages: Vec<(String, String, Bound<'_, PyAny>)>) -> u8 {
    let mut registry = Registry::standard();
    for (section, kind, function) in stages {
        stages::add_named(&section, &kind, function, &mut registry);
    }
    py.detach(|| crosscut::run(args, &registry))
}
