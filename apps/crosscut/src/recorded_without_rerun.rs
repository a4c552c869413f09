//! In place of `recorded.rs` where the program is built without Rerun.

use std::path::{Path, PathBuf};

use crosscut_detector::{Config, Layer};
use crosscut_messages::{Truth, TruthError};
use crosscut_stage::{Notes, Revolution, SourceError};

use crate::cli::InputArgs;
use crate::exit::UsageError;

/// There are none.
pub(crate) enum Recorded {}

impl Recorded {
    pub(crate) fn open(_: &Path, _: &InputArgs, _: &Config) -> anyhow::Result<Self> {
        Err(crate::exit::without_rerun())
    }

    pub(crate) fn next(&mut self, _: &mut Revolution, _: &mut Notes) -> Result<bool, SourceError> {
        match *self {}
    }

    pub(crate) fn truth(&mut self) -> Result<Option<Truth>, TruthError> {
        match *self {}
    }

    pub(crate) fn has_truth(&self) -> bool {
        match *self {}
    }

    pub(crate) fn losses(&self) -> &[String] {
        match *self {}
    }

    pub(crate) fn starts_at_s(&self) -> Option<f64> {
        match *self {}
    }
}

/// None: recordings are files that the reader of flights refuses.
pub(crate) fn only(_: &[PathBuf]) -> Result<Option<&Path>, UsageError> {
    Ok(None)
}

pub(crate) fn settings(_: &Path) -> anyhow::Result<Layer> {
    Err(crate::exit::without_rerun())
}
