//! `crosscut view`: shows recordings made by `run --save` in the viewer.

use std::net::SocketAddr;
use std::path::PathBuf;

use clap::{Args, ValueEnum};

use crate::exit::Outcome;
use crate::output::record::SERVED_AT;
use crate::values::number;

#[derive(Debug, Args)]
pub(crate) struct ViewArgs {
    /// Recording made with `run --save`; its further parts (FLIGHT-2.rrd...) are shown as well.
    #[arg(required = true, value_name = "FLIGHT.rrd")]
    flight: Vec<PathBuf>,
    /// Page that the viewer opens with. [default: the page of --beside if that is given, else that of the
    /// recording: stages, or the mission]
    #[arg(long, value_enum)]
    layout: Option<LayoutArg>,
    /// Revolution to open at. [default: the last]
    #[arg(long, value_name = "REVOLUTION", conflicts_with = "serve", value_parser = number::<u64>, allow_negative_numbers = true)]
    at: Option<u64>,
    /// Second recording, shown side by side with the first; or MCAP recordings of the flight, to show their point clouds,
    /// cameras and transforms as well.
    #[arg(long, value_name = "OTHER.rrd|FLIGHT.mcap")]
    beside: Vec<PathBuf>,
    /// Let viewers connect until Ctrl-C instead of opening one. Port 0 selects a free port.
    #[arg(long, value_name = "ADDR:PORT", num_args = 0..=1, require_equals = true, default_missing_value = SERVED_AT)]
    serve: Option<SocketAddr>,
}

/// Pages of a recording.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum LayoutArg {
    /// The whole flight: counts, places, margin, and the revolutions to look at first.
    Overview,
    /// One revolution, stage by stage.
    Stages,
    /// The map of the flight: the way, the walls, places and passages.
    Map,
    /// Time of each stage, and whether the stages keep up with the sensor.
    Speed,
}

#[cfg(not(feature = "rerun"))]
pub(crate) fn view(_: &ViewArgs) -> anyhow::Result<Outcome> {
    Err(crate::gate::without_rerun())
}

/// Shows recordings until the viewer is closed, or until Ctrl-C.
#[cfg(feature = "rerun")]
pub(crate) fn view(args: &ViewArgs) -> anyhow::Result<Outcome> {
    use crosscut_recorder::{Layout, Show};

    use crate::diagnostics::Diagnostics;
    use crate::exit::UsageError;
    use crate::interrupt::stop_on_interrupt;
    use crate::output::observers::say_where;

    let is_mcap = |path: &&PathBuf| path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("mcap"));
    let (sensors, beside): (Vec<_>, Vec<_>) = args.beside.iter().partition(is_mcap);
    if beside.len() > 1 || !(beside.is_empty() || sensors.is_empty()) {
        let text = "one recording is shown beside another, or MCAP recordings beside one";
        return Err(UsageError(text.to_owned()).into());
    }
    let show = Show {
        flight: args.flight.clone(),
        beside: beside.into_iter().cloned().collect(),
        sensors: sensors.into_iter().cloned().collect(),
        layout: args.layout.map(|layout| match layout {
            LayoutArg::Overview => Layout::Overview,
            LayoutArg::Stages => Layout::Stages,
            LayoutArg::Map => Layout::Map,
            LayoutArg::Speed => Layout::Speed,
        }),
        at: args.at,
    };
    let damages = match args.serve {
        None => show.in_viewer()?,
        Some(address) => {
            let stop = stop_on_interrupt()?;
            show.served(address, say_where, || stop.is_set())?
        }
    };
    let mut diagnostics = Diagnostics::default();
    diagnostics.lost_all(&damages);
    Ok(diagnostics.outcome())
}
