//! The write-ahead log beside a file: pages that were written but not yet moved into it.

use std::collections::HashMap;
use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use crate::Damage;

const HEADER_BYTES: usize = 32;
const FRAME_HEADER_BYTES: usize = 24;
/// The first bytes; the last bit says that checksums are of big-endian words.
const MAGIC: u32 = 0x377f_0682;

/// The pages of a log up to its last complete transaction.
pub(super) struct Wal {
    path: PathBuf,
    /// Where the newest copy of each page is.
    places: HashMap<u32, u64>,
    page_count: u32,
}

impl Wal {
    /// The log beside the file `path`, if there is one with a complete transaction.
    pub(super) fn beside(path: &Path, page_bytes: usize) -> Option<Self> {
        let mut path = path.as_os_str().to_owned();
        path.push("-wal");
        let path = PathBuf::from(path);
        let mut input = BufReader::new(File::open(&path).ok()?);
        let mut header = [0; HEADER_BYTES];
        input.read_exact(&mut header).ok()?;
        let magic = word(&header, 0, true);
        let big_endian = magic & 1 == 1;
        let mut sum = checksum([0, 0], &header[..24], big_endian);
        let is_valid = magic & !1 == MAGIC
            && word(&header, 8, true) as usize == page_bytes
            && sum == [word(&header, 24, true), word(&header, 28, true)];
        if !is_valid {
            return None;
        }
        let (mut places, mut recent, mut page_count) = (HashMap::new(), Vec::new(), 0);
        let mut at_byte = HEADER_BYTES as u64;
        let mut frame = vec![0; FRAME_HEADER_BYTES + page_bytes];
        while input.read_exact(&mut frame).is_ok() {
            sum = checksum(sum, &frame[..8], big_endian);
            sum = checksum(sum, &frame[FRAME_HEADER_BYTES..], big_endian);
            if frame[8..16] != header[16..24] || sum != [word(&frame, 16, true), word(&frame, 20, true)] {
                break; // what is left is of an older use of the log, or was not written whole
            }
            recent.push((word(&frame, 0, true), at_byte + FRAME_HEADER_BYTES as u64));
            let pages_after = word(&frame, 4, true);
            if pages_after > 0 {
                places.extend(recent.drain(..));
                page_count = pages_after;
            }
            at_byte += frame.len() as u64;
        }
        (page_count > 0).then_some(Self { path, places, page_count })
    }

    /// How many pages the file has with the log.
    pub(super) fn page_count(&self) -> u32 {
        self.page_count
    }

    /// Reads a page into `out` if the log has it.
    pub(super) fn read(&mut self, page: u32, page_bytes: usize, out: &mut Vec<u8>) -> Result<bool, Damage> {
        let Some(&at_byte) = self.places.get(&page) else { return Ok(false) };
        out.resize(page_bytes, 0);
        let mut file = File::open(&self.path)?;
        file.seek(SeekFrom::Start(at_byte))?;
        file.read_exact(out)?;
        Ok(true)
    }
}

/// The checksum of SQLite's log over `bytes`, whose number is a multiple of 8, after `sum`.
fn checksum([mut a, mut b]: [u32; 2], bytes: &[u8], big_endian: bool) -> [u32; 2] {
    for at in (0..bytes.len()).step_by(8) {
        a = a.wrapping_add(word(bytes, at, big_endian)).wrapping_add(b);
        b = b.wrapping_add(word(bytes, at + 4, big_endian)).wrapping_add(a);
    }
    [a, b]
}

fn word(bytes: &[u8], at: usize, big_endian: bool) -> u32 {
    let word = [bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]];
    if big_endian { u32::from_be_bytes(word) } else { u32::from_le_bytes(word) }
}
