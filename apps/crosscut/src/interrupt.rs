//! Ctrl-C.

use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Context;
use crosscut_pipeline::StopFlag;

use crate::exit::INTERRUPTED;
use crate::say::say;

/// Ctrl-C stops what sees to `stop`, and lets the rest drain; a second one quits.
pub(crate) fn stop_on_interrupt(stop: StopFlag) -> anyhow::Result<()> {
    let asked = AtomicBool::new(false);
    ctrlc::set_handler(move || {
        if asked.swap(true, Ordering::Relaxed) {
            std::process::exit(i32::from(INTERRUPTED));
        }
        say("stopping, with what is being worked on (again to quit at once, without it)");
        stop.set();
    })
    .context("cannot listen for Ctrl-C")
}
