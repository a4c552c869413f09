//! Output files. No output replaces an input, another output, or a file that another run writes to; each is opened
//! before the work begins.

use std::ffi::OsStr;
use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use anyhow::Context;
use crosscut_outfile::{Growing, Keep, Replaced};

use crate::exit::UsageError;
use crate::input::config;
use crate::interrupt::while_opening;

/// Opens an output that grows, or standard output for `-`. Refuses one of the files `read` and a file that another run
/// writes to. An existing file keeps its contents until the first flush, and a file that is never flushed is not there.
pub(crate) fn grow(path: &Path, read: &[PathBuf]) -> anyhow::Result<Box<dyn Write + Send>> {
    if path == Path::new("-") {
        return Ok(Box::new(standard_output().context("cannot write to standard output")?));
    }
    refuse(&[path], read)?;
    let cannot = || format!("cannot write {}", path.display());
    Ok(Box::new(while_opening(|| Growing::create(path, Keep::ThroughPowerLoss)).with_context(cannot)?))
}

/// An output that is written as a whole, once or again and again. Until then an existing file keeps its contents.
pub(crate) struct Document {
    path: PathBuf,
    out: Out,
}

enum Out {
    StandardOutput(File),
    File(Replaced),
}

impl Document {
    /// Opens a file, or standard output for `-`. Refuses one of the files `read` and a file that another run writes to.
    pub(crate) fn create(path: &Path, read: &[PathBuf], keep: Keep) -> anyhow::Result<Self> {
        let out = if path == Path::new("-") {
            Out::StandardOutput(standard_output().context("cannot write to standard output")?)
        } else {
            refuse(&[path], read)?;
            let cannot = || format!("cannot write {}", path.display());
            Out::File(while_opening(|| Replaced::create(path, keep)).with_context(cannot)?)
        };
        Ok(Self { path: path.to_owned(), out })
    }

    /// Whether it can be written again: of a pipe, everything that is ever written is read.
    pub(crate) fn is_file(&self) -> bool {
        matches!(&self.out, Out::File(file) if file.is_file())
    }

    /// Writes all of it.
    pub(crate) fn write(&mut self, text: &str) -> anyhow::Result<()> {
        let written = match &mut self.out {
            Out::StandardOutput(out) => out.write_all(text.as_bytes()),
            Out::File(file) => file.replace(text),
        };
        written.with_context(|| format!("cannot write {}", self.path.display()))
    }
}

/// Standard output. `io::stdout()` reports no error where it cannot be written to at all.
#[cfg(unix)]
pub(crate) fn standard_output() -> io::Result<File> {
    use std::os::fd::AsFd as _;
    if is_closed() {
        return Err(io::Error::other("it is closed"));
    }
    io::stdout().as_fd().try_clone_to_owned().map(File::from)
}

#[cfg(windows)]
pub(crate) fn standard_output() -> io::Result<File> {
    use std::os::windows::io::AsHandle as _;
    io::stdout().as_handle().try_clone_to_owned().map(File::from)
}

/// Where standard output is closed, Rust opens `/dev/null` in its place before the program begins, for reading as well. A
/// shell's `>/dev/null` is for writing alone.
#[cfg(unix)]
fn is_closed() -> bool {
    const ACCESS: u32 = 0o3;
    const READ_AND_WRITE: u32 = 0o2;
    let is_null = std::fs::read_link("/proc/self/fd/1").is_ok_and(|to| to == Path::new("/dev/null"));
    let info = std::fs::read_to_string("/proc/self/fdinfo/1").unwrap_or_default();
    let flags = info.lines().find_map(|line| line.strip_prefix("flags:"));
    let flags = flags.and_then(|flags| u32::from_str_radix(flags.trim(), 8).ok());
    is_null && flags.is_some_and(|flags| flags & ACCESS == READ_AND_WRITE)
}

/// Refuses an output that is one of the files `read` or belongs to one, the file of settings that was found, or the same file as
/// another output.
pub(crate) fn refuse(outputs: &[&Path], read: &[PathBuf]) -> Result<(), UsageError> {
    let settings = config::found().map(|found| found.path);
    for (i, output) in outputs.iter().enumerate() {
        // `-` reads standard input and writes standard output.
        let is_input = |read: &PathBuf| is_same_file(read, output) || belongs_to(output, read);
        if *output != Path::new("-") && read.iter().chain(&settings).any(is_input) {
            return Err(UsageError(format!("{} would be overwritten; write to another file", output.display())));
        }
        if outputs[..i].iter().any(|other| is_same_file(other, output)) {
            return Err(UsageError(format!(
                "{} would be overwritten by another output; write to two files",
                output.display()
            )));
        }
    }
    Ok(())
}

/// Whether a file is read with the input `read` beside it: a later part of a recording, or the description and the log of a
/// rosbag2.
fn belongs_to(file: &Path, read: &Path) -> bool {
    let (Some((folder, name)), Some((of, input))) = (place(file), place(read)) else { return false };
    let is_log = name.to_str().and_then(|name| name.strip_suffix("-wal")) == input.to_str();
    folder == of && (is_log || name == "metadata.yaml" || is_later_part(name, read))
}

/// Whether a file of this name is a later part (FLIGHT-2.rrd...) of a recording beside it.
#[cfg(feature = "rerun")]
fn is_later_part(name: &OsStr, recording: &Path) -> bool {
    crosscut_rrd::parts::part_number(recording, name).is_some()
}

#[cfg(not(feature = "rerun"))]
fn is_later_part(_: &OsStr, _: &Path) -> bool {
    false
}

/// Refuses a recording if one of its later parts would replace one of the `others`.
pub(crate) fn refuse_parts<'a>(recording: &Path, others: impl IntoIterator<Item = &'a Path>) -> Result<(), UsageError> {
    let Some((folder, _)) = place(recording) else { return Ok(()) };
    // An existing file with the name of a part may be a link to one of the others.
    let files = std::fs::read_dir(&folder).into_iter().flatten().flatten().map(|file| file.file_name());
    let parts: Vec<_> = files.filter(|name| is_later_part(name, recording)).map(|name| folder.join(name)).collect();
    for other in others {
        let would_be_part = place(other).is_some_and(|(of, name)| of == folder && is_later_part(name, recording));
        if would_be_part || parts.iter().any(|part| is_same_file(part, other)) {
            let (other, recording) = (other.display(), recording.display());
            return Err(UsageError(format!(
                "{other} would be overwritten by a later part of {recording}; save under another name"
            )));
        }
    }
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
