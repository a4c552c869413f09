//! A part file: the bytes of a file that does not have its name yet.
//!
//! Own code, because the names of `tempfile` are random: a second program would not be refused, and what a killed one leaves
//! would stay.

use std::ffi::OsString;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Seek as _};
use std::path::{Path, PathBuf};

use crate::Keep;

/// The words of the error with which a second program is refused.
pub const BUSY: &str = "another program is writing to it";

/// An open file that takes the name `target` once. Dropped before that, it is removed.
pub(crate) struct Part {
    file: File,
    /// `None` for a pipe or a device, which has its name from the start.
    names: Option<Names>,
    keep: Keep,
    is_named: bool,
}

#[derive(Clone)]
struct Names {
    part: PathBuf,
    target: PathBuf,
}

impl Part {
    /// Opens the part file beside `path`, and holds both: a second call, of any program, is refused.
    pub(crate) fn create(path: &Path, keep: Keep) -> io::Result<Self> {
        // A file that is reached through a link is replaced where it is.
        let target = path.canonicalize().unwrap_or_else(|_| path.to_owned());
        if fs::metadata(&target).is_ok_and(|there| !there.is_file()) {
            let file = OpenOptions::new().write(true).open(&target)?;
            return Ok(Self { file, names: None, keep, is_named: true });
        }
        let mut name = OsString::from(".");
        name.push(target.file_name().ok_or(io::ErrorKind::InvalidInput)?);
        name.push(".part");
        let names = Names { part: target.with_file_name(name), target };
        let file = hold(&names.part)?;
        let part = Self { file, names: Some(names), keep, is_named: false };
        part.check_target()?;
        Ok(part)
    }

    /// The next part file of the same target, which this one has become. It was held all the time.
    pub(crate) fn next(&self) -> io::Result<Self> {
        let names = self.names.clone().ok_or(io::ErrorKind::Unsupported)?;
        let part = Self { file: hold(&names.part)?, names: Some(names), keep: self.keep, is_named: false };
        part.take_permissions()?;
        Ok(part)
    }

    /// Fails if a file is there that may not be written, or that another program writes to under its own name.
    fn check_target(&self) -> io::Result<()> {
        let Some(Names { target, .. }) = &self.names else { return Ok(()) };
        match OpenOptions::new().write(true).open(target) {
            Ok(there) => {
                lock(&there)?;
                self.take_permissions()
            }
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
            Err(error) => Err(error),
        }
    }

    /// Gives the part file the permissions of the file that it will replace.
    fn take_permissions(&self) -> io::Result<()> {
        match self.names.as_ref().map(|names| fs::metadata(&names.target)) {
            Some(Ok(there)) => self.file.set_permissions(there.permissions()),
            _ => Ok(()),
        }
    }

    pub(crate) fn file(&self) -> &File {
        &self.file
    }

    pub(crate) fn keep(&self) -> Keep {
        self.keep
    }

    /// Other than a pipe or a device.
    pub(crate) fn is_file(&self) -> bool {
        self.names.is_some()
    }

    /// Where the bytes are; `None` once they have their name.
    pub(crate) fn path(&self) -> Option<&Path> {
        self.names.as_ref().filter(|_| !self.is_named).map(|names| names.part.as_path())
    }

    /// Gives the file its name; what had it before is gone then.
    pub(crate) fn take_name(&mut self) -> io::Result<()> {
        let Some(Names { part, target }) = self.names.as_ref().filter(|_| !self.is_named) else { return Ok(()) };
        if self.keep == Keep::ThroughPowerLoss {
            self.file.sync_all()?; // before the name: else an empty file could have it after a loss of power
        }
        fs::rename(part, target)?;
        self.is_named = true;
        if self.keep == Keep::ThroughPowerLoss {
            sync_folder_of(target)?;
        }
        Ok(())
    }

    /// Forgets all bytes from `length` on.
    pub(crate) fn cut(&mut self, length: u64) -> io::Result<()> {
        self.file.set_len(length)?;
        self.file.seek(io::SeekFrom::Start(length)).map(|_| ())
    }
}

impl Drop for Part {
    fn drop(&mut self) {
        if let Some(path) = self.path() {
            fs::remove_file(path).ok(); // one that stays is taken over by the next program
        }
        if cfg!(unix) {
            self.file.unlock().ok(); // a thread may hold the file a little longer, to bring it to the disk
        }
    }
}

/// Opens and locks an empty file.
fn hold(path: &Path) -> io::Result<File> {
    loop {
        let file = OpenOptions::new().write(true).create(true).truncate(false).open(path)?;
        lock(&file)?;
        // Whoever held it until now may have given it its name, or removed it.
        if is_at(&file, path)? {
            file.set_len(0)?;
            return Ok(file);
        }
    }
}

fn lock(file: &File) -> io::Result<()> {
    // On other systems a lock would keep readers out as well. Where a file system has no locks, there are none.
    if cfg!(unix) && matches!(file.try_lock(), Err(TryLockError::WouldBlock)) {
        return Err(io::Error::new(io::ErrorKind::ResourceBusy, BUSY));
    }
    Ok(())
}

/// Whether `path` is the name of this file.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> io::Result<bool> {
    use std::os::unix::fs::MetadataExt as _;
    let identity = |metadata: fs::Metadata| (metadata.dev(), metadata.ino());
    let there = match fs::symlink_metadata(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(false),
        there => there?,
    };
    Ok(identity(file.metadata()?) == identity(there))
}

#[cfg(not(unix))]
fn is_at(_: &File, _: &Path) -> io::Result<bool> {
    Ok(true)
}

#[cfg(unix)]
fn sync_folder_of(path: &Path) -> io::Result<()> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    File::open(folder)?.sync_all()
}

/// Folders cannot be opened as files there.
#[cfg(not(unix))]
fn sync_folder_of(_: &Path) -> io::Result<()> {
    Ok(())
}
