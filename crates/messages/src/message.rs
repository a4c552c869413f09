//! ROS messages: their schema, and how they are read and written.

#[cfg(feature = "encode")]
use byteorder::{BigEndian, LittleEndian};
use serde::Serialize;

#[cfg(feature = "encode")]
use crate::Endian;
use crate::{DecodeError, Fields};

/// A ROS message: its schema, and how it is read and written.
pub trait Message: Serialize + Default {
    /// Its type, as ROS 2 names it.
    const SCHEMA_NAME: &'static str;
    /// Its definition with all that it depends on, in [`SCHEMA_ENCODING`](crate::SCHEMA_ENCODING).
    const SCHEMA_TEXT: &'static str;

    /// Reads the fields in order into `self`, whatever it held before.
    ///
    /// # Errors
    /// At the first field that cannot be read; `self` is then partly overwritten.
    fn read(&mut self, from: &mut Fields<'_>) -> Result<(), DecodeError>;

    /// Whether it can be what was written: its quaternions have length 1.
    fn is_sound(&self) -> bool {
        true
    }

    /// Reads a ROS 2 message, which begins with an encapsulation header, into `self`, keeping its buffers.
    ///
    /// # Errors
    /// When the header is not that of plain CDR, or a field cannot be read; `self` is then partly overwritten.
    fn decode_into(&mut self, message: &[u8]) -> Result<(), DecodeError> {
        self.read(&mut Fields::cdr(message)?)
    }

    /// Reads a ROS 1 message into `self`, keeping its buffers. Its fields are those of ROS 2, but for a number at the
    /// start of every header, which is not kept.
    ///
    /// # Errors
    /// At the first field that cannot be read; `self` is then partly overwritten.
    fn decode_ros1_into(&mut self, message: &[u8]) -> Result<(), DecodeError> {
        self.read(&mut Fields::ros1(message))
    }

    /// Reads a ROS 2 message.
    ///
    /// # Errors
    /// As [`Message::decode_into`].
    fn decode(message: &[u8]) -> Result<Self, DecodeError> {
        let mut value = Self::default();
        value.decode_into(message)?;
        Ok(value)
    }

    /// The message in CDR of version 1 with its encapsulation header.
    #[cfg(feature = "encode")]
    fn encode(&self, endian: Endian) -> Vec<u8> {
        encode(self, endian)
    }
}

/// `message` in CDR of version 1 with its encapsulation header.
#[cfg(feature = "encode")]
pub(crate) fn encode(message: &impl Serialize, endian: Endian) -> Vec<u8> {
    let mut bytes = Vec::new();
    match endian {
        Endian::Little => {
            bytes.extend([0, 1, 0, 0]);
            cdr_encoding::to_writer::<_, LittleEndian, _>(&mut bytes, message)
        }
        Endian::Big => {
            bytes.extend([0, 0, 0, 0]);
            cdr_encoding::to_writer::<_, BigEndian, _>(&mut bytes, message)
        }
    }
    .expect("a Vec takes all bytes, and every sequence knows its length");
    bytes
}
