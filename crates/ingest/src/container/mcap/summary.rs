//! The summary at the end of a file: topics, counts, and where each chunk is.

use std::io::{BufReader, Read, Seek, SeekFrom};

use mcap::records::{Channel, ChunkIndex, Record, Statistics, op};

use super::chunk::{Checked, check};
use super::data_section::FOOTER_BYTES;
use super::records::{HEAD_BYTES, Schemas, parse, read_body, read_head, read_record, skip};
use crate::Damage;
use crate::container::resting_file::RestingFile;

/// Bytes of the footer record that its own checksum covers: all but the checksum.
const CHECKED_FOOTER_BYTES: u64 = HEAD_BYTES + FOOTER_BYTES - 4;

/// The records of the summary section that are used here.
#[derive(Default)]
pub(super) struct Summary {
    pub(super) schemas: Schemas,
    pub(super) channels: Vec<Channel>,
    pub(super) chunks: Vec<ChunkIndex>,
    pub(super) statistics: Option<Statistics>,
}

impl Summary {
    /// Reads the summary of a file of `length` bytes; `None` if it was written without.
    pub(super) fn read(input: &mut BufReader<RestingFile>, length: u64) -> Result<Option<Self>, Damage> {
        let tail_bytes = HEAD_BYTES + FOOTER_BYTES + mcap::MAGIC.len() as u64;
        let footer_at = length.checked_sub(tail_bytes).ok_or(Damage::Ended)?;
        input.seek(SeekFrom::Start(footer_at))?;
        let mut tail = Vec::new();
        read_body(input, tail_bytes, &mut tail)?;
        let (footer, magic) = tail.split_at((HEAD_BYTES + FOOTER_BYTES) as usize);
        if magic != mcap::MAGIC {
            return Err(Damage::Ended);
        }
        let (head, footer) = footer.split_at(HEAD_BYTES as usize);
        let Record::Footer(footer) = parse(head[0], footer)? else {
            return Err(Damage::Record("there is no footer before the last 8 bytes".to_owned()));
        };
        if footer.summary_start == 0 {
            return Ok(None);
        }
        let bytes = footer_at
            .checked_sub(footer.summary_start)
            .ok_or_else(|| Damage::Record(format!("it would begin at byte {}, after its end", footer.summary_start)))?;
        input.seek(SeekFrom::Start(footer.summary_start))?;
        let mut checked = Checked::new(input);
        let summary = Self::read_records(&mut (&mut checked).take(bytes))?;
        skip(&mut checked, CHECKED_FOOTER_BYTES)?;
        check(footer.summary_crc, checked.finish().1)?;
        summary.check_counts()?;
        Ok(Some(summary))
    }

    fn read_records(input: &mut impl Read) -> Result<Self, Damage> {
        let mut summary = Self::default();
        let mut body = Vec::new();
        while let Some((opcode, length)) = read_head(input)? {
            if !matches!(opcode, op::SCHEMA | op::CHANNEL | op::CHUNK_INDEX | op::STATISTICS) {
                skip(input, length)?;
                continue;
            }
            read_record(input, length, &mut body)?;
            match parse(opcode, &body)? {
                Record::Schema { header, .. } => {
                    summary.schemas.entry(header.id).or_insert([header.name, header.encoding]);
                }
                Record::Channel(channel) => summary.channels.push(channel),
                Record::ChunkIndex(chunk) => summary.chunks.push(chunk),
                Record::Statistics(statistics) => summary.statistics = Some(statistics),
                _ => {}
            }
        }
        // In the order in which they are to be read; the same chunk twice would give its messages twice.
        summary.chunks.sort_by_key(|chunk| (chunk.message_start_time, chunk.chunk_start_offset));
        summary.chunks.dedup_by_key(|chunk| chunk.chunk_start_offset);
        Ok(summary)
    }

    fn check_counts(&self) -> Result<(), Damage> {
        match &self.statistics {
            Some(statistics) if !self.chunks.is_empty() && statistics.chunk_count as usize != self.chunks.len() => {
                Err(Damage::Record(format!("it has {} of {} chunks", self.chunks.len(), statistics.chunk_count)))
            }
            _ => Ok(()),
        }
    }
}
