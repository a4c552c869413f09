//! The options of what is recorded for the Rerun viewer.

use std::net::SocketAddr;
use std::num::NonZeroU64;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use clap::builder::{PathBufValueParser, TypedValueParser as _};
use clap::{ArgGroup, Args, ValueEnum};

use super::{SERVED_AT, ends_in};

#[derive(Debug, Args)]
#[command(next_help_heading = "Recording")]
#[command(group = ArgGroup::new("recorded").args(["save", "view", "serve"]).multiple(true))]
pub(crate) struct RecordArgs {
    /// Save a recording of every stage for the Rerun viewer.
    #[arg(long, value_name = "FLIGHT.rrd", value_parser = PathBufValueParser::new().try_map(a_file))]
    pub(crate) save: Option<PathBuf>,
    /// Show every stage live in the Rerun viewer.
    #[arg(long)]
    pub(crate) view: bool,
    /// Let viewers connect while the flight runs, and afterwards until Ctrl-C. Late ones see what came, up to 1 GiB.
    /// Port 0 takes a free one.
    #[arg(long, value_name = "ADDR:PORT", num_args = 0..=1, require_equals = true, default_missing_value = SERVED_AT)]
    pub(crate) serve: Option<SocketAddr>,
    /// Which page the viewer opens with; the others are a click away.
    #[arg(long, value_enum, default_value = "stages", requires = "recorded")]
    pub(crate) layout: LayoutArg,
    /// How much is recorded of each revolution.
    #[arg(long, value_enum, default_value = "default", requires = "recorded")]
    pub(crate) record: DetailArg,
    /// Record W and U exactly at every N-th revolution recorded. [default: 300, with --record full 1, with light never]
    #[arg(long, value_name = "N", requires = "recorded")]
    pub(crate) record_every: Option<NonZeroU64>,
    /// Record these revolutions alone (`seq`, both included): 100..200, 100.. or ..200.
    #[arg(long, value_name = "A..B", value_parser = range::<u64>, requires = "recorded")]
    pub(crate) record_revolutions: Option<Span<u64>>,
    /// Record this time alone, in seconds after the first revolution of the run: 12.5..20, 12.5.. or ..20.
    #[arg(long, value_name = "A..B", value_parser = range::<f64>, requires = "recorded")]
    pub(crate) record_seconds: Option<Span<f64>>,
    /// End a file after N revolutions and go on in FLIGHT-2.rrd, FLIGHT-3.rrd...
    #[arg(long, value_name = "N", default_value = "6000", requires = "save")]
    pub(crate) record_part: NonZeroU64,
}

/// A recording is written in parts, each ended by an index: a pipe takes none.
fn a_file(path: PathBuf) -> Result<PathBuf, &'static str> {
    if path == Path::new("-") {
        return Err("a recording is a file, not standard output: FLIGHT.rrd");
    }
    if ends_in(&path, "mcap") {
        return Err("what is saved is for the Rerun viewer, no MCAP recording: FLIGHT.rrd");
    }
    Ok(path)
}

/// Pages of a recording.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum LayoutArg {
    /// The flight: counts, places, margin, and the revolutions worth a look.
    Overview,
    /// One revolution, stage by stage.
    Stages,
    /// Time: what each stage took, and whether it keeps up with the sensor.
    Speed,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum DetailArg {
    /// No matrix; ranges, eigenvalues, labels, answer, explanation and times.
    Light,
    /// W and L as pictures and U of every revolution; exact W and U of some.
    Default,
    /// Exact W and U of every revolution as well.
    Full,
}

/// From and to, both included.
pub(crate) type Span<T> = RangeInclusive<T>;

/// A number that may stand at either end of a [`Span`].
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
    fn a_range_may_be_open_at_either_end_and_is_never_backwards() {
        assert_eq!(range::<u64>("100..200"), Ok(100..=200));
        assert_eq!(range::<u64>("100.."), Ok(100..=u64::MAX));
        assert_eq!(range::<f64>("..20.5"), Ok(0.0..=20.5));
        for wrong in ["", "5", "3..2", "a..b", "-1..2", "1...2"] {
            assert!(range::<f64>(wrong).is_err(), "{wrong}");
        }
        assert!(range::<f64>("NaN..2").is_err());
    }
}
