//! What is recorded for the Rerun viewer, and how it is looked at.

use std::net::SocketAddr;
use std::num::NonZeroU64;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use crosscut_pipeline::Config;
use crosscut_stage::Observer;

#[derive(Debug, Args)]
#[command(next_help_heading = "Recording")]
pub(crate) struct RecordArgs {
    /// Save a recording of every stage for the Rerun viewer.
    #[arg(long, value_name = "FLIGHT.rrd")]
    pub(crate) save: Option<PathBuf>,
    /// Show every stage live in the Rerun viewer.
    #[arg(long)]
    pub(crate) view: bool,
    /// Let viewers connect while the flight runs, and afterwards until Ctrl-C. Late ones see what came, up to 1 GiB.
    /// Port 0 takes a free one.
    #[arg(long, value_name = "ADDR:PORT", num_args = 0..=1, require_equals = true, default_missing_value = "127.0.0.1:9877")]
    pub(crate) serve: Option<SocketAddr>,
    /// Which page the viewer opens with; the others are a click away.
    #[arg(long, value_enum, default_value = "stages")]
    pub(crate) layout: LayoutArg,
    /// How much is recorded of each revolution.
    #[arg(long, value_enum, default_value = "default")]
    pub(crate) record: DetailArg,
    /// Record W and U exactly at every N-th revolution recorded. [default: 300, with --record full 1, with light never]
    #[arg(long, value_name = "N")]
    pub(crate) record_every: Option<NonZeroU64>,
    /// Record these revolutions alone (`seq`, both included): 100..200, 100.. or ..200.
    #[arg(long, value_name = "A..B", value_parser = range::<u64>)]
    pub(crate) record_revolutions: Option<Span<u64>>,
    /// Record this time alone, in seconds after the first revolution: 12.5..20, 12.5.. or ..20.
    #[arg(long, value_name = "A..B", value_parser = range::<f64>)]
    pub(crate) record_seconds: Option<Span<f64>>,
    /// End a file after N revolutions and go on in FLIGHT-2.rrd, FLIGHT-3.rrd...
    #[arg(long, value_name = "N", default_value = "6000")]
    pub(crate) record_part: NonZeroU64,
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

/// Who sees the frames, and whether viewers can still connect when the flight is over.
type Observers = (Vec<Box<dyn Observer>>, bool);

/// The recorder, if one is asked for. A recording or a view that cannot be had is lost, the rest is not.
#[cfg(feature = "rerun")]
pub(crate) fn observers(
    args: &RecordArgs,
    input: &Path,
    config: &Config,
    live: bool,
    lost: &mut Vec<String>,
) -> anyhow::Result<Observers> {
    use crosscut_recorder::{Mounting, Recorder, RecorderError, RecorderOptions};

    if args.save.is_none() && !args.view && args.serve.is_none() {
        return Ok(Observers::default());
    }
    let ingest = config.params("ingest");
    let options = RecorderOptions {
        path: args.save.clone(),
        view: args.view,
        serve: args.serve,
        live,
        name: input.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
        config_toml: format!("# crosscut {}\n{config}", env!("CARGO_PKG_VERSION")),
        mounting: Mounting { yaw_rad: ingest.number("yaw_rad"), upside_down: ingest.flag("upside_down") },
        layout: args.layout.into(),
        scope: args.scope(),
    };
    let mut recorder = Recorder::new(options.clone());
    if let Err(error @ (RecorderError::NoViewer | RecorderError::Viewer(_) | RecorderError::Serve { .. })) = &recorder
        && args.save.is_some()
    {
        lost.push(error.to_string());
        recorder = Recorder::new(RecorderOptions { view: false, serve: None, ..options });
    }
    Ok(match recorder {
        Ok(recorder) => {
            recorder.served().inspect(|served| crate::view::say_where(served));
            let served = recorder.served().is_some();
            (vec![Box::new(recorder)], served)
        }
        Err(error) => {
            lost.push(error.to_string());
            Observers::default()
        }
    })
}

#[cfg(not(feature = "rerun"))]
pub(crate) fn observers(
    args: &RecordArgs,
    _: &Path,
    _: &Config,
    _: bool,
    _: &mut Vec<String>,
) -> anyhow::Result<Observers> {
    if args.save.is_some() || args.view || args.serve.is_some() {
        return Err(crate::exit::without_rerun());
    }
    Ok(Observers::default())
}

#[cfg(feature = "rerun")]
mod of_the_recorder {
    use crosscut_recorder::{Detail, Layout, Scope};

    use super::{DetailArg, LayoutArg, RecordArgs};

    impl From<LayoutArg> for Layout {
        fn from(layout: LayoutArg) -> Self {
            match layout {
                LayoutArg::Overview => Self::Overview,
                LayoutArg::Stages => Self::Stages,
                LayoutArg::Speed => Self::Speed,
            }
        }
    }

    impl From<DetailArg> for Detail {
        fn from(detail: DetailArg) -> Self {
            match detail {
                DetailArg::Light => Self::Light,
                DetailArg::Default => Self::Default,
                DetailArg::Full => Self::Full,
            }
        }
    }

    impl RecordArgs {
        pub(super) fn scope(&self) -> Scope {
            let all = Scope::default();
            Scope {
                detail: self.record.into(),
                exact_every: self.record_every,
                revolutions: self.record_revolutions.clone().unwrap_or(all.revolutions),
                seconds: self.record_seconds.clone().unwrap_or(all.seconds),
                part_revolutions: self.record_part,
            }
        }
    }
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
