//! Handling of signals.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread::Builder;
use std::time::{Duration, Instant};

use anyhow::Context;
use crosscut_ingest::stop_reading;
use crosscut_outfile::Whole;
use crosscut_pipeline::StopFlag;

use crate::exit::INTERRUPTED;
use crate::output::say;

/// A reader that is at work so long after a signal, as where a file is looked through, is ended: what was made is saved.
const READING: Duration = Duration::from_millis(500);
/// Work in progress that is not finished so long after that is given up: a reader may have stopped reading our output.
const GRACE: Duration = Duration::from_secs(10);

/// A second signal within this time is the same wish: `timeout` sends two, to the program and to its group.
const SAME_WISH: Duration = Duration::from_millis(200);

/// Whether a signal asked for the end.
static IS_REQUESTED: AtomicBool = AtomicBool::new(false);

/// How many outputs are being opened.
static OPENING: AtomicUsize = AtomicUsize::new(0);

/// Opens an output. A pipe is open only once it has a reader; nothing is made before, so a signal does not wait for it.
pub(crate) fn while_opening<T>(open: impl FnOnce() -> T) -> T {
    OPENING.fetch_add(1, Ordering::Relaxed);
    let opened = open();
    OPENING.fetch_sub(1, Ordering::Relaxed);
    opened
}

/// Whether a signal asked for the end, which is then why a command failed.
pub(crate) fn is_requested() -> bool {
    IS_REQUESTED.load(Ordering::Relaxed)
}

/// A flag that a signal (Ctrl-C, `kill`) sets, so that work in progress is finished. A second one quits at once.
pub(crate) fn stop_on_interrupt() -> anyhow::Result<StopFlag> {
    let stop = StopFlag::default();
    let set = stop.clone();
    let mut first: Option<Instant> = None;
    ctrlc::set_handler(move || {
        if let Some(first) = first {
            if first.elapsed() > SAME_WISH {
                std::process::exit(i32::from(INTERRUPTED));
            }
            return;
        }
        first = Some(Instant::now());
        IS_REQUESTED.store(true, Ordering::Relaxed);
        say("stopping after the scans in progress (a second signal, as of Ctrl-C, quits at once, without them)");
        set.set();
        let quit = || {
            std::thread::sleep(READING);
            stop_reading();
            if OPENING.load(Ordering::Relaxed) == 0 {
                std::thread::sleep(GRACE);
            }
            std::process::exit(i32::from(INTERRUPTED));
        };
        Builder::new().name("grace".to_owned()).spawn(quit).ok(); // without it, a second Ctrl-C is needed
    })
    .context("cannot listen for Ctrl-C")?;
    Ok(stop)
}

/// What Ctrl-C does to a session: it stops the command at work, and the session goes on. While none is at work, or at the second
/// time, it ends the program; but not at a prompt, which only a word or Ctrl-D ends.
pub(crate) struct CommandInterrupt {
    /// Asks the command to stop.
    stop: Arc<AtomicBool>,
    /// Whether the next Ctrl-C ends the program.
    ends: Arc<AtomicBool>,
    at_prompt: bool,
}

impl CommandInterrupt {
    /// Listens from now on. `stop` is set to stop the command.
    pub(crate) fn listen(stop: Arc<AtomicBool>, at_prompt: bool) -> anyhow::Result<Self> {
        let interrupt = Self { stop, ends: Arc::new(AtomicBool::new(!at_prompt)), at_prompt };
        let (stop, ends) = (Arc::clone(&interrupt.stop), Arc::clone(&interrupt.ends));
        ctrlc::set_handler(move || {
            if ends.swap(true, Ordering::Relaxed) {
                std::process::exit(i32::from(INTERRUPTED));
            }
            stop.store(true, Ordering::Relaxed);
        })
        .context("cannot listen for Ctrl-C")?;
        Ok(interrupt)
    }

    /// Does the work of a command, which Ctrl-C stops.
    pub(crate) fn while_working<T>(&self, work: impl FnOnce() -> T) -> T {
        self.set(false, false);
        let done = work();
        self.set(false, !self.at_prompt);
        done
    }

    fn set(&self, stop: bool, ends: bool) {
        self.stop.store(stop, Ordering::Relaxed);
        self.ends.store(ends, Ordering::Relaxed);
    }
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
/// the system ends the program without a word. `ctrlc` knows no such signal.
#[cfg(unix)]
pub(crate) fn limit_is_an_error() {
    let unused = std::sync::Arc::default();
    signal_hook::flag::register(signal_hook::consts::signal::SIGXFSZ, unused).ok(); // as without it
}

#[cfg(not(unix))]
pub(crate) fn limit_is_an_error() {}
