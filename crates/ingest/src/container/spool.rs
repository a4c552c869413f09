//! Files that cannot be read where they are: compressed ones, and standard input. They are copied to a temporary file: in
//! `TMPDIR` if that is set, else in `/var/tmp`, else beside the file. `/tmp` is memory on many systems.

use std::fs::File;
use std::io::{self, Read, Write as _};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use tempfile::{Builder, NamedTempFile, TempPath};

use super::standard_input::StandardInput;
use crate::{Damage, limits, stopping};

const BUFFER_BYTES: usize = 256 * 1024;
/// The space on the disk is asked for again after this many bytes.
const ASK_EVERY_BYTES: u64 = 16 << 20;
/// This much space is left to others.
const LEFT_BYTES: u64 = 256 << 20;

/// A compression of whole files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Compression {
    Zstd,
    Lz4,
    Bzip2,
}

impl Compression {
    /// That of a file that begins with `start`.
    pub(super) fn of(start: &[u8]) -> Option<Self> {
        let signs: [(&[u8], _); 3] =
            [(b"\x28\xb5\x2f\xfd", Self::Zstd), (b"\x04\x22\x4d\x18", Self::Lz4), (b"BZh", Self::Bzip2)];
        signs.into_iter().find(|(sign, _)| start.starts_with(sign)).map(|(_, compression)| compression)
    }

    fn decoder<'a>(self, input: impl Read + Send + 'a) -> io::Result<Box<dyn Read + Send + 'a>> {
        Ok(match self {
            Self::Zstd => Box::new(zstd::stream::read::Decoder::new(input)?),
            Self::Lz4 => Box::new(lz4::Decoder::new(io::BufReader::new(input))?),
            Self::Bzip2 => Box::new(bzip2::read::MultiBzDecoder::new(input)),
        })
    }

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Zstd => "zstd",
            Self::Lz4 => "lz4",
            Self::Bzip2 => "bzip2",
        }
    }
}

/// A copy on disk, which goes away with the last clone of this value.
#[derive(Clone)]
pub(super) struct Spooled {
    pub(super) path: Arc<TempPath>,
    /// How it was compressed.
    pub(super) compression: Option<Compression>,
    /// Why it ends before its end, if it does.
    pub(super) damage: Option<Damage>,
}

/// The copy of standard input, once there is one, while somebody keeps it.
static KEPT: Mutex<Option<Option<Spooled>>> = Mutex::new(None);

/// While this value is there, the copy of standard input is kept: it can be opened more than once.
#[derive(Debug)]
pub struct KeptStandardInput(());

impl KeptStandardInput {
    /// Keeps what is read from now on.
    #[must_use = "the copy is removed with this value"]
    pub fn keep() -> Self {
        KEPT.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(None);
        Self(())
    }
}

impl Drop for KeptStandardInput {
    fn drop(&mut self) {
        *KEPT.lock().unwrap_or_else(PoisonError::into_inner) = None;
    }
}

/// An input that is decompressed if it is compressed as a whole.
pub(crate) struct Plain {
    /// Its first bytes, as many as the magic bytes of an MCAP.
    pub(crate) start: Vec<u8>,
    /// All behind them.
    pub(crate) rest: Box<dyn Read + Send>,
    compression: Option<Compression>,
}

impl Plain {
    /// Reads the first bytes of `input`.
    ///
    /// # Errors
    /// When they cannot be read.
    pub(crate) fn of(mut input: impl Read + Send + 'static) -> io::Result<Self> {
        let start = first_bytes(&mut input)?;
        let Some(compression) = Compression::of(&start) else {
            return Ok(Self { start, rest: Box::new(input), compression: None });
        };
        let mut rest = compression.decoder(io::Cursor::new(start).chain(input))?;
        Ok(Self { start: first_bytes(&mut rest)?, rest, compression: Some(compression) })
    }

    fn spool(self) -> io::Result<Spooled> {
        let spooled = copy(io::Cursor::new(self.start).chain(self.rest), None, limits::SPOOLED_BYTES)?;
        Ok(Spooled { compression: self.compression, ..spooled })
    }
}

fn first_bytes(input: &mut impl Read) -> io::Result<Vec<u8>> {
    let mut start = Vec::new();
    input.take(mcap::MAGIC.len() as u64).read_to_end(&mut start)?;
    Ok(start)
}

/// Copies standard input, unless its copy was kept.
///
/// # Errors
/// When there is no place on the disk for it.
pub(super) fn standard_input() -> io::Result<Spooled> {
    let mut kept = KEPT.lock().unwrap_or_else(PoisonError::into_inner);
    match &mut *kept {
        Some(Some(copied)) => Ok(copied.clone()),
        Some(empty) => Ok(empty.insert(Plain::of(StandardInput::open()?)?.spool()?).clone()),
        None => Plain::of(StandardInput::open()?)?.spool(),
    }
}

/// Copies standard input, of which the first bytes were read already, for those who open it from now on.
///
/// # Errors
/// When there is no place on the disk for it.
pub(crate) fn keep_standard_input(input: Plain) -> io::Result<()> {
    let copied = input.spool()?;
    *KEPT.lock().unwrap_or_else(PoisonError::into_inner) = Some(Some(copied));
    Ok(())
}

/// Decompresses the file at `path` up to where it is damaged, or larger than a recording of its size can be.
///
/// # Errors
/// When there is no place on the disk for it.
pub(super) fn decompress(path: &Path, file: File, compression: Compression) -> io::Result<Spooled> {
    let most = file.metadata()?.len().saturating_mul(limits::EXPANSION).saturating_add(limits::ANY_EXPANSION_BYTES);
    let (beside, limit) = (path.parent(), most.min(limits::SPOOLED_BYTES));
    let spooled = copy(compression.decoder(file)?, beside, limit)?;
    Ok(Spooled { compression: Some(compression), ..spooled })
}

/// Copies `input` up to where it cannot be read any more, or to `limit` bytes.
///
/// # Errors
/// When there is no place on the disk for it.
fn copy(mut input: impl Read, beside: Option<&Path>, limit: u64) -> io::Result<Spooled> {
    let mut file = temporary(beside)?;
    let mut buffer = vec![0; BUFFER_BYTES];
    let (mut bytes, mut asked) = (0, 0);
    let damage = loop {
        stopping::check()?;
        match input.read(&mut buffer) {
            Ok(0) => break None,
            Ok(count) => {
                bytes += count as u64;
                if bytes > limit {
                    break Some(Damage::TooLarge { bytes, limit });
                }
                if asked == 0 || bytes - asked > ASK_EVERY_BYTES {
                    ask_for_space(file.path())?;
                    asked = bytes;
                }
                file.write_all(&buffer[..count])?;
            }
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => break Some(error.into()),
        }
    };
    Ok(Spooled { path: Arc::new(file.into_temp_path()), compression: None, damage })
}

/// A temporary file on a disk.
fn temporary(beside: Option<&Path>) -> io::Result<NamedTempFile> {
    let beside = beside.map(|folder| if folder.as_os_str().is_empty() { Path::new(".") } else { folder });
    let chosen = std::env::var_os("TMPDIR").filter(|folder| !folder.is_empty()).map(PathBuf::from);
    let folders = match chosen {
        Some(folder) => vec![folder],
        None => [Path::new("/var/tmp")]
            .into_iter()
            .chain(beside)
            .map(Path::to_owned)
            .chain([std::env::temp_dir()])
            .collect(),
    };
    let mut in_folders = folders.iter().map(|folder| Builder::new().prefix("crosscut-").tempfile_in(folder));
    let first = in_folders.next().unwrap_or_else(NamedTempFile::new);
    first.or_else(|error| in_folders.find_map(Result::ok).ok_or(error))
}

/// Fails if the disk of a temporary file is nearly full.
#[cfg(unix)]
fn ask_for_space(path: &Path) -> io::Result<()> {
    let Ok(disk) = rustix::fs::statvfs(path) else { return Ok(()) }; // writing tells as well
    let free = disk.f_bavail.saturating_mul(disk.f_frsize);
    if free > LEFT_BYTES {
        return Ok(());
    }
    let folder = path.parent().unwrap_or(path).display();
    let words =
        format!("no room for a temporary copy in {folder}: {} MiB are free; set TMPDIR to another disk", free >> 20);
    Err(io::Error::new(io::ErrorKind::StorageFull, words))
}

#[cfg(not(unix))]
fn ask_for_space(_: &Path) -> io::Result<()> {
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_endless_input_ends_at_the_limit() {
        let spooled = copy(io::repeat(7), None, 1 << 20).expect("room on the disk");
        assert_eq!(std::fs::metadata(&*spooled.path).expect("a file").len(), 1 << 20);
        assert!(matches!(spooled.damage, Some(Damage::TooLarge { limit: 0x10_0000, .. })));
    }
}
