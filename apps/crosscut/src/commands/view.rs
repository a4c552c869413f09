//! `crosscut view`: shows recordings made by `run --save` in the viewer.

use std::path::PathBuf;

use crosscut_recorder::{Served, Show};

use crate::cli::ViewArgs;
use crate::diagnostics::Diagnostics;
use crate::exit::{Outcome, UsageError};
use crate::interrupt::stop_on_interrupt;
use crate::say::say;

/// Shows recordings until the viewer is closed, or until Ctrl-C.
pub(crate) fn view(args: &ViewArgs) -> anyhow::Result<Outcome> {
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
        layout: args.layout.map(Into::into),
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

/// Prints the addresses at which viewers can connect.
pub(crate) fn say_where(served: &Served) {
    say(format_args!("serving; to view it: rerun --connect {}", served.url));
    if let Some(page) = &served.web_url {
        say(format_args!("or in a browser: {page}"));
    }
    if served.at_every_address {
        say("from another machine: put this machine's address in place of 127.0.0.1");
    }
}
