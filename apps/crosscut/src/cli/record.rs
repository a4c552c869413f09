//! The options of the recording for the Rerun viewer.

use std::net::SocketAddr;
use std::num::NonZeroU64;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use clap::builder::{PathBufValueParser, TypedValueParser as _};
use clap::{ArgGroup, Args, ValueEnum};

use super::{SERVED_AT, has_extension};

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

/// How much of which revolutions is recorded.
#[derive(Debug, Args)]
#[command(next_help_heading = "Recording")]
pub(crate) struct ScopeArgs {
    /// Amount of data recorded of each revolution.
    #[arg(long, value_enum, default_value = "default", requires = "recorded")]
    pub(crate) record: DetailArg,
    /// Record exact W and U at every N-th recorded revolution. [default: 300; 1 with --record full; never with light]
    #[arg(long, value_name = "N", requires = "recorded")]
    pub(crate) record_every: Option<NonZeroU64>,
    /// Record only these revolutions (`seq`, both ends included): 100..200, 100.. or ..200.
    #[arg(long, value_name = "A..B", value_parser = range::<u64>, requires = "recorded")]
    pub(crate) record_revolutions: Option<Span<u64>>,
    /// Record only this time, in seconds after the first revolution of the run: 12.5..20, 12.5.. or ..20.
    #[arg(long, value_name = "A..B", value_parser = range::<f64>, requires = "recorded")]
    pub(crate) record_seconds: Option<Span<f64>>,
    /// Start a new file, FLIGHT-2.rrd, FLIGHT-3.rrd..., after every N revolutions.
    #[arg(long, value_name = "N", default_value = "6000", requires = "save")]
    pub(crate) record_part: NonZeroU64,
}

/// Refuses a pipe: a recording is written in parts, each with an index at its end.
pub(crate) fn rrd_path(path: PathBuf) -> Result<PathBuf, &'static str> {
    if path == Path::new("-") {
        return Err("a recording is a file, not standard output: FLIGHT.rrd");
    }
    if has_extension(&path, "mcap") {
        return Err("--save writes a recording for the Rerun viewer, not an MCAP recording: FLIGHT.rrd");
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

/// A range that includes both ends.
pub(crate) type Span<T> = RangeInclusive<T>;

/// A number type that a [`Span`] can have.
pub(crate) trait Bound: std::str::FromStr + PartialOrd + Copy {
    const FIRST: Self;
    const LAST: Self;
}

impl Bound for u64 {
    const FIRST: Self = 0;
    const LAST: Self = Self::MAX;
}

impl Bound for f64 {
    const FIRST: Self = 0.0;
    const LAST: Self = Self::INFINITY;
}

fn range<T: Bound>(text: &str) -> Result<Span<T>, String> {
    let wrong = || "A..B, A.. or ..B, with A not above B".to_owned();
    let (from, to) = text.split_once("..").ok_or_else(wrong)?;
    let end = |text: &str, missing: T| if text.is_empty() { Ok(missing) } else { text.parse().map_err(|_| wrong()) };
    let (from, to) = (end(from, T::FIRST)?, end(to, T::LAST)?);
    if from >= T::FIRST && from <= to { Ok(from..=to) } else { Err(wrong()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_span_may_be_open_but_never_backwards() {
        assert_eq!(range::<u64>("100..200"), Ok(100..=200));
        assert_eq!(range::<u64>("100.."), Ok(100..=u64::MAX));
        assert_eq!(range::<f64>("..20.5"), Ok(0.0..=20.5));
        for wrong in ["", "5", "3..2", "a..b", "-1..2", "1...2"] {
            assert!(range::<f64>(wrong).is_err(), "{wrong}");
        }
        assert!(range::<f64>("NaN..2").is_err());
    }
}
