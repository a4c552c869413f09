//! Files that cannot be read where they are: compressed ones, and standard input. They are copied to a temporary file.

use std::fs::File;
use std::io::{self, Read, Write as _};
use std::sync::{Arc, Mutex, PoisonError};

use tempfile::{NamedTempFile, TempPath};

use crate::{Damage, limits};

const BUFFER_BYTES: usize = 256 * 1024;

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

/// Copies standard input, unless its copy was kept.
///
/// # Errors
/// When there is no place on the disk for it.
pub(super) fn standard_input() -> io::Result<Spooled> {
    let mut kept = KEPT.lock().unwrap_or_else(PoisonError::into_inner);
    match &mut *kept {
        Some(Some(copied)) => Ok(copied.clone()),
        Some(empty) => Ok(empty.insert(copy(io::stdin().lock())?).clone()),
        None => copy(io::stdin().lock()),
    }
}

/// Decompresses a file up to where it is damaged.
///
/// # Errors
/// When there is no place on the disk for it.
pub(super) fn decompress(file: File, compression: Compression) -> io::Result<Spooled> {
    match compression {
        Compression::Zstd => copy(zstd::stream::read::Decoder::new(file)?),
        Compression::Lz4 => copy(lz4::Decoder::new(io::BufReader::new(file))?),
        Compression::Bzip2 => copy(bzip2::read::MultiBzDecoder::new(file)),
    }
}

/// Copies `input` up to where it cannot be read any more.
///
/// # Errors
/// When there is no place on the disk for it.
fn copy(input: impl Read) -> io::Result<Spooled> {
    copy_up_to(input, limits::DECOMPRESSED_BYTES)
}

fn copy_up_to(mut input: impl Read, limit: u64) -> io::Result<Spooled> {
    let mut file = NamedTempFile::new()?;
    let mut buffer = vec![0; BUFFER_BYTES];
    let mut bytes = 0;
    let damage = loop {
        match input.read(&mut buffer) {
            Ok(0) => break None,
            Ok(count) => {
                bytes += count as u64;
                if bytes > limit {
                    break Some(Damage::TooLarge { bytes, limit });
                }
                file.write_all(&buffer[..count])?;
            }
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => break Some(error.into()),
        }
    };
    Ok(Spooled { path: Arc::new(file.into_temp_path()), damage })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_endless_input_ends_at_the_limit() {
        let spooled = copy_up_to(io::repeat(7), 1 << 20).expect("room on the disk");
        assert_eq!(std::fs::metadata(&*spooled.path).expect("a file").len(), 1 << 20);
        assert!(matches!(spooled.damage, Some(Damage::TooLarge { limit: 0x10_0000, .. })));
    }
}
