//! Rows: the cells of a leaf page of a table, and the columns of a record.

use std::ops::Range;

use crate::Damage;

/// Bytes before the first page's own content.
pub(super) const FILE_HEADER_BYTES: usize = 100;
const TABLE_LEAF: u8 = 0x0d;
const LEAF_HEADER_BYTES: usize = 8;

/// A row as its leaf page holds it.
#[derive(Clone, Debug)]
pub(crate) struct Cell {
    pub(crate) row: i64,
    /// Bytes of the whole record.
    pub(crate) bytes: u64,
    /// Where the record begins on the leaf page, and how much of it is there.
    pub(super) local: Range<usize>,
    /// The page on which it continues; 0 if it does not.
    pub(super) overflow: u32,
}

impl Cell {
    pub(super) fn read(leaf: &[u8], at: usize, usable_bytes: usize) -> Option<Self> {
        let (bytes, length) = varint(leaf.get(at..)?)?;
        let at = at + length;
        let (row, length) = varint(leaf.get(at..)?)?;
        let at = at + length;
        // The rule of the file format for how much of a row stays on its leaf page.
        let most_local = usable_bytes as u64 - 35;
        let local_bytes = if bytes <= most_local {
            bytes
        } else {
            let least_local = (usable_bytes as u64 - 12) * 32 / 255 - 23;
            let wanted = least_local + (bytes - least_local) % (usable_bytes as u64 - 4);
            if wanted <= most_local { wanted } else { least_local }
        };
        let local = at..at + local_bytes as usize;
        leaf.get(local.clone())?;
        let overflow = if local_bytes == bytes { 0 } else { u32_at(leaf, local.end)? };
        Some(Self { row: row as i64, bytes, local, overflow })
    }
}

impl Cell {
    /// The part of the row that is on its leaf page.
    pub(crate) fn local_part<'a>(&self, leaf: &'a [u8]) -> &'a [u8] {
        &leaf[self.local.clone()]
    }
}

/// Whether a page is a leaf of a table.
pub(crate) fn is_table_leaf(page: &[u8], number: u32) -> bool {
    page.get(header_at(number)) == Some(&TABLE_LEAF)
}

/// Where the header of a page begins: the first page has that of the file before it.
pub(super) fn header_at(number: u32) -> usize {
    if number == 1 { FILE_HEADER_BYTES } else { 0 }
}

/// Where the cells of a leaf page begin.
pub(crate) fn cells_of(page: &[u8], number: u32) -> Result<Vec<usize>, Damage> {
    let impossible = || Damage::Record(format!("page {number} cannot be parsed"));
    cell_places(page, header_at(number), LEAF_HEADER_BYTES).ok_or_else(impossible)
}

pub(super) fn cell_places(page: &[u8], header_at: usize, header_bytes: usize) -> Option<Vec<usize>> {
    let count = usize::from(u16_at(page, header_at + 3)?);
    let first = header_at + header_bytes;
    let places = page.get(first..first + 2 * count)?.as_chunks::<2>().0;
    Some(places.iter().map(|place| usize::from(u16::from_be_bytes(*place))).collect())
}

/// Where each column of a record is.
#[derive(Debug)]
pub(crate) struct Record {
    /// Type and first byte of each column, with its length.
    columns: Vec<(u64, Range<usize>)>,
}

impl Record {
    /// Parses the header of a record, of which the end may be missing.
    pub(crate) fn parse(record: &[u8]) -> Result<Self, Damage> {
        Self::columns(record)
            .map(|columns| Self { columns })
            .ok_or_else(|| Damage::Record("a row has no columns".into()))
    }

    fn columns(record: &[u8]) -> Option<Vec<(u64, Range<usize>)>> {
        let (header_bytes, mut at) = varint(record)?;
        let header = record.get(..usize::try_from(header_bytes).ok()?)?;
        let mut begins = header.len();
        let mut columns = Vec::new();
        while at < header.len() {
            let (kind, length) = varint(header.get(at..)?)?;
            at += length;
            let bytes = match kind {
                0 | 8 | 9 => 0,
                1..=4 => kind as usize,
                5 => 6,
                6 | 7 => 8,
                10 | 11 => return None,
                _ => usize::try_from((kind - 12) / 2).ok()?,
            };
            let ends = begins.checked_add(bytes)?;
            columns.push((kind, begins..ends));
            begins = ends;
        }
        Some(columns)
    }

    pub(crate) fn len(&self) -> usize {
        self.columns.len()
    }

    /// A whole number, if the column holds one.
    pub(crate) fn integer(&self, record: &[u8], column: usize) -> Option<i64> {
        let (kind, place) = self.columns.get(column)?;
        let bytes = record.get(place.clone())?;
        match kind {
            8 => Some(0),
            9 => Some(1),
            1..=6 => {
                let negative = bytes.first().is_some_and(|byte| *byte >= 0x80);
                let start = if negative { -1i64 } else { 0 };
                Some(bytes.iter().fold(start, |number, byte| number << 8 | i64::from(*byte)))
            }
            _ => None,
        }
    }

    /// Where the bytes of a column are, if it holds bytes.
    pub(crate) fn blob(&self, column: usize) -> Option<Range<usize>> {
        self.columns
            .get(column)
            .filter(|(kind, _)| *kind >= 12 && kind.is_multiple_of(2))
            .map(|(_, place)| place.clone())
    }

    /// A text, if the column holds one.
    pub(crate) fn text(&self, record: &[u8], column: usize) -> Option<String> {
        let (kind, place) = self.columns.get(column)?;
        let is_text = *kind >= 13 && !kind.is_multiple_of(2);
        let bytes = record.get(place.clone()).filter(|_| is_text)?;
        Some(String::from_utf8_lossy(bytes).into_owned())
    }
}

/// A number of 1 to 9 bytes, and how many it took.
fn varint(bytes: &[u8]) -> Option<(u64, usize)> {
    let mut number = 0;
    for (i, &byte) in bytes.iter().take(9).enumerate() {
        if i == 8 {
            return Some((number << 8 | u64::from(byte), 9));
        }
        number = number << 7 | u64::from(byte & 0x7f);
        if byte < 0x80 {
            return Some((number, i + 1));
        }
    }
    None
}

pub(super) fn u16_at(bytes: &[u8], at: usize) -> Option<u16> {
    bytes.get(at..)?.first_chunk().map(|bytes| u16::from_be_bytes(*bytes))
}

pub(super) fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    bytes.get(at..)?.first_chunk().map(|bytes| u32::from_be_bytes(*bytes))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_every_length_are_read() {
        assert_eq!(varint(&[0x7f]), Some((127, 1)));
        assert_eq!(varint(&[0x81, 0x00]), Some((128, 2)));
        assert_eq!(varint(&[0xff; 9]), Some((u64::MAX, 9)));
        assert_eq!(varint(&[0x80]), None);
    }

    #[test]
    fn columns_are_read_by_their_types() {
        // NULL, an integer of one byte (-2), the constant 1, a text of two bytes, a blob of one.
        let record = [6, 0, 1, 9, 17, 14, 0xfe, b'h', b'i', 7];
        let parsed = Record::parse(&record).expect("a record");
        assert_eq!(
            (parsed.integer(&record, 0), parsed.integer(&record, 1), parsed.integer(&record, 2)),
            (None, Some(-2), Some(1))
        );
        assert_eq!((parsed.text(&record, 3), parsed.blob(4)), (Some("hi".to_owned()), Some(9..10)));
        assert!(Record::parse(&[9, 0]).is_err(), "a header that goes beyond the record");
    }
}
