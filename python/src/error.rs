//! Errors as the exceptions of `crosscut._errors`, with the program's words.

use std::error::Error;

use pyo3::prelude::*;
use pyo3::types::PyType;

/// An exception class of `crosscut._errors`.
#[derive(Clone, Copy)]
pub(crate) enum Class {
    Error,
    Settings,
    Read,
    Stage,
}

impl Class {
    fn name(self) -> &'static str {
        match self {
            Self::Error => "Error",
            Self::Settings => "SettingsError",
            Self::Read => "ReadError",
            Self::Stage => "StageError",
        }
    }

    /// The exception with the text of `error` and of all that caused it.
    pub(crate) fn because(self, py: Python<'_>, error: &dyn Error) -> PyErr {
        let (mut text, mut cause) = (error.to_string(), error.source());
        while let Some(error) = cause {
            text = format!("{text}: {error}");
            cause = error.source();
        }
        self.error(py, text)
    }

    /// The exception with this text.
    pub(crate) fn error(self, py: Python<'_>, text: impl ToString) -> PyErr {
        let class = py.import("crosscut._errors").and_then(|errors| errors.getattr(self.name()));
        match class.and_then(|class| Ok(class.cast_into::<PyType>()?)) {
            Ok(class) => PyErr::from_type(class, text.to_string()),
            Err(missing) => missing,
        }
    }
}
