//! The conformance tests on a stage written in Python.

use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};

use pyo3::exceptions::PyAssertionError;
use pyo3::prelude::*;

use crate::stages::{AFFINITY, Entry, named};

/// Holds an affinity to what the rest of the program relies on.
#[pyfunction]
pub(crate) fn check_affinity(py: Python<'_>, function: Bound<'_, PyAny>) -> PyResult<()> {
    let entry = Entry::of(function);
    let kind = named(AFFINITY, "affinity", &entry);
    let checked = py.detach(|| {
        // A failed check panics, many times while its input is made smaller.
        let hook = take_hook();
        set_hook(Box::new(|_| {}));
        let checked = catch_unwind(AssertUnwindSafe(|| crosscut_conformance::affinity::all(&kind)));
        set_hook(hook);
        checked
    });
    checked.map_err(|panic| {
        let text = panic.downcast_ref::<String>().map_or("it panicked", String::as_str);
        // The input that failed follows, point by point.
        PyAssertionError::new_err(text.split("minimal failing input").next().unwrap_or(text).trim().to_owned())
    })
}
