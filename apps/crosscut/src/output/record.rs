//! The options of the recording for the Rerun viewer.

use std::net::SocketAddr;
use std::path::{Path, PathBuf};

use clap::Args;
use clap::builder::{PathBufValueParser, TypedValueParser as _};

use crate::values::has_extension;

/// The default address of --serve. Only viewers on this machine can connect to it.
pub(crate) const SERVED_AT: &str = "127.0.0.1:9877";

/// The heading of how a flight is recorded.
const RECORDING: &str = "Recording";

#[derive(Debug, Args)]
pub(crate) struct RecordArgs {
    /// Save a recording of all stages for the Rerun viewer. --set recording.detail=light makes it small, =full exact; the
    /// other settings of [recording] choose revolutions and times.
    #[arg(long, help_heading = RECORDING, value_name = "FLIGHT.rrd", value_parser = PathBufValueParser::new().try_map(rrd_path))]
    pub(crate) save: Option<PathBuf>,
    /// Show all stages live in the Rerun viewer.
    #[arg(long, help_heading = RECORDING)]
    pub(crate) view: bool,
    /// Let viewers connect during the run, and afterwards until Ctrl-C. A viewer that connects late receives the last
    /// 1 GiB. Port 0 selects a free port.
    #[arg(long, help_heading = RECORDING, value_name = "ADDR:PORT", num_args = 0..=1, require_equals = true, default_missing_value = SERVED_AT)]
    pub(crate) serve: Option<SocketAddr>,
}

impl RecordArgs {
    /// Whether the flight is recorded.
    pub(crate) fn is_asked(&self) -> bool {
        self.save.is_some() || self.view || self.serve.is_some()
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
