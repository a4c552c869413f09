//! A recording that goes through a pipe to a viewer, as it is made.

use std::io::{BufWriter, Write};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use rerun::external::re_build_info::CrateVersion;
use rerun::external::re_log_encoding::{Encoder, EncodingOptions};
use rerun::log::LogMsg;
use rerun::sink::{LogSink, SinkFlushError};

use crate::RecorderError;

/// Messages for whoever reads the other end of a pipe. `None` once nobody does.
pub(crate) struct Piped<W: Write>(Option<Encoder<BufWriter<W>>>);

impl<W: Write> Piped<W> {
    pub(crate) fn new(pipe: W) -> Self {
        let encoder =
            Encoder::new_eager(CrateVersion::LOCAL, EncodingOptions::PROTOBUF_COMPRESSED, BufWriter::new(pipe));
        Self(encoder.ok())
    }

    /// Without the footer, which grows with the recording: for a reader that knows what is in it.
    pub(crate) fn without_footer(pipe: W) -> Self {
        let mut piped = Self::new(pipe);
        piped.0.iter_mut().for_each(Encoder::do_not_emit_footer);
        piped
    }

    /// Hands a message over. Returns whether the other end is still read.
    pub(crate) fn take(&mut self, message: &LogMsg) -> bool {
        if self.0.as_mut().is_some_and(|encoder| encoder.append(message).is_err()) {
            self.0 = None;
        }
        self.0.is_some()
    }

    /// Hands over what waits in memory. Returns whether the other end is still read.
    fn flush(&mut self) -> bool {
        if self.0.as_mut().is_some_and(|encoder| encoder.flush_blocking().is_err()) {
            self.0 = None;
        }
        self.0.is_some()
    }

    /// Hands over the end, and closes the pipe. Returns whether the other end was read up to there.
    pub(crate) fn end(&mut self) -> bool {
        self.0.take().is_some_and(|mut encoder| encoder.finish().is_ok() && encoder.flush_blocking().is_ok())
    }
}

/// The sink of a recorder that writes into a pipe. The flight waits for a slow reader.
#[derive(Clone)]
pub(crate) struct PipeSink(Arc<Mutex<Piped<Box<dyn Write + Send>>>>);

impl PipeSink {
    pub(crate) fn new(pipe: Box<dyn Write + Send>) -> Self {
        Self(Arc::new(Mutex::new(Piped::new(pipe))))
    }

    /// Hands over the end.
    ///
    /// # Errors
    /// When nobody read up to there.
    pub(crate) fn end(&self) -> Result<(), RecorderError> {
        if self.lock().end() { Ok(()) } else { Err(RecorderError::Viewer(CLOSED.to_owned())) }
    }

    fn lock(&self) -> MutexGuard<'_, Piped<Box<dyn Write + Send>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

const CLOSED: &str = "the reader of the recording closed the pipe";

impl LogSink for PipeSink {
    fn send(&self, message: LogMsg) {
        self.lock().take(&message);
    }

    fn flush_blocking(&self, _timeout: Duration) -> Result<(), SinkFlushError> {
        if self.lock().flush() { Ok(()) } else { Err(SinkFlushError::failed(CLOSED)) }
    }
}
