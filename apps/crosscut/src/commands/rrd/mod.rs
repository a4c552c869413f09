//! `crosscut rrd`: what is in a recording, its values as files, and two recordings compared.

mod diff;
mod exact;
mod get;
mod ls;
mod npy;
mod output;
mod parquet;
mod selection;
mod table;
mod unfinished;

use crosscut_recorder::Recording;

use crate::cli::RrdCommand;
use crate::exit::Outcome;
use crate::say::say;

/// Lists, exports or compares.
pub(crate) fn rrd(command: &RrdCommand) -> anyhow::Result<Outcome> {
    match command {
        RrdCommand::Ls(args) => ls::ls(args),
        RrdCommand::Get(args) => get::get(args),
        RrdCommand::Diff(args) => diff::diff(args),
    }
}

/// Says what is missing of a recording; what there is was read.
fn say_damages(recording: &Recording) -> Outcome {
    for damage in recording.damages() {
        say(format_args!("lost: {damage}"));
    }
    if recording.damages().is_empty() { Outcome::Done } else { Outcome::SomethingLost }
}
