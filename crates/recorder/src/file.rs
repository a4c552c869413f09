//! The .rrd file: whole messages only, and no error lost.
//!
//! Rerun's own file sink ends its thread at the first failed write and leaves a torn message behind; later log calls
//! still succeed. This one keeps the reason and cuts the torn message off, so that what was recorded stays readable.

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
    /// What every file of the recording begins with.
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

    /// Whether everything so far was written. A write that is going on is not waited for.
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
    pub(crate) fn end(&self) -> Result<(), RecorderError> {
        self.lock().step(Encoder::finish);
        self.check()?;
        self.lock().state = State::Ended;
        Ok(())
    }

    /// Ends the file and goes on in another one, which belongs to the same recording. All messages sent before have to
    /// be flushed.
    pub(crate) fn go_on_in(&self, path: &Path) -> Result<(), RecorderError> {
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

/// An empty file that no other run writes to. What is there stays until that is known.
fn create(path: &Path) -> io::Result<File> {
    let file = OpenOptions::new().write(true).create(true).truncate(false).open(path)?;
    // Elsewhere a lock would keep readers out as well.
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

    /// Lets the encoder write; after an error, cuts the file back to its last whole message and writes no more.
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

    /// Every message is written when it is sent; whether that worked, the recorder asks [`RrdFile::check`].
    fn flush_blocking(&self, _timeout: Duration) -> Result<(), SinkFlushError> {
        Ok(())
    }
}

/// The operating system's words alone, where there are any.
fn cause_of(error: &EncodeError) -> String {
    match error {
        EncodeError::Write(io) => io.to_string(),
        other => other.to_string(),
    }
}
