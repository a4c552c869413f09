//! A file that is of use from its first line on, and whose written part survives a kill.

use std::fs::File;
use std::io::{self, Write};
use std::path::Path;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::Builder;
use std::time::Duration;

use crate::Keep;
use crate::part::Part;

/// With [`Keep::ThroughPowerLoss`] a file is brought to the disk this often.
const SYNC_EVERY: Duration = Duration::from_secs(1);

/// A file that grows. It has its name from the first flush on; what had the name before is gone then. Everything up to the
/// last flush stays when the program ends or a write fails; a file that was never flushed is removed.
///
/// Clones write to the same file.
#[derive(Clone)]
pub struct Growing {
    inner: Arc<Mutex<Inner>>,
}

struct Inner {
    part: Part,
    /// Bytes written so far.
    written: u64,
    /// Bytes written at the last flush.
    flushed: u64,
    /// Why a write has failed. Nothing is written after that: there would be a hole before it.
    failed: Option<(io::ErrorKind, String)>,
    syncing: Option<Syncing>,
}

/// Brings the file to the disk on a thread of its own: a slow disk holds up nobody.
struct Syncing {
    due: SyncSender<()>,
    failed: Arc<Mutex<Option<io::Error>>>,
}

impl Growing {
    /// Begins the file, and holds it: a second program is refused.
    ///
    /// # Errors
    /// When it cannot be written, or another program writes to it.
    pub fn create(path: &Path, keep: Keep) -> io::Result<Self> {
        let part = Part::create(path, keep)?;
        let is_synced = part.is_file() && part.keep() == Keep::ThroughPowerLoss;
        let syncing = is_synced.then(|| Syncing::start(part.file())).transpose()?;
        let inner = Inner { part, written: 0, flushed: 0, failed: None, syncing };
        Ok(Self { inner: Arc::new(Mutex::new(inner)) })
    }

    /// Brings the file to the disk, if it is to survive a loss of power. Without this call that is done within a second.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn finish(&mut self) -> io::Result<()> {
        self.flush()?;
        let inner = self.lock();
        if inner.syncing.is_some() { inner.part.file().sync_all() } else { Ok(()) }
    }

    fn lock(&self) -> MutexGuard<'_, Inner> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Write for Growing {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.lock().write(bytes)
    }

    /// Keeps everything so far. The bytes must be of use as they are: whole lines, whole messages.
    fn flush(&mut self) -> io::Result<()> {
        self.lock().flush()
    }
}

impl Inner {
    fn check(&self) -> io::Result<()> {
        self.failed.as_ref().map_or(Ok(()), |(kind, words)| Err(io::Error::new(*kind, words.clone())))
    }

    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.check()?;
        match self.part.file().write(bytes) {
            Ok(count) => {
                self.written += count as u64;
                Ok(count)
            }
            Err(error) if error.kind() == io::ErrorKind::Interrupted => Err(error),
            Err(error) => {
                self.failed = Some((error.kind(), error.to_string()));
                if self.part.is_file()
                    && let Err(error) = self.part.cut(self.flushed)
                {
                    let words = format!("{error}; its last {} bytes are torn", self.written - self.flushed);
                    self.failed = Some((error.kind(), words));
                }
                Err(error)
            }
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        self.check()?;
        if self.written == self.flushed {
            return Ok(());
        }
        if self.flushed == 0 {
            self.part.take_name()?;
        }
        self.flushed = self.written;
        self.syncing.as_ref().map_or(Ok(()), Syncing::due)
    }
}

impl Syncing {
    fn start(file: &File) -> io::Result<Self> {
        let file = file.try_clone()?;
        let (due, wanted) = sync_channel(1);
        let failed = Arc::new(Mutex::new(None));
        let of_thread = Arc::clone(&failed);
        Builder::new().name("to disk".to_owned()).spawn(move || Self::run(&file, &wanted, &of_thread))?;
        Ok(Self { due, failed })
    }

    fn run(file: &File, wanted: &Receiver<()>, failed: &Mutex<Option<io::Error>>) {
        while wanted.recv().is_ok() {
            if let Err(error) = file.sync_data() {
                *failed.lock().unwrap_or_else(PoisonError::into_inner) = Some(error);
            }
            std::thread::sleep(SYNC_EVERY);
        }
    }

    /// Asks for the disk, unless that is asked for already; returns why it failed since the last call.
    fn due(&self) -> io::Result<()> {
        self.due.try_send(()).ok();
        self.failed.lock().unwrap_or_else(PoisonError::into_inner).take().map_or(Ok(()), Err)
    }
}
