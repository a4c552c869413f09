//! Records: an opcode, a length, and that many bytes.

use std::collections::BTreeMap;
use std::io::{self, Read};

use mcap::records::{Channel, Record, op};

use crate::container::Topic;
use crate::container::chunked::Visitor;
use crate::{Damage, limits};

/// Bytes of opcode and length.
pub(super) const HEAD_BYTES: u64 = 9;
/// Bytes of a message record before the message.
const MESSAGE_HEADER_BYTES: usize = 22;

/// Name and encoding of each schema that was seen, by its number; the first definition holds.
pub(super) type Schemas = BTreeMap<u16, [String; 2]>;

/// What a channel carries.
pub(super) fn topic_of(channel: Channel, schemas: &Schemas) -> Topic {
    let [type_name, schema_encoding] = schemas.get(&channel.schema_id).cloned().unwrap_or_default();
    Topic { name: channel.topic, type_name, encoding: channel.message_encoding, schema_encoding }
}

/// Opcode and length of the next record; `None` where the bytes end.
pub(super) fn read_head(input: &mut impl Read) -> Result<Option<(u8, u64)>, Damage> {
    let mut opcode = [0];
    let mut length = [0; 8];
    if input.read(&mut opcode)? == 0 {
        return Ok(None);
    }
    input.read_exact(&mut length)?;
    Ok(Some((opcode[0], u64::from_le_bytes(length))))
}

/// Reads the rest of `input` up to `length` bytes into `body`, which grows no faster than there are bytes.
pub(super) fn read_body(input: &mut impl Read, length: u64, body: &mut Vec<u8>) -> Result<(), Damage> {
    body.clear();
    input.take(length).read_to_end(body)?;
    if body.len() as u64 == length { Ok(()) } else { Err(Damage::Ended) }
}

/// Reads a record that is no message into `body`.
pub(super) fn read_record(input: &mut impl Read, length: u64, body: &mut Vec<u8>) -> Result<(), Damage> {
    if length > limits::RECORD_BYTES {
        return Err(Damage::TooLarge { bytes: length, limit: limits::RECORD_BYTES });
    }
    read_body(input, length, body)
}

/// Reads past `length` bytes.
pub(super) fn skip(input: &mut impl Read, length: u64) -> Result<(), Damage> {
    if io::copy(&mut input.take(length), &mut io::sink())? == length { Ok(()) } else { Err(Damage::Ended) }
}

/// Parses a record.
pub(super) fn parse(opcode: u8, body: &[u8]) -> Result<Record<'_>, Damage> {
    if !lengths_fit(opcode, body) {
        return Err(Damage::Record(format!("a length in a record of type {opcode} goes beyond its end")));
    }
    Ok(mcap::parse_record(opcode, body)?)
}

/// Whether the texts of a record end before the record does: `mcap` reserves memory on the word of their lengths, and
/// 4 GiB are more than a robot may have.
fn lengths_fit(opcode: u8, body: &[u8]) -> bool {
    let text_end = |at: usize| {
        let length = u32::from_le_bytes(body.get(at..)?.first_chunk().copied()?);
        let end = at + 4 + length as usize;
        (end <= body.len()).then_some(end)
    };
    let map_end = |map: usize| {
        let (mut at, end) = (map + 4, text_end(map)?);
        while at < end {
            at = text_end(at)?;
        }
        Some(at)
    };
    let last_end = || match opcode {
        op::HEADER => text_end(text_end(0)?),
        op::SCHEMA => text_end(text_end(2)?),
        op::CHANNEL => map_end(text_end(text_end(4)?)?),
        op::METADATA => map_end(text_end(0)?),
        op::CHUNK_INDEX => text_end(text_end(32)? + 8),
        _ => Some(0),
    };
    last_end().is_some()
}

/// Hands the record to `visitor` if it is a channel or a message, and keeps a schema; other records are not read.
pub(super) fn visit(
    (opcode, length): (u8, u64),
    input: &mut impl Read,
    (schemas, body): (&mut Schemas, &mut Vec<u8>),
    visitor: &mut impl Visitor,
) -> Result<(), Damage> {
    match opcode {
        0 => Err(Damage::Record("a record of type 0 cannot be".to_owned())),
        op::SCHEMA | op::CHANNEL => {
            read_record(input, length, body)?;
            match parse(opcode, body)? {
                Record::Schema { header, .. } => {
                    schemas.entry(header.id).or_insert([header.name, header.encoding]);
                }
                Record::Channel(channel) => visitor.channel(channel.id.into(), topic_of(channel, schemas)),
                _ => {}
            }
            Ok(())
        }
        op::MESSAGE => {
            let Some(body_bytes) = length.checked_sub(MESSAGE_HEADER_BYTES as u64) else {
                return Err(Damage::Record(format!("a message record of {length} bytes has no room for its header")));
            };
            let mut header = [0; MESSAGE_HEADER_BYTES];
            input.read_exact(&mut header)?;
            let Record::Message { header, .. } = parse(opcode, &header)? else { return Ok(()) };
            let channel = header.channel_id.into();
            if visitor.wants(channel) {
                if body_bytes > limits::MESSAGE_BYTES {
                    return Err(Damage::TooLarge { bytes: body_bytes, limit: limits::MESSAGE_BYTES });
                }
                read_body(input, body_bytes, body)?;
            } else {
                skip(input, body_bytes)?;
                body.clear();
            }
            visitor.message(channel, header.log_time, body);
            Ok(())
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A channel with one entry of metadata, whose key claims `key_length` bytes.
    fn channel(key_length: u32) -> Vec<u8> {
        let mut body = vec![1, 0, 1, 0];
        for text in ["/scan", "cdr"] {
            body.extend((text.len() as u32).to_le_bytes());
            body.extend(text.bytes());
        }
        body.extend(10u32.to_le_bytes());
        body.extend(key_length.to_le_bytes());
        body.extend(b"k\x01\0\0\0v");
        body
    }

    #[test]
    fn a_text_that_claims_more_than_its_record_has_is_refused_before_memory_is_reserved_for_it() {
        assert!(matches!(parse(op::CHANNEL, &channel(1)), Ok(Record::Channel(channel)) if channel.topic == "/scan"));
        let refused = parse(op::CHANNEL, &channel(u32::MAX)).expect_err("must be refused");
        assert_eq!(refused.to_string(), "a length in a record of type 4 goes beyond its end");
        assert!(parse(op::SCHEMA, &[1, 0, 255, 255, 255, 255]).is_err());
        assert!(parse(op::CHUNK_INDEX, &[255; 60]).is_err());
        assert!(parse(op::HEADER, &[]).is_err());
    }
}
