//! The options of the recording for the Rerun viewer.

use std::net::SocketAddr;
use std::path::{Path, PathBuf};

use clap::builder::{PathBufValueParser, TypedValueParser as _};
use clap::{ArgGroup, Args, ValueEnum};

use super::SERVED_AT;
use super::values::has_extension;

#[derive(Debug, Args)]
#[command(next_help_heading = "Recording")]
#[command(group = ArgGroup::new("recorded").args(["save", "view", "serve"]).multiple(true))]
pub(crate) struct RecordArgs {
    /// Save a recording of all stages for the Rerun viewer.
    #[arg(long, value_name = "FLIGHT.rrd", value_parser = PathBufValueParser::new().try_map(rrd_path))]
    pub(crate) save: Option<PathBuf>,
    /// Show all stages live in the Rerun viewer.
    #[arg(long)]
    pub(crate) view: bool,
    /// Let viewers connect during the run, and afterwards until Ctrl-C. A viewer that connects late receives the last
    /// 1 GiB. Port 0 selects a free port.
    #[arg(long, value_name = "ADDR:PORT", num_args = 0..=1, require_equals = true, default_missing_value = SERVED_AT)]
    pub(crate) serve: Option<SocketAddr>,
    /// Page that the viewer opens with; the others are one click away.
    #[arg(long, value_enum, default_value = "stages", requires = "recorded")]
    pub(crate) layout: LayoutArg,
    #[command(flatten)]
    pub(crate) scope: ScopeArgs,
}

/// How much is recorded.
#[derive(Debug, Args)]
#[command(next_help_heading = "Recording")]
pub(crate) struct ScopeArgs {
    /// Amount of data recorded of each revolution. The same as --set recording.detail=DETAIL; the other settings of
    /// [recording] choose revolutions and times.
    #[arg(long, value_enum, requires = "recorded")]
    pub(crate) detail: Option<DetailArg>,
}

impl ScopeArgs {
    /// What was chosen, as a setting.
    pub(crate) fn setting(&self) -> Option<String> {
        let detail = self.detail.as_ref()?.to_possible_value()?;
        Some(format!("recording.detail=\"{}\"", detail.get_name()))
    }
}

/// Refuses a pipe: a recording is written in parts, each with an index at its end.
pub(crate) fn rrd_path(path: PathBuf) -> Result<PathBuf, &'static str> {
    if path == Path::new("-") {
        return Err("a recording is a file, not standard output: FLIGHT.rrd");
    }
    if has_extension(&path, "mcap") {
        return Err("--save writes a recording for the Rerun viewer, not an MCAP recording: FLIGHT.rrd");
    }
    if has_extension(&path, "jsonl") || has_extension(&path, "json") {
        return Err("--save writes a recording for the Rerun viewer: FLIGHT.rrd; results are -o FILE.jsonl");
    }
    Ok(path)
}

/// Pages of a recording.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum LayoutArg {
    /// The whole flight: counts, places, margin, and the revolutions to look at first.
    Overview,
    /// One revolution, stage by stage.
    Stages,
    /// The map of the flight: the way, the walls, places and passages.
    Map,
    /// Time of each stage, and whether the stages keep up with the sensor.
    Speed,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum DetailArg {
    /// Ranges, eigenvalues, labels, results, explanation and times; no matrix.
    Light,
    /// In addition U, and W and L as pictures, of every revolution; exact W and U of some.
    Default,
    /// In addition exact W and U of every revolution.
    Full,
}
