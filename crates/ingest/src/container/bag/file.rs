//! The records of a bag, from one to the next or where the index says.

use std::collections::BTreeSet;
use std::io::{self, BufReader, Read as _, Seek as _, SeekFrom};

use super::chunk::{visit_chunk, visit_record};
use super::index::Index;
use super::records::{Head, op};
use crate::Damage;
use crate::container::ChannelId;
use crate::container::chunked::{ChunkPlace, ChunkedFile, Progress, Visitor};
use crate::container::resting_file::RestingFile;
use crate::found::ROS1_BAG_MAGIC;

/// A bag, read record by record.
pub(in crate::container) struct BagFile {
    input: BufReader<RestingFile>,
    at_byte: u64,
    length: u64,
    /// Where the index begins, as the bag's first record says; 0 if the recorder did not come to write it.
    index_at: u64,
    head: Head,
    /// Buffers for a record in a chunk.
    record: (Head, Vec<u8>),
}

impl BagFile {
    /// At the first record after the magic bytes.
    pub(super) fn new(file: RestingFile, length: u64) -> io::Result<Self> {
        let input = BufReader::new(file);
        let mut bag =
            Self { input, at_byte: 0, length, index_at: 0, head: Head::default(), record: Default::default() };
        bag.rewind()?;
        Ok(bag)
    }

    /// Reads the index; `None` if there is none.
    pub(super) fn index(&mut self) -> Result<Option<Index>, Damage> {
        let Some(op::BAG_HEADER) = self.read_head()? else {
            return Err(Damage::Record("its first record is not that of a bag".to_owned()));
        };
        self.index_at = self.head.u64("index_pos")?;
        let [connections, chunks] = [self.head.u32("conn_count")?, self.head.u32("chunk_count")?];
        if self.index_at == 0 {
            return Ok(None);
        }
        if self.index_at > self.length {
            return Err(Damage::Ended);
        }
        self.go_to(self.index_at)?;
        Index::read(&mut self.input, connections, chunks, self.index_at).map(Some)
    }

    fn go_to(&mut self, at_byte: u64) -> io::Result<()> {
        self.input.seek(SeekFrom::Start(at_byte))?;
        self.at_byte = at_byte;
        Ok(())
    }

    /// Reads the header of the record here, and gives its type; `None` where the file ends.
    fn read_head(&mut self) -> Result<Option<u8>, Damage> {
        if self.head.read(&mut self.input)? { self.head.op().map(Some) } else { Ok(None) }
    }

    /// Hands the record whose header was read to `visitor`, and says where it ends.
    fn visit(&mut self, opcode: u8, visitor: &mut impl Visitor) -> (u64, Result<(), Damage>) {
        let Ok(here) = self.input.stream_position() else { return (self.length, Err(Damage::Ended)) };
        let end = here.saturating_add(self.head.data_bytes);
        let mut data = (&mut self.input).take(self.head.data_bytes);
        let visited = match opcode {
            op::CHUNK => visit_chunk(&self.head, data, (&mut self.record.0, &mut self.record.1), visitor),
            op::CONNECTION | op::MESSAGE => visit_record(&self.head, &mut data, &mut self.record.1, visitor),
            _ => Ok(()), // the data is passed over below
        };
        let is_there = end <= self.length;
        (
            end,
            visited.map_err(|damage| match damage {
                Damage::Ended if is_there => Damage::Record("what is in it does not fit its length".to_owned()),
                damage => damage,
            }),
        )
    }

    /// Reads past what is left of a record, most of which is in the buffer already.
    fn proceed(&mut self, progress: Progress, to_byte: u64) -> Progress {
        let skipped =
            self.input.stream_position().and_then(|here| self.input.seek_relative(to_byte as i64 - here as i64));
        self.at_byte = to_byte;
        match skipped {
            Ok(()) => progress,
            Err(error) => Progress::Stopped { at_byte: self.at_byte, damage: error.into() },
        }
    }
}

impl ChunkedFile for BagFile {
    fn rewind(&mut self) -> io::Result<()> {
        self.go_to(ROS1_BAG_MAGIC.len() as u64)
    }

    fn rest(&mut self) -> io::Result<()> {
        self.rewind()?;
        self.input.get_mut().rest()
    }

    fn at_byte(&self) -> u64 {
        self.at_byte
    }

    fn step(&mut self, visitor: &mut impl Visitor) -> Progress {
        let at_byte = self.at_byte;
        if self.index_at > 0 && at_byte >= self.index_at && self.index_at < self.length {
            return Progress::End { at_byte };
        }
        let opcode = match self.read_head() {
            Ok(Some(opcode)) => opcode,
            Ok(None) => return Progress::Stopped { at_byte, damage: Damage::Ended },
            Err(damage) => return Progress::Stopped { at_byte, damage },
        };
        let (end, visited) = self.visit(opcode, visitor);
        match Progress::settled(visited, at_byte, end > self.length, visitor) {
            stopped @ Progress::Stopped { .. } => stopped,
            progress => self.proceed(progress, end.min(self.length)),
        }
    }

    fn chunk(&mut self, at_byte: u64, visitor: &mut impl Visitor) -> Result<(), Damage> {
        let opcode = self.go_to(at_byte).map_err(Damage::from).and_then(|()| self.read_head());
        let visited = match opcode {
            Ok(Some(op::CHUNK)) => self.visit(op::CHUNK, visitor).1,
            Ok(_) => Err(Damage::Record("there is no chunk where one belongs".to_owned())),
            Err(damage) => Err(damage),
        };
        visitor.settle(visited.is_ok());
        visited
    }

    fn messages_in(&mut self, chunk: &ChunkPlace, channels: &BTreeSet<ChannelId>) -> Option<u64> {
        Some(channels.iter().filter_map(|id| chunk.channels.get(id)).sum())
    }
}
