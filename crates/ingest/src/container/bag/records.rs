//! Records: a header of named fields, and data.

use std::io::{self, Read};

use crate::container::Topic;
use crate::{Damage, limits};

/// Types of records, as the field `op` states them.
pub(super) mod op {
    pub(in crate::container::bag) const MESSAGE: u8 = 2;
    pub(in crate::container::bag) const BAG_HEADER: u8 = 3;
    pub(in crate::container::bag) const CHUNK: u8 = 5;
    pub(in crate::container::bag) const CHUNK_INFO: u8 = 6;
    pub(in crate::container::bag) const CONNECTION: u8 = 7;
}

const NS_PER_S: u64 = 1_000_000_000;

/// The header of a record, and how many bytes of data follow it.
#[derive(Default)]
pub(super) struct Head {
    fields: Vec<u8>,
    pub(super) data_bytes: u64,
}

impl Head {
    /// Reads the next header into `self`; `false` where the bytes end.
    pub(super) fn read(&mut self, input: &mut impl Read) -> Result<bool, Damage> {
        let mut length = [0; 4];
        if input.read(&mut length[..1])? == 0 {
            return Ok(false);
        }
        input.read_exact(&mut length[1..])?;
        read_data(input, u64::from(u32::from_le_bytes(length)), &mut self.fields)?;
        input.read_exact(&mut length)?;
        self.data_bytes = u64::from(u32::from_le_bytes(length));
        Ok(true)
    }

    /// The type of the record.
    pub(super) fn op(&self) -> Result<u8, Damage> {
        self.array("op").map(|[op]| op)
    }

    pub(super) fn u32(&self, name: &str) -> Result<u32, Damage> {
        self.array(name).map(u32::from_le_bytes)
    }

    pub(super) fn u64(&self, name: &str) -> Result<u64, Damage> {
        self.array(name).map(u64::from_le_bytes)
    }

    /// A time of ROS 1: seconds and nanoseconds, each as u32.
    pub(super) fn time_ns(&self, name: &str) -> Result<u64, Damage> {
        let [seconds, nanoseconds] = [0, 4].map(|at| {
            let bytes: Result<[u8; 8], _> = self.array(name);
            bytes.map(|bytes| u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]))
        });
        Ok(u64::from(seconds?) * NS_PER_S + u64::from(nanoseconds?))
    }

    pub(super) fn text(&self, name: &str) -> Result<String, Damage> {
        field(&self.fields, name).map(|text| String::from_utf8_lossy(text).into_owned()).ok_or_else(|| without(name))
    }

    fn array<const N: usize>(&self, name: &str) -> Result<[u8; N], Damage> {
        field(&self.fields, name).and_then(|value| value.try_into().ok()).ok_or_else(|| without(name))
    }
}

fn without(name: &str) -> Damage {
    Damage::Record(format!("a record has no valid field `{name}`"))
}

/// The value of a field among others, each a length and then `name=value`.
fn field<'a>(mut fields: &'a [u8], name: &str) -> Option<&'a [u8]> {
    while let Some((length, rest)) = fields.split_first_chunk() {
        let (entry, rest) = rest.split_at_checked(u32::from_le_bytes(*length) as usize)?;
        if let Some(value) = entry.strip_prefix(name.as_bytes()).and_then(|entry| entry.strip_prefix(b"=")) {
            return Some(value);
        }
        fields = rest;
    }
    None
}

/// What a connection carries, by its record.
pub(super) fn topic_of(head: &Head, data: &[u8]) -> Result<Topic, Damage> {
    let type_name = field(data, "type").ok_or_else(|| without("type"))?;
    Ok(Topic {
        name: head.text("topic")?,
        type_name: String::from_utf8_lossy(type_name).into_owned(),
        encoding: crosscut_messages::ROS1_ENCODING.to_owned(),
        schema_encoding: "ros1msg".to_owned(),
    })
}

/// Reads `length` bytes of a record that is no message into `data`.
pub(super) fn read_data(input: &mut impl Read, length: u64, data: &mut Vec<u8>) -> Result<(), Damage> {
    read_up_to(input, length, limits::RECORD_BYTES, data)
}

/// Reads `length` bytes of a message into `data`.
pub(super) fn read_message(input: &mut impl Read, length: u64, data: &mut Vec<u8>) -> Result<(), Damage> {
    read_up_to(input, length, limits::MESSAGE_BYTES, data)
}

/// `data` grows no faster than there are bytes.
fn read_up_to(input: &mut impl Read, length: u64, limit: u64, data: &mut Vec<u8>) -> Result<(), Damage> {
    data.clear();
    if length > limit {
        return Err(Damage::TooLarge { bytes: length, limit });
    }
    input.take(length).read_to_end(data)?;
    if data.len() as u64 == length { Ok(()) } else { Err(Damage::Ended) }
}

/// Reads past `length` bytes.
pub(super) fn skip(input: &mut impl Read, length: u64) -> Result<(), Damage> {
    if io::copy(&mut input.take(length), &mut io::sink())? == length { Ok(()) } else { Err(Damage::Ended) }
}
