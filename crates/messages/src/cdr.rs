//! Plain CDR with its encapsulation header.

use byteorder::{BigEndian, ByteOrder, LittleEndian};
use cdr_encoding::CdrDeserializer;
use serde::{Deserialize, Serialize};

const HEADER_BYTES: usize = 4;

/// Byte order of an encoded message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Endian {
    /// Least significant byte first; what ROS 2 writes on nearly every machine.
    Little,
    /// Most significant byte first.
    Big,
}

/// Why the bytes of a message could not be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum DecodeError {
    /// Too short for the encapsulation header.
    #[error("the message has {bytes} bytes, too few for the 4 bytes of a CDR header")]
    NoHeader {
        /// Bytes of the message.
        bytes: usize,
    },
    /// Not plain CDR.
    #[error("the message is {name} (header {id:#06x}); only plain CDR (0x0000 or 0x0001) can be read")]
    Encapsulation {
        /// The first two bytes of the header, most significant first.
        id: u16,
        /// What they stand for.
        name: &'static str,
    },
    /// A sequence claims more elements than the message has bytes for.
    #[error(
        "`{field}` claims {claimed} elements, at least {needed_bytes} bytes, but {left_bytes} bytes of the message are \
         left"
    )]
    Length {
        /// The sequence.
        field: &'static str,
        /// Elements, as the message says.
        claimed: u32,
        /// The least number of bytes that these take.
        needed_bytes: u64,
        /// Bytes from the first element to the end of the message.
        left_bytes: u64,
    },
    /// The message ends too early.
    #[error("the message ends in `{field}`, after {bytes} bytes")]
    Ended {
        /// The field that is not complete.
        field: &'static str,
        /// Bytes of the message.
        bytes: usize,
    },
    /// A value that its type does not allow, such as a text that is not UTF-8.
    #[error("`{field}` cannot be read: {cause}")]
    Value {
        /// The field.
        field: &'static str,
        /// What is wrong with it.
        cause: String,
    },
}

/// A ROS 2 message: its schema, and how it is read and written.
pub trait Message: Serialize + Default {
    /// Its type, as ROS 2 names it.
    const SCHEMA_NAME: &'static str;
    /// Its definition with all that it depends on, in [`SCHEMA_ENCODING`](crate::SCHEMA_ENCODING).
    const SCHEMA_TEXT: &'static str;

    /// Reads the fields in order into `self`, whatever it held before.
    ///
    /// # Errors
    /// At the first field that cannot be read; `self` is then partly overwritten.
    fn read<B: ByteOrder>(&mut self, from: &mut Reader<'_, B>) -> Result<(), DecodeError>;

    /// Reads a message with its encapsulation header into `self`, keeping its buffers.
    ///
    /// # Errors
    /// When the header is not that of plain CDR, or a field cannot be read; `self` is then partly overwritten.
    fn decode_into(&mut self, message: &[u8]) -> Result<(), DecodeError> {
        match endian(message)? {
            Endian::Little => self.read(&mut Reader::<LittleEndian>::new(message)),
            Endian::Big => self.read(&mut Reader::<BigEndian>::new(message)),
        }
    }

    /// Reads a message with its encapsulation header.
    ///
    /// # Errors
    /// As [`Message::decode_into`].
    fn decode(message: &[u8]) -> Result<Self, DecodeError> {
        let mut value = Self::default();
        value.decode_into(message)?;
        Ok(value)
    }

    /// The message with its encapsulation header.
    fn encode(&self, endian: Endian) -> Vec<u8> {
        let mut bytes = Vec::new();
        match endian {
            Endian::Little => {
                bytes.extend([0, 1, 0, 0]);
                cdr_encoding::to_writer::<_, LittleEndian, _>(&mut bytes, self)
            }
            Endian::Big => {
                bytes.extend([0, 0, 0, 0]);
                cdr_encoding::to_writer::<_, BigEndian, _>(&mut bytes, self)
            }
        }
        .expect("a Vec takes all bytes, and every sequence knows its length");
        bytes
    }
}

/// The byte order that the encapsulation header states.
fn endian(message: &[u8]) -> Result<Endian, DecodeError> {
    let Some(header) = message.first_chunk::<HEADER_BYTES>() else {
        return Err(DecodeError::NoHeader { bytes: message.len() });
    };
    let id = u16::from_be_bytes([header[0], header[1]]);
    // Two sets of numbers are in use for XCDR2: those of DDS-XTypes (from 6) and those of RTPS 2.5 (from 0x10).
    let name = match id {
        0 => return Ok(Endian::Big),
        1 => return Ok(Endian::Little),
        2 | 3 => "PL_CDR",
        4 => "XML",
        0x06 | 0x07 | 0x10 | 0x11 => "XCDR2 (plain)",
        0x08 | 0x09 | 0x14 | 0x15 => "XCDR2 (delimited)",
        0x0a | 0x0b | 0x12 | 0x13 => "XCDR2 (PL_CDR2)",
        _ => "of an unknown encoding",
    };
    Err(DecodeError::Encapsulation { id, name })
}

/// The fields of a message, one after the other.
pub struct Reader<'a, B> {
    cdr: CdrDeserializer<'a, B>,
    message_bytes: usize,
}

impl<'a, B: ByteOrder> Reader<'a, B> {
    fn new(message: &'a [u8]) -> Self {
        Self { cdr: CdrDeserializer::new(&message[HEADER_BYTES..]), message_bytes: message.len() }
    }

    /// The next value.
    ///
    /// # Errors
    /// When the message ends in it, or its bytes make no such value.
    pub fn value<T: Deserialize<'a>>(&mut self, field: &'static str) -> Result<T, DecodeError> {
        T::deserialize(&mut self.cdr).map_err(|error| match error {
            cdr_encoding::Error::Eof => DecodeError::Ended { field, bytes: self.message_bytes },
            other => DecodeError::Value { field, cause: other.to_string() },
        })
    }

    /// The next sequence, into `out`, whatever it held before. Each element takes `least_bytes` or more.
    ///
    /// # Errors
    /// When the message has no room for as many elements as the sequence claims, or one of them cannot be read.
    pub fn sequence<T: Deserialize<'a>>(
        &mut self,
        field: &'static str,
        least_bytes: usize,
        out: &mut Vec<T>,
    ) -> Result<(), DecodeError> {
        out.clear();
        let claimed: u32 = self.value(field)?;
        let needed_bytes = u64::from(claimed) * least_bytes as u64;
        let left_bytes = (self.message_bytes - HEADER_BYTES - self.cdr.bytes_consumed()) as u64;
        if needed_bytes > left_bytes {
            return Err(DecodeError::Length { field, claimed, needed_bytes, left_bytes });
        }
        for _ in 0..claimed {
            out.push(self.value(field)?);
        }
        Ok(())
    }
}
