//! `crosscut view`: what `run --save` recorded, in the viewer.

use crosscut_pipeline::StopFlag;
use crosscut_recorder::{Served, Show};

use crate::cli::ViewArgs;
use crate::exit::Outcome;
use crate::interrupt::stop_on_interrupt;
use crate::say::say;

/// Shows recordings until the viewer is closed, or until Ctrl-C.
pub(crate) fn view(args: &ViewArgs) -> anyhow::Result<Outcome> {
    let show = Show {
        flight: args.flight.clone(),
        beside: args.beside.iter().cloned().collect(),
        sensors: args.with.clone(),
        layout: args.layout.map(Into::into),
    };
    let damages = match args.serve {
        None => show.in_viewer()?,
        Some(address) => {
            let stop = StopFlag::default();
            stop_on_interrupt(stop.clone())?;
            show.served(address, say_where, || stop.is_set())?
        }
    };
    for damage in &damages {
        say(format_args!("lost: {damage}"));
    }
    Ok(if damages.is_empty() { Outcome::Done } else { Outcome::SomethingLost })
}

/// Says where viewers can connect.
pub(crate) fn say_where(served: &Served) {
    say(format_args!("serving; to see it: rerun --connect {}", served.url));
    if let Some(page) = &served.web_url {
        say(format_args!("or in a browser: {page}"));
    }
}
