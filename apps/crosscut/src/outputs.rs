//! Output files. No output replaces an input, another output, or a file that another run writes to; each is opened
//! before the work begins.

use std::ffi::OsStr;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use anyhow::Context;

use crate::exit::UsageError;

/// Opens an output file, or standard output for `-`. Refuses one of the files `read` and a file that another run writes
/// to. An existing file keeps its contents until the first write; a new file to which nothing is written is removed.
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
    // On other systems a lock would exclude readers as well.
    if cfg!(unix) && matches!(file.try_lock(), Err(TryLockError::WouldBlock)) {
        anyhow::bail!("cannot write {}: another program is writing to it", path.display());
    }
    Ok(Box::new(OutputFile { file, new: is_new.then(|| path.to_owned()), written: 0, flushed: 0 }))
}

/// A file that is emptied at the first write, and cut back to its length at the last flush when a write fails.
struct OutputFile {
    file: File,
    /// The path of the file, if it is new.
    new: Option<PathBuf>,
    /// Bytes written so far.
    written: u64,
    /// Bytes written at the last flush.
    flushed: u64,
}

impl Drop for OutputFile {
    fn drop(&mut self) {
        if let Some(path) = self.new.take_if(|_| self.written == 0) {
            std::fs::remove_file(path).ok(); // a file that stays is empty and does no harm
        }
    }
}

impl Write for OutputFile {
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
                self.file.set_len(self.flushed).ok(); // the write's error is the one to report
                Err(error)
            }
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        self.flushed = self.written;
        self.file.flush()
    }
}

/// Refuses an output that is one of the files `read`, or the same file as another output.
pub(crate) fn refuse(outputs: &[&Path], read: &[PathBuf]) -> Result<(), UsageError> {
    for (i, output) in outputs.iter().enumerate() {
        // `-` reads standard input and writes standard output.
        let is_read = *output != Path::new("-") && read.iter().any(|read| is_same_file(read, output));
        if is_read || outputs[..i].iter().any(|other| is_same_file(other, output)) {
            return Err(UsageError(format!("{} would be overwritten; write to another file", output.display())));
        }
    }
    Ok(())
}

/// Refuses a recording if one of its later parts (FLIGHT-2.rrd...) would replace one of the `others`.
#[cfg(feature = "rerun")]
pub(crate) fn refuse_parts<'a>(recording: &Path, others: impl IntoIterator<Item = &'a Path>) -> Result<(), UsageError> {
    use crosscut_rrd::parts::part_number;

    let Some((folder, _)) = place(recording) else { return Ok(()) };
    // An existing file with the name of a part may be a link to one of the others.
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

/// Whether both paths name the same file, which need not exist.
fn is_same_file(a: &Path, b: &Path) -> bool {
    match (identity(a), identity(b)) {
        (Some(a), Some(b)) => a == b,
        (None, None) => a == b || place(a).is_some_and(|a| place(b) == Some(a)),
        _ => false,
    }
}

/// Identifies a file independent of its name, through links of both kinds. The file is not opened (as the crate
/// `same-file` would): opening a pipe blocks until its other end is opened.
#[cfg(unix)]
fn identity(path: &Path) -> Option<(u64, u64)> {
    use std::os::unix::fs::MetadataExt;
    path.metadata().ok().map(|file| (file.dev(), file.ino()))
}

#[cfg(not(unix))]
fn identity(path: &Path) -> Option<PathBuf> {
    path.canonicalize().ok()
}

/// The canonical folder and the name of a file that need not exist.
fn place(path: &Path) -> Option<(PathBuf, &OsStr)> {
    let (folder, name) = parts(path)?;
    Some((folder.canonicalize().ok()?, name))
}

fn parts(path: &Path) -> Option<(&Path, &OsStr)> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    Some((folder, path.file_name()?))
}
