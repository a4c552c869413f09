//! `crosscut rrd`: the content of a recording, its values as files, and two recordings compared.

mod args;
mod diff;
mod exact;
mod get;
mod ls;
mod npy;
mod output;
mod selection;
mod table;

use std::path::Path;

use crosscut_detector::Registry;
use crosscut_rrd::{Damage, ReadError, Recording};

pub(crate) use self::args::RrdCommand;
use crate::exit::{Outcome, UsageError};
use crate::output::{say, show};

/// Lists, exports or compares.
pub(crate) fn rrd(command: &RrdCommand, registry: &Registry) -> anyhow::Result<Outcome> {
    match command {
        RrdCommand::Ls(args) => ls::ls(args),
        RrdCommand::Get(args) => get::get(args, registry),
        RrdCommand::Diff(args) => diff::diff(args),
    }
}

/// Lists a recording, with what else can be done with that.
pub(crate) fn describe(recording: &Path) -> anyhow::Result<Outcome> {
    let outcome = ls::ls(&args::RrdLsArgs { recording: recording.to_owned(), entity: None, config: false })?;
    let path = recording.display();
    show(format!("\nnext: crosscut view {path}, crosscut debug {path}, crosscut run {path} --set KEY=VALUE\n"))?;
    Ok(outcome)
}

/// Opens a recording: the one with this identifier, or else the only one of the file.
fn open(path: &Path, id: Option<&str>) -> anyhow::Result<Recording> {
    let opened = id.map_or_else(|| Recording::open(path), |id| Recording::open_one(path, id));
    opened.map_err(|error| match error {
        ReadError::Several { .. } => UsageError(format!("{error}; choose one with --recording ID")).into(),
        ReadError::NoSuchRecording { .. } => UsageError(error.to_string()).into(),
        error => error.into(),
    })
}

/// The path of an entity, which may be typed without its first slash.
fn entity_path(typed: &str) -> String {
    format!("/{}", typed.trim_start_matches('/'))
}

/// Reports what a recording lacks.
fn say_damages(recording: &Recording) -> Outcome {
    for damage in recording.damages() {
        say(format_args!("lost: {damage}"));
    }
    if recording.damages().iter().any(Damage::is_cut) {
        say("note: `rerun rrd optimize CUT.rrd -o WHOLE.rrd` gives it the footer that `rerun rrd verify` asks for");
    }
    if recording.damages().is_empty() { Outcome::Done } else { Outcome::SomethingLost }
}
