//! Handling of Ctrl-C.

use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Context;
use crosscut_pipeline::StopFlag;

use crate::exit::INTERRUPTED;
use crate::say::say;

/// A flag that Ctrl-C sets, so that work in progress is finished. A second Ctrl-C quits at once.
pub(crate) fn stop_on_interrupt() -> anyhow::Result<StopFlag> {
    let (stop, requested) = (StopFlag::default(), AtomicBool::new(false));
    let set = stop.clone();
    ctrlc::set_handler(move || {
        if requested.swap(true, Ordering::Relaxed) {
            std::process::exit(i32::from(INTERRUPTED));
        }
        say("stopping after the scans in progress (press Ctrl-C again to quit at once, without them)");
        set.set();
    })
    .context("cannot listen for Ctrl-C")?;
    Ok(stop)
}
