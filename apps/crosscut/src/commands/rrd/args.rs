//! The options of `crosscut rrd`; in a build without Rerun all that there is of it.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use crate::values::{number, seconds, tolerance};

#[derive(Debug, Subcommand)]
pub(crate) enum RrdCommand {
    /// List the entities of the recordings in a file with their components, revolutions and sizes.
    Ls(RrdLsArgs),
    /// Export the values of an entity: as NumPy array, CSV or text.
    Get(RrdGetArgs),
    /// Compare two recordings row by row and name the first revolution and stage that differ. Exit codes as of diff(1):
    /// 0 equal, 1 different, 2 failed; and 3 if the readable rows of a damaged recording are equal.
    Diff(RrdDiffArgs),
}

#[derive(Debug, Args)]
pub(crate) struct RrdLsArgs {
    /// Recording made with `run --save`.
    #[arg(value_name = "FLIGHT.rrd")]
    pub(super) recording: PathBuf,
    /// List all components of this entity, including those that control the drawing.
    pub(super) entity: Option<String>,
    /// Print the settings that the recording was made with, as TOML; without an entity nothing else.
    #[arg(long)]
    pub(super) config: bool,
}

#[derive(Debug, Args)]
pub(crate) struct RrdGetArgs {
    /// Recording made with `run --save`.
    #[arg(value_name = "FLIGHT.rrd")]
    pub(super) recording: PathBuf,
    /// Entity as `rrd ls` names it, such as /spectral/eigenvalues. /affinity/W is a picture; --exact recomputes it. Of its
    /// components the one that holds its numbers, unless one is named: /log:TextLog:text.
    #[arg(value_name = "ENTITY[:COMPONENT]")]
    pub(super) entity: String,
    /// Identifier of the recording, in a file that holds several.
    #[arg(long = "recording", value_name = "ID")]
    pub(super) id: Option<String>,
    /// Single revolution. [default: all]
    #[arg(long, value_name = "REVOLUTION", conflicts_with_all = ["from", "to"], value_parser = number::<u64>, allow_negative_numbers = true)]
    pub(super) at: Option<u64>,
    /// Start this many seconds after the first recorded revolution.
    #[arg(long, value_name = "S", value_parser = seconds, allow_negative_numbers = true)]
    pub(super) from: Option<f64>,
    /// Stop this many seconds after the first recorded revolution.
    #[arg(long, value_name = "S", value_parser = seconds, allow_negative_numbers = true)]
    pub(super) to: Option<f64>,
    /// Recompute W, L, U and all that follows in full precision from the recorded ranges and configuration.
    #[arg(long)]
    pub(super) exact: bool,
    /// Output: .npy or .csv; for text also .md, or `-` for standard output.
    #[arg(short, long, value_name = "FILE", default_value = "-")]
    pub(super) out: PathBuf,
}

#[derive(Debug, Args)]
pub(crate) struct RrdDiffArgs {
    /// Recording made with `run --save`.
    #[arg(value_name = "A.rrd")]
    pub(super) first: PathBuf,
    /// Second recording of the same flight.
    #[arg(value_name = "B.rrd")]
    pub(super) second: PathBuf,
    /// Identifier of the recording, in a file that holds several; once for each such file.
    #[arg(long = "recording", value_name = "ID")]
    pub(super) ids: Vec<String>,
    /// Largest difference of two numbers that count as equal.
    #[arg(long, value_name = "X", default_value_t = 0.0, value_parser = tolerance, allow_negative_numbers = true)]
    pub(super) tolerance: f64,
}

#[cfg(not(feature = "rerun"))]
pub(crate) fn rrd(_: &RrdCommand, _: &crosscut_detector::Registry) -> anyhow::Result<crate::exit::Outcome> {
    Err(crate::gate::without_rerun())
}
