//! The .rrd file: it holds whole messages only, and no error gets lost.
//!
//! Rerun's own file sink ends its thread at the first failed write and leaves a torn message behind, while later log
//! calls still succeed. This sink keeps the error and cuts the torn message off, so that the file stays readable.

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, TryLockError};
use std::time::Duration;

use crosscut_outfile::{Growing, Keep};
use rerun::StoreKind;
use rerun::external::re_build_info::CrateVersion;
use rerun::external::re_log_encoding::{EncodeError, Encoder, EncodingOptions};
use rerun::log::LogMsg;
use rerun::sink::{LogSink, SinkFlushError};

use crate::RecorderError;

/// An .rrd file being written, shared by the recorder and by Rerun's sink thread.
#[derive(Clone)]
pub(crate) struct RrdFile {
    shared: Arc<Mutex<Shared>>,
}

struct Shared {
    path: PathBuf,
    state: State,
    /// The message that every file of the recording begins with.
    store_info: Option<LogMsg>,
}

enum State {
    Writing { encoder: Encoder<Growing>, file: Growing },
    Ended,
    Failed(String),
}

impl RrdFile {
    /// Begins the file. One that is there is replaced with the first rows.
    pub(crate) fn create(path: &Path) -> Result<Self, RecorderError> {
        let shared = Shared { path: path.to_owned(), state: State::create(path)?, store_info: None };
        Ok(Self { shared: Arc::new(Mutex::new(shared)) })
    }

    /// Checks that no write has failed so far. It does not wait for a write in progress.
    ///
    /// # Errors
    /// When a write has failed.
    pub(crate) fn check(&self) -> Result<(), RecorderError> {
        let shared = match self.shared.try_lock() {
            Ok(shared) => shared,
            Err(TryLockError::Poisoned(poisoned)) => poisoned.into_inner(),
            Err(TryLockError::WouldBlock) => return Ok(()),
        };
        match &shared.state {
            State::Writing { .. } | State::Ended => Ok(()),
            State::Failed(cause) => Err(RecorderError::Write { path: shared.path.clone(), cause: cause.clone() }),
        }
    }

    /// Writes the footer. Nothing can be added afterwards.
    ///
    /// # Errors
    /// When this or an earlier write has failed.
    pub(crate) fn end(&self) -> Result<(), RecorderError> {
        let mut shared = self.lock();
        shared.step(Encoder::finish);
        if let State::Writing { file, .. } = &mut shared.state
            && let Err(error) = file.finish()
        {
            shared.fail(error.to_string());
        }
        if let State::Writing { .. } = &shared.state {
            shared.state = State::Ended;
        }
        drop(shared);
        self.check()
    }

    /// Ends the file and continues the recording in the file at `path`. All earlier messages must have been flushed.
    ///
    /// # Errors
    /// When the file cannot be ended, or the next one not created.
    pub(crate) fn continue_in(&self, path: &Path) -> Result<(), RecorderError> {
        self.end()?;
        let mut shared = self.lock();
        shared.state = State::create(path)?;
        path.clone_into(&mut shared.path);
        if let Some(store_info) = shared.store_info.clone() {
            shared.append(&store_info);
        }
        Ok(())
    }

    fn lock(&self) -> MutexGuard<'_, Shared> {
        self.shared.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl State {
    fn create(path: &Path) -> Result<Self, RecorderError> {
        let cannot = |cause: String| RecorderError::Create { path: path.to_owned(), cause };
        let file = Growing::create(path, Keep::ThroughPowerLoss).map_err(|e| cannot(e.to_string()))?;
        let encoder = Encoder::new_eager(CrateVersion::LOCAL, EncodingOptions::PROTOBUF_COMPRESSED, file.clone())
            .map_err(|e| cannot(cause_of(&e)))?;
        Ok(Self::Writing { encoder, file })
    }
}

impl Shared {
    /// The file has its name from its first rows on: until then an older one is there.
    fn append(&mut self, msg: &LogMsg) {
        self.step(|encoder| encoder.append(msg).map(|_| ()));
        if !matches!(msg, LogMsg::SetStoreInfo(_)) {
            self.keep();
        }
    }

    /// Keeps all messages so far.
    fn keep(&mut self) {
        if let State::Writing { file, .. } = &mut self.state
            && let Err(error) = file.flush()
        {
            self.fail(error.to_string());
        }
    }

    /// Lets the encoder write. After an error the file holds the messages before, and is never written again.
    fn step(&mut self, write: impl FnOnce(&mut Encoder<Growing>) -> Result<(), EncodeError>) {
        if let State::Writing { encoder, .. } = &mut self.state
            && let Err(error) = write(encoder)
        {
            self.fail(cause_of(&error));
        }
    }

    fn fail(&mut self, cause: String) {
        if let State::Writing { encoder, .. } = std::mem::replace(&mut self.state, State::Failed(cause)) {
            encoder.into_inner().ok(); // dropped, it would write its end
        }
    }
}

impl LogSink for RrdFile {
    fn send(&self, msg: LogMsg) {
        let mut shared = self.lock();
        shared.append(&msg);
        if matches!(&msg, LogMsg::SetStoreInfo(info) if info.info.store_id.kind() == StoreKind::Recording) {
            shared.store_info = Some(msg);
        }
    }

    /// Nothing to do: every message is written when it is sent. [`RrdFile::check`] reports whether that worked.
    fn flush_blocking(&self, _timeout: Duration) -> Result<(), SinkFlushError> {
        Ok(())
    }
}

/// The message of the operating system alone, if the error has one.
fn cause_of(error: &EncodeError) -> String {
    match error {
        EncodeError::Write(io) => io.to_string(),
        other => other.to_string(),
    }
}
