//! The recordings that a command is given.

use std::path::PathBuf;

use crosscut_ingest::{Parts, parts_in, recordings_in};
use crosscut_stage::counted;

use crate::diagnostics::Diagnostics;
use crate::exit::UsageError;
use crate::input::InputArgs;
use crate::input::live::refuse_live;

/// The recordings that a command reads and its files of settings, which no output may replace.
pub(crate) fn files_read(
    args: &InputArgs,
    settings: impl IntoIterator<Item = PathBuf>,
) -> anyhow::Result<Vec<PathBuf>> {
    refuse_empty_span(args.from, args.to)?;
    refuse_live(args)?;
    Ok(recordings_in(&args.recordings.input)?.into_iter().chain(settings).collect())
}

/// The same for inputs that are read as they come, which need not be there yet.
pub(crate) fn files_to_come(
    args: &InputArgs,
    settings: impl IntoIterator<Item = PathBuf>,
) -> anyhow::Result<Vec<PathBuf>> {
    refuse_empty_span(args.from, args.to)?;
    Ok(recordings_in(&args.recordings.input).unwrap_or_default().into_iter().chain(settings).collect())
}

/// The recordings among these inputs, for a command that reads one after the other; what is missing of a folder, or left out,
/// is told.
pub(crate) fn each_of(inputs: &[PathBuf], diagnostics: &mut Diagnostics) -> anyhow::Result<Vec<PathBuf>> {
    let parts = parts_in(inputs)?;
    left_out_of_folders(&parts.left_out).iter().for_each(|note| diagnostics.note(note));
    let Parts { files, missing, left_out: _ } = parts;
    diagnostics.lost_all(missing);
    Ok(files)
}

/// A note on recordings of folders that are left out, if there are any.
pub(crate) fn left_out_of_folders(left_out: &[PathBuf]) -> Option<String> {
    let recordings = counted(left_out.len() as u64, "recording");
    Some(format!("left out {recordings} of another kind; name one to run it: {}", left_out.first()?.display()))
}

/// Refuses a span of time that ends before it begins.
pub(crate) fn refuse_empty_span(from_s: Option<f64>, to_s: Option<f64>) -> Result<(), UsageError> {
    match (from_s, to_s) {
        (Some(from), Some(to)) if from > to => Err(UsageError(format!("--from {from} is after --to {to}"))),
        _ => Ok(()),
    }
}
