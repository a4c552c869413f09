//! The records of a file, from one to the next or where the index says.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::mem;

use mcap::records::{Record, op};

use super::chunk::{Checked, check, visit_chunk};
use super::records::{HEAD_BYTES, Schemas, parse, read_head, read_record, skip, visit};
use crate::container::ChannelId;
use crate::container::chunked::{ChunkPlace, ChunkedFile, Progress, Visitor};
use crate::container::resting_file::RestingFile;
use crate::{Damage, Following};

pub(super) const DATA_END_BYTES: u64 = 4;
pub(super) const FOOTER_BYTES: u64 = 20;

/// Whether this opcode and length are those of a record that comes after the last message.
pub(super) fn ends_data(head: (u8, u64)) -> bool {
    matches!(head, (op::DATA_END, DATA_END_BYTES) | (op::FOOTER, FOOTER_BYTES))
}

/// A file, read record by record.
pub(in crate::container) struct DataSection {
    input: BufReader<RestingFile>,
    at_byte: u64,
    length: u64,
    schemas: Schemas,
    body: Vec<u8>,
    /// Set while the file is being written.
    following: Option<Following>,
}

impl DataSection {
    /// At the first record after the magic bytes.
    pub(super) fn new(file: RestingFile, length: u64) -> io::Result<Self> {
        let mut section = Self {
            input: BufReader::new(file),
            at_byte: 0,
            length,
            schemas: Schemas::new(),
            body: Vec::new(),
            following: None,
        };
        section.rewind()?;
        Ok(section)
    }

    /// From now on, reading waits for the next record.
    pub(super) fn follow(&mut self, following: &Following) {
        self.following = Some(following.clone());
    }

    pub(super) fn input(&mut self) -> &mut BufReader<RestingFile> {
        &mut self.input
    }

    fn go_to(&mut self, at_byte: u64) -> io::Result<()> {
        self.input.seek(SeekFrom::Start(at_byte))?;
        self.at_byte = at_byte;
        Ok(())
    }

    /// Where the record here ends, whose body has this length.
    fn end_of_record(&self, length: u64) -> u64 {
        self.at_byte.saturating_add(HEAD_BYTES).saturating_add(length)
    }

    /// Reads past what is left of a record, which is in the buffer more often than not.
    fn skip_to(&mut self, at_byte: u64) -> io::Result<()> {
        let here = self.input.stream_position()?;
        self.input.seek_relative(at_byte as i64 - here as i64)?;
        self.at_byte = at_byte;
        Ok(())
    }

    fn proceed(&mut self, step: Progress, to_byte: u64) -> Progress {
        match self.skip_to(to_byte.min(self.length)) {
            Ok(()) => step,
            Err(error) => Progress::Stopped { at_byte: self.at_byte, damage: error.into() },
        }
    }

    fn visit_record(&mut self, (opcode, length): (u8, u64), visitor: &mut impl Visitor) -> Result<(), Damage> {
        let is_there = self.end_of_record(length) <= self.length;
        let mut record = (&mut self.input).take(length);
        let visited = match opcode {
            op::CHUNK => visit_chunk(record, (&mut self.schemas, &mut self.body), visitor),
            _ => visit((opcode, length), &mut record, (&mut self.schemas, &mut self.body), visitor),
        };
        visited.map_err(|damage| match damage {
            Damage::Ended if is_there => Damage::Record("what is in it does not fit its length".to_owned()),
            damage => damage,
        })
    }

    /// Waits until the record here is written; its length may be written last. `false` if waiting is over.
    fn wait_for_record(&mut self, following: &Following) -> io::Result<bool> {
        loop {
            if self.at_byte + HEAD_BYTES <= self.length
                && let Ok(Some((_, length))) = read_head(&mut self.input)
                && self.end_of_record(length) <= self.length
            {
                self.input.seek_relative(-(HEAD_BYTES as i64))?;
                return Ok(true);
            }
            self.go_to(self.at_byte)?; // forgets what was read here, which may be written again
            let length = self.input.get_ref().length()?;
            if mem::replace(&mut self.length, length) == length && !following.wait() {
                return Ok(false);
            }
        }
    }

    /// Where the recording ends whose messages end at `end_of_data`: behind its footer and magic bytes, if these can be
    /// found.
    pub(super) fn end_of_recording(&mut self, end_of_data: u64) -> Option<u64> {
        self.go_to(end_of_data).ok()?;
        loop {
            let head = read_head(&mut self.input).ok()??;
            let next = self.end_of_record(head.1);
            self.skip_to(Some(next).filter(|&next| next <= self.length)?).ok()?;
            if head == (op::FOOTER, FOOTER_BYTES) {
                let mut magic = [0; mcap::MAGIC.len()];
                self.input.read_exact(&mut magic).ok()?;
                return (magic == mcap::MAGIC).then_some(self.at_byte + mcap::MAGIC.len() as u64);
            }
        }
    }

    /// The metadata record of this name, if it is before the first message.
    pub(super) fn metadata(&mut self, name: &str) -> Option<BTreeMap<String, String>> {
        loop {
            let (opcode, length) = read_head(&mut self.input).ok()??;
            if matches!(opcode, op::CHUNK | op::MESSAGE | op::DATA_END | op::FOOTER) {
                return None;
            }
            if opcode != op::METADATA {
                skip(&mut self.input, length).ok()?;
                continue;
            }
            read_record(&mut self.input, length, &mut self.body).ok()?;
            match parse(opcode, &self.body).ok()? {
                Record::Metadata(found) if found.name == name => return Some(found.metadata),
                _ => {}
            }
        }
    }

    /// Reads the whole record at `at_byte`, which must be of type `opcode`.
    pub(super) fn record(&mut self, at_byte: u64, opcode: u8) -> Result<Record<'_>, Damage> {
        let length = self.head_of(at_byte, opcode)?;
        read_record(&mut self.input, length, &mut self.body)?;
        parse(opcode, &self.body)
    }

    /// Length of the record at `at_byte`, which must be of type `wanted`.
    fn head_of(&mut self, at_byte: u64, wanted: u8) -> Result<u64, Damage> {
        self.go_to(at_byte)?;
        match read_head(&mut self.input)? {
            Some((opcode, length)) if opcode == wanted => Ok(length),
            Some((opcode, _)) => {
                Err(Damage::Record(format!("a record of type {opcode} is where one of type {wanted} belongs")))
            }
            None => Err(Damage::Ended),
        }
    }
}

impl ChunkedFile for DataSection {
    fn rewind(&mut self) -> io::Result<()> {
        self.go_to(mcap::MAGIC.len() as u64)
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
        if let Some(following) = self.following.clone() {
            match self.wait_for_record(&following) {
                Ok(true) => {}
                Ok(false) => return Progress::End { at_byte },
                Err(error) => return Progress::Stopped { at_byte, damage: error.into() },
            }
        }
        let (opcode, length) = match read_head(&mut self.input) {
            Ok(Some(head)) => head,
            Ok(None) => return Progress::Stopped { at_byte, damage: Damage::Ended },
            Err(damage) => return Progress::Stopped { at_byte, damage },
        };
        let end = self.end_of_record(length);
        if ends_data((opcode, length)) && end <= self.length {
            return Progress::End { at_byte };
        }
        if opcode == 0 {
            let damage = Damage::Record("a record of type 0 cannot be".to_owned());
            return Progress::Stopped { at_byte, damage };
        }
        let visited = self.visit_record((opcode, length), visitor);
        match Progress::settled(visited, at_byte, end > self.length, visitor) {
            stopped @ Progress::Stopped { .. } => stopped,
            progress => self.proceed(progress, end),
        }
    }

    fn chunk(&mut self, at_byte: u64, visitor: &mut impl Visitor) -> Result<(), Damage> {
        let result =
            self.head_of(at_byte, op::CHUNK).and_then(|length| self.visit_record((op::CHUNK, length), visitor));
        visitor.settle(result.is_ok());
        result
    }

    fn messages_in(&mut self, chunk: &ChunkPlace, channels: &BTreeSet<ChannelId>) -> Option<u64> {
        if chunk.channels.is_empty() {
            return None;
        }
        let mut messages = 0;
        for at_byte in channels.iter().filter_map(|id| chunk.channels.get(id)) {
            let Ok(Record::MessageIndex(index)) = self.record(*at_byte, op::MESSAGE_INDEX) else { return None };
            messages += index.records.len() as u64;
        }
        Some(messages)
    }

    fn check_whole(&mut self) -> Result<(), Damage> {
        let end = self.at_byte;
        let Record::DataEnd(data_end) = self.record(end, op::DATA_END)? else { return Ok(()) };
        if data_end.data_section_crc == 0 {
            return Ok(());
        }
        self.go_to(0)?;
        let mut checked = Checked::new(&mut self.input);
        skip(&mut checked, end)?;
        check(data_end.data_section_crc, checked.finish().1)
    }
}
