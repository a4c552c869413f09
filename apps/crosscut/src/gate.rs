//! In place of what needs Rerun, in a build without it. Nothing can be recorded or is a recording.

use std::path::{Path, PathBuf};

use crosscut_detector::Layer;
use crosscut_messages::{Truth, TruthError};
use crosscut_stage::{Notes, Revolution, SourceError};

use crate::exit::UsageError;

/// The error of commands that need Rerun.
pub(crate) fn without_rerun() -> anyhow::Error {
    let text = "this crosscut was built without recordings; `cargo install --locked --path apps/crosscut` brings them";
    UsageError(text.to_owned()).into()
}

/// In place of the scans of a recording.
pub(crate) enum Recorded {}

impl Recorded {
    pub(crate) fn open(_: &Path, _: impl Sized, _: impl Sized) -> anyhow::Result<Self> {
        Err(without_rerun())
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
    Err(without_rerun())
}

/// In place of the viewer beside the prompt.
pub(crate) enum Viewing {}

impl Viewing {
    pub(crate) fn open(_: &str, _: &str) -> anyhow::Result<Self> {
        Err(without_rerun())
    }

    pub(crate) fn follow(&mut self, _: impl Sized) -> anyhow::Result<()> {
        match *self {}
    }

    pub(crate) fn end(self) -> anyhow::Result<()> {
        match self {}
    }
}

/// In place of the recording of a mission.
pub(crate) enum Saved {}

impl Saved {
    pub(crate) fn add(&mut self, _: impl Sized) {
        match *self {}
    }

    pub(crate) fn finish(self, _: impl Sized) -> Result<(), anyhow::Error> {
        match self {}
    }
}
