//! Files that are written: none that is read, none twice, none that another run writes to, and each opened before the
//! work begins.

use std::ffi::OsStr;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use anyhow::Context;

use crate::exit::UsageError;

/// A file that is none of those `read`, and that no other run writes to, or standard output for `-`. What is there
/// already stays until something is written, and where nothing is, a new file goes again.
pub(crate) fn create(path: &Path, read: &[PathBuf]) -> anyhow::Result<Box<dyn Write + Send>> {
    if path == Path::new("-") {
        return Ok(Box::new(std::io::stdout()));
    }
    refuse(&[path], read)?;
    let cannot = || format!("cannot write {}", path.display());
    let is_new = !path.exists();
    let file = OpenOptions::new().write(true).create(true).truncate(false).open(path).with_context(cannot)?;
    if !file.metadata().with_context(cannot)?.is_file() {
        return Ok(Box::new(file)); // a pipe or a device
    }
    // Elsewhere a lock would keep readers out as well.
    if cfg!(unix) && matches!(file.try_lock(), Err(TryLockError::WouldBlock)) {
        anyhow::bail!("cannot write {}: another program is writing to it", path.display());
    }
    Ok(Box::new(Replaced { file, new: is_new.then(|| path.to_owned()), written: 0, whole: 0 }))
}

/// A file that is emptied when it is first written to, and cut back to what was whole at the last flush when the disk
/// is full.
struct Replaced {
    file: File,
    /// Its path, if there was none before.
    new: Option<PathBuf>,
    written: u64,
    whole: u64,
}

impl Drop for Replaced {
    fn drop(&mut self) {
        if let Some(path) = self.new.take_if(|_| self.written == 0) {
            std::fs::remove_file(path).ok(); // an empty file is in nobody's way
        }
    }
}

impl Write for Replaced {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.written == 0 {
            self.file.set_len(0)?;
        }
        match self.file.write(bytes) {
            Ok(count) => {
                self.written += count as u64;
                Ok(count)
            }
            Err(error) => {
                self.file.set_len(self.whole).ok(); // the first error says what is wrong
                Err(error)
            }
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        self.whole = self.written;
        self.file.flush()
    }
}

/// Refuses an output that is one of the files `read`, or that another output is written to already.
pub(crate) fn refuse(outputs: &[&Path], read: &[PathBuf]) -> Result<(), UsageError> {
    for (i, output) in outputs.iter().enumerate() {
        let is_read = read.iter().any(|read| is_same_file(read, output));
        if is_read || outputs[..i].iter().any(|other| is_same_file(other, output)) {
            return Err(UsageError(format!("{} would be overwritten; write to another file", output.display())));
        }
    }
    Ok(())
}

/// Refuses a recording of which a later part (FLIGHT-2.rrd...) would be written over one of the `others`.
#[cfg(feature = "rerun")]
pub(crate) fn refuse_parts<'a>(recording: &Path, others: impl IntoIterator<Item = &'a Path>) -> Result<(), UsageError> {
    use crosscut_rrd::parts::part_number;

    let Some((folder, _)) = place(recording) else { return Ok(()) };
    // Parts that are there already may be known by other names as well.
    let files = std::fs::read_dir(&folder).into_iter().flatten().flatten().map(|file| file.file_name());
    let parts: Vec<_> =
        files.filter(|name| part_number(recording, name).is_some()).map(|name| folder.join(name)).collect();
    for other in others {
        let would_be_part =
            place(other).is_some_and(|(of, name)| of == folder && part_number(recording, name).is_some());
        if would_be_part || parts.iter().any(|part| is_same_file(part, other)) {
            let (other, recording) = (other.display(), recording.display());
            return Err(UsageError(format!(
                "{other} would be overwritten by a later part of {recording}; save under another name"
            )));
        }
    }
    Ok(())
}

#[cfg(not(feature = "rerun"))]
pub(crate) fn refuse_parts<'a>(_: &Path, _: impl IntoIterator<Item = &'a Path>) -> Result<(), UsageError> {
    Ok(())
}

/// Whether both names lead to the same file, or would if it were made.
fn is_same_file(a: &Path, b: &Path) -> bool {
    match (identity(a), identity(b)) {
        (Some(a), Some(b)) => a == b,
        (None, None) => a == b || place(a).is_some_and(|a| place(b) == Some(a)),
        _ => false,
    }
}

/// What a file is, whatever its name: links of both kinds lead to it. It is not opened, as the crate `same-file` would:
/// a pipe would keep us waiting for its other end.
#[cfg(unix)]
fn identity(path: &Path) -> Option<(u64, u64)> {
    use std::os::unix::fs::MetadataExt;
    path.metadata().ok().map(|file| (file.dev(), file.ino()))
}

#[cfg(not(unix))]
fn identity(path: &Path) -> Option<PathBuf> {
    path.canonicalize().ok()
}

/// The folder, without links, and the name of a file that need not be there.
fn place(path: &Path) -> Option<(PathBuf, &OsStr)> {
    let (folder, name) = parts(path)?;
    Some((folder.canonicalize().ok()?, name))
}

fn parts(path: &Path) -> Option<(&Path, &OsStr)> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    Some((folder, path.file_name()?))
}
