//! The .rrd file: it holds whole messages only, and no error gets lost.
//!
//! Rerun's own file sink ends its thread at the first failed write and leaves a torn message behind, while later log
//! calls still succeed. This sink keeps the error and cuts the torn message off, so that the file stays readable.

use std::fs::{self, File, OpenOptions};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, TryLockError};
use std::time::Duration;

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
    Writing { encoder: Encoder<File>, whole_bytes: u64 },
    Ended,
    Failed(String),
}

impl RrdFile {
    /// Creates the file, or empties it.
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
        self.lock().step(Encoder::finish);
        self.check()?;
        self.lock().state = State::Ended;
        Ok(())
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
        let file = create(path).map_err(|e| cannot(e.to_string()))?;
        let encoder = Encoder::new_eager(CrateVersion::LOCAL, EncodingOptions::PROTOBUF_COMPRESSED, file)
            .map_err(|e| cannot(cause_of(&e)))?;
        let whole_bytes = fs::metadata(path).map_or(0, |m| m.len());
        Ok(Self::Writing { encoder, whole_bytes })
    }
}

/// Creates the file, or empties it once it is certain that no other run writes to it.
fn create(path: &Path) -> io::Result<File> {
    let file = OpenOptions::new().write(true).create(true).truncate(false).open(path)?;
    // On other systems a lock would keep readers out as well.
    if cfg!(unix) && matches!(file.try_lock(), Err(fs::TryLockError::WouldBlock)) {
        return Err(io::Error::other("another program is writing to it"));
    }
    if file.metadata()?.is_file() {
        file.set_len(0)?;
    }
    Ok(file)
}

impl Shared {
    fn append(&mut self, msg: &LogMsg) {
        if let Some(bytes) = self.step(|encoder| encoder.append(msg))
            && let State::Writing { whole_bytes, .. } = &mut self.state
        {
            *whole_bytes += bytes;
        }
    }

    /// Lets the encoder write. After an error the file is cut back to its last whole message and never written again.
    fn step<T>(&mut self, write: impl FnOnce(&mut Encoder<File>) -> Result<T, EncodeError>) -> Option<T> {
        let State::Writing { encoder, .. } = &mut self.state else { return None };
        match write(encoder) {
            Ok(written) => Some(written),
            Err(error) => {
                if let State::Writing { encoder, whole_bytes } =
                    std::mem::replace(&mut self.state, State::Failed(cause_of(&error)))
                    && let Ok(file) = encoder.into_inner()
                    && let Err(error) = file.set_len(whole_bytes)
                {
                    self.state = State::Failed(format!("{error}; its last message is torn"));
                }
                None
            }
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
