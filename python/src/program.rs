//! The command line within the interpreter's process.

use std::collections::BTreeMap;
use std::ffi::OsString;

use crosscut::Host;
use crosscut_detector::Registry;
use pyo3::prelude::*;

use crate::robots::Heard;
use crate::stages::Found;

/// Runs the command in `args`, of which the first is the program's name, and returns its exit code. `stages` are callables
/// by `python:module.name`; each is a further kind of every stage.
/// `hear` hears live robots. `find` finds callables that are named at a prompt.
#[pyfunction]
pub(crate) fn program(
    py: Python<'_>,
    args: Vec<OsString>,
    stages: BTreeMap<String, Bound<'_, PyAny>>,
    hear: Py<PyAny>,
    find: Py<PyAny>,
) -> u8 {
    let mut registry = Registry::standard();
    let kinds = Found::by(find);
    for (kind, function) in stages {
        kinds.add(&kind, function, &mut registry);
    }
    let robots = Heard(hear);
    py.detach(|| {
        let host = Host { robots: Some(&robots), kinds: Some(&kinds) };
        crosscut::run(args, &registry, &host)
    })
}
