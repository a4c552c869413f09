//! The pages of a file, with those that its write-ahead log replaces.

use std::io::{self, BufReader, Read as _, Seek as _};
use std::path::Path;

use super::rows::{Cell, FILE_HEADER_BYTES, Record, u32_at};
use super::wal::Wal;
use crate::container::resting_file::RestingFile;
use crate::{Damage, limits};

/// The first bytes of every SQLite file.
pub(crate) const MAGIC: &[u8] = b"SQLite format 3\0";

const UTF_8: u32 = 1;
/// Pages are often read in the order of the file.
const BUFFER_BYTES: usize = 64 * 1024;

/// The pages of a file, numbered from 1.
pub(crate) struct Pages {
    input: BufReader<RestingFile>,
    page_bytes: usize,
    /// Bytes of a page that hold content.
    usable_bytes: usize,
    /// How many whole pages there are.
    count: u32,
    /// Bytes behind the last whole page.
    rest_bytes: usize,
    /// How many there would have to be.
    stated: u32,
    wal: Option<Wal>,
}

impl Pages {
    /// Reads the header of the file, and the log beside it. `path` is the file's name.
    pub(crate) fn open(path: &Path, file: RestingFile) -> Result<Self, Damage> {
        let bytes = file.length()?;
        let mut input = BufReader::with_capacity(BUFFER_BYTES, file);
        let mut header = [0; FILE_HEADER_BYTES];
        input.read_exact(&mut header)?;
        let u16_at = |at: usize| usize::from(u16::from_be_bytes([header[at], header[at + 1]]));
        let u32_at = |at: usize| u32::from_be_bytes([header[at], header[at + 1], header[at + 2], header[at + 3]]);
        let page_bytes = if u16_at(16) == 1 { 65_536 } else { u16_at(16) };
        let usable_bytes = page_bytes.saturating_sub(usize::from(header[20]));
        if !page_bytes.is_power_of_two() || page_bytes < 512 || usable_bytes < 480 {
            return Err(Damage::Record(format!("it has pages of {page_bytes} bytes, which cannot be")));
        }
        if ![0, UTF_8].contains(&u32_at(56)) {
            return Err(Damage::Record("its texts are in UTF-16".to_owned()));
        }
        let count = u32::try_from(bytes / page_bytes as u64).unwrap_or(u32::MAX - 1);
        let rest_bytes = (bytes % page_bytes as u64) as usize;
        // The stated number holds if both counters of changes agree.
        let stated = if u32_at(24) == u32_at(92) { u32_at(28) } else { 0 };
        let wal = Wal::beside(path, page_bytes);
        Ok(Self { input, page_bytes, usable_bytes, count, rest_bytes, stated, wal })
    }

    /// How many pages there are, with one of which only a part is there.
    pub(crate) fn count(&self) -> u32 {
        let count = self.count + u32::from(self.rest_bytes > 0);
        self.wal.as_ref().map_or(count, |wal| wal.page_count().max(count))
    }

    /// Whether pages are missing at the end, and where that is.
    pub(crate) fn cut_at_byte(&self) -> Option<u64> {
        (self.wal.is_none() && self.stated > self.count).then(|| self.at_byte(self.count + 1))
    }

    /// Where a page begins.
    pub(crate) fn at_byte(&self, page: u32) -> u64 {
        u64::from(page.saturating_sub(1)) * self.page_bytes as u64
    }

    /// Closes the file until it is read again.
    pub(crate) fn rest(&mut self) -> io::Result<()> {
        self.input.rewind()?;
        self.input.get_mut().rest()
    }

    /// Reads a page into `out`; of the page in which the file was cut off, what is there.
    pub(crate) fn read(&mut self, page: u32, out: &mut Vec<u8>) -> Result<(), Damage> {
        let rest = if page == self.count + 1 { self.rest_bytes } else { 0 };
        out.resize(if rest > 0 { rest } else { self.page_bytes }, 0);
        if let Some(wal) = &mut self.wal
            && wal.read(page, self.page_bytes, out)?
        {
            return Ok(());
        }
        if page == 0 || page > self.count && rest == 0 {
            return Err(Damage::Ended);
        }
        let here = self.input.stream_position()?;
        self.input.seek_relative(self.at_byte(page) as i64 - here as i64)?;
        Ok(self.input.read_exact(out)?)
    }

    /// The cell at `at` of a leaf page.
    pub(crate) fn cell(&self, leaf: &[u8], at: usize) -> Result<Cell, Damage> {
        Cell::read(leaf, at, self.usable_bytes).ok_or_else(|| Damage::Record("a row cannot be parsed".to_owned()))
    }

    /// The part of a row that is on its leaf page: enough for its first columns.
    pub(crate) fn start_of_row(&self, leaf: &[u8], cell: &Cell) -> Result<Record, Damage> {
        Record::parse(cell.local_part(leaf))
    }

    /// Reads a whole row into `out`, following it onto other pages; `page` is a buffer.
    pub(crate) fn read_row(
        &mut self,
        leaf: &[u8],
        cell: &Cell,
        page: &mut Vec<u8>,
        out: &mut Vec<u8>,
    ) -> Result<(), Damage> {
        if cell.bytes > limits::MESSAGE_BYTES {
            return Err(Damage::TooLarge { bytes: cell.bytes, limit: limits::MESSAGE_BYTES });
        }
        out.clear();
        out.extend_from_slice(cell.local_part(leaf));
        let mut next = cell.overflow;
        // Each page adds bytes, so a chain that bites its tail ends.
        while (out.len() as u64) < cell.bytes {
            self.read(next, page)?;
            let left = (cell.bytes - out.len() as u64).min(self.usable_bytes as u64 - 4) as usize;
            next = u32_at(page, 0).ok_or(Damage::Ended)?;
            out.extend_from_slice(page.get(4..4 + left).ok_or(Damage::Ended)?);
        }
        Ok(())
    }
}
