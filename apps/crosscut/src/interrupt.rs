//! Handling of signals.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::Builder;
use std::time::Duration;

use anyhow::Context;
use crosscut_outfile::Whole;
use crosscut_pipeline::StopFlag;

use crate::exit::INTERRUPTED;
use crate::say::say;

/// Work in progress that is not finished so long after a signal is given up: a reader may have stopped reading our output.
const GRACE: Duration = Duration::from_secs(10);

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
        let quit = || {
            std::thread::sleep(GRACE);
            std::process::exit(i32::from(INTERRUPTED));
        };
        Builder::new().name("grace".to_owned()).spawn(quit).ok(); // without it, a second Ctrl-C is needed
    })
    .context("cannot listen for Ctrl-C")?;
    Ok(stop)
}

/// Makes Ctrl-C end the program without the file, which is not finished.
pub(crate) fn quit_without(file: &Whole) -> anyhow::Result<()> {
    let part = file.part().map(Path::to_owned);
    ctrlc::set_handler(move || {
        if let Some(part) = &part {
            std::fs::remove_file(part).ok(); // finished, it has another name
        }
        std::process::exit(i32::from(INTERRUPTED));
    })
    .context("cannot listen for Ctrl-C")
}

/// Makes a write beyond the largest size of a file that the system allows (`ulimit -f`) an error as any other. Without this
/// the system ends the program without a word.
#[cfg(unix)]
pub(crate) fn limit_is_an_error() {
    let unused = std::sync::Arc::default();
    signal_hook::flag::register(signal_hook::consts::signal::SIGXFSZ, unused).ok(); // as without it
}

#[cfg(not(unix))]
pub(crate) fn limit_is_an_error() {}
