//! Ends reading that takes long: a file without an index is looked through as a whole before its first scan is known.

use std::io;
use std::sync::atomic::{AtomicBool, Ordering};

static IS_STOPPED: AtomicBool = AtomicBool::new(false);

/// Ends all reading of this process: every reader finds an error in place of the next bytes of its file, and gives what it
/// has read. For programs that are told to end while a reader is at work.
pub fn stop_reading() {
    IS_STOPPED.store(true, Ordering::Relaxed);
}

/// An error once reading has to stop.
pub(crate) fn check() -> io::Result<()> {
    // `ErrorKind::Interrupted` would be tried again.
    if IS_STOPPED.load(Ordering::Relaxed) { Err(io::Error::other("reading was stopped by a signal")) } else { Ok(()) }
}
