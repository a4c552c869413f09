//! The fields of a message in CDR or in the encoding of ROS 1.

use crate::DecodeError;

/// Byte order of an encoded message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Endian {
    /// Least significant byte first; what ROS 2 writes on nearly every machine.
    Little,
    /// Most significant byte first.
    Big,
}

const CDR_HEADER_BYTES: usize = 4;

/// How values lie in a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Layout {
    /// No header, no alignment, texts without a final zero.
    Ros1,
    /// A header of 4 bytes; values are aligned to their own size, counted from its end.
    Xcdr1,
    /// Like [`Layout::Xcdr1`], but values of 8 bytes are aligned to 4, and a sequence of structures is preceded by its
    /// length in bytes.
    Xcdr2,
}

/// Reads the fields of a message one after the other.
///
/// Every length that the message claims is compared with the bytes that are left before anything is allocated.
#[derive(Debug)]
pub struct Fields<'a> {
    message: &'a [u8],
    at: usize,
    layout: Layout,
    endian: Endian,
    /// Where alignment is counted from.
    origin: usize,
}

macro_rules! numbers {
    ($($name:ident)*) => {$(
        #[doc = concat!("The next `", stringify!($name), "`.")]
        ///
        /// # Errors
        /// When the message ends in it.
        pub fn $name(&mut self, field: &'static str) -> Result<$name, DecodeError> {
            let bytes = self.array(field)?;
            Ok(match self.endian {
                Endian::Little => $name::from_le_bytes(bytes),
                Endian::Big => $name::from_be_bytes(bytes),
            })
        }
    )*};
}

macro_rules! number_sequences {
    ($($name:ident of $number:ident)*) => {$(
        #[doc = concat!("The next sequence of `", stringify!($number), "`, into `out`, whatever it held before.")]
        ///
        /// # Errors
        /// When the message has no room for as many elements as the sequence claims.
        pub fn $name(&mut self, field: &'static str, out: &mut Vec<$number>) -> Result<(), DecodeError> {
            let (values, _) = self.elements(field, size_of::<$number>())?.as_chunks();
            out.clear();
            match self.endian {
                Endian::Little => out.extend(values.iter().copied().map($number::from_le_bytes)),
                Endian::Big => out.extend(values.iter().copied().map($number::from_be_bytes)),
            }
            Ok(())
        }
    )*};
}

impl<'a> Fields<'a> {
    /// The fields of a ROS 2 message: plain CDR, version 1 or 2, after its encapsulation header.
    ///
    /// # Errors
    /// When the header is not that of plain CDR.
    pub fn cdr(message: &'a [u8]) -> Result<Self, DecodeError> {
        let Some(header) = message.first_chunk::<CDR_HEADER_BYTES>() else {
            return Err(DecodeError::NoHeader { bytes: message.len() });
        };
        let id = u16::from_be_bytes([header[0], header[1]]);
        // Two sets of numbers are in use for XCDR2: those of DDS-XTypes (from 6) and those of RTPS 2.5 (from 0x10).
        let (layout, endian) = match id {
            0 => (Layout::Xcdr1, Endian::Big),
            1 => (Layout::Xcdr1, Endian::Little),
            0x06 | 0x10 => (Layout::Xcdr2, Endian::Big),
            0x07 | 0x11 => (Layout::Xcdr2, Endian::Little),
            _ => return Err(DecodeError::Encapsulation { id, name: encapsulation_name(id) }),
        };
        Ok(Self { message, at: CDR_HEADER_BYTES, layout, endian, origin: CDR_HEADER_BYTES })
    }

    /// The fields of a ROS 2 message whose writer counts alignment from the start of the encapsulation header, as RTI
    /// Connext Micro does.
    ///
    /// # Errors
    /// As [`Fields::cdr`].
    pub fn cdr_from_start(message: &'a [u8]) -> Result<Self, DecodeError> {
        Ok(Self { origin: 0, ..Self::cdr(message)? })
    }

    /// The fields of a ROS 1 message.
    pub fn ros1(message: &'a [u8]) -> Self {
        Self { message, at: 0, layout: Layout::Ros1, endian: Endian::Little, origin: 0 }
    }

    /// Whether the message is of ROS 1, whose headers and times differ from those of ROS 2.
    pub fn is_ros1(&self) -> bool {
        self.layout == Layout::Ros1
    }

    numbers! { u8 u32 i32 f32 f64 }

    number_sequences! { f32s of f32 f64s of f64 }

    /// The next sequence of bytes.
    ///
    /// # Errors
    /// When the message has no room for as many as the sequence claims.
    pub fn bytes(&mut self, field: &'static str) -> Result<&'a [u8], DecodeError> {
        self.elements(field, 1)
    }

    /// The next text, into `out`, whatever it held before. Bytes that are not UTF-8 become replacement characters.
    ///
    /// # Errors
    /// When the message has no room for as many bytes as the text claims.
    pub fn text(&mut self, field: &'static str, out: &mut String) -> Result<(), DecodeError> {
        let bytes = self.bytes(field)?;
        let text = if self.is_ros1() { bytes } else { bytes.strip_suffix(b"\0").unwrap_or(bytes) };
        out.clear();
        out.push_str(&String::from_utf8_lossy(text));
        Ok(())
    }

    /// The next sequence of structures, into `out`, whatever it held before. Each takes `least_bytes` or more.
    ///
    /// # Errors
    /// When the message has no room for as many as the sequence claims, there are more than `most`, or `read` cannot read
    /// one of them.
    pub fn structures<T: Default>(
        &mut self,
        field: &'static str,
        least_bytes: usize,
        most: usize,
        out: &mut Vec<T>,
        mut read: impl FnMut(&mut Self, &mut T) -> Result<(), DecodeError>,
    ) -> Result<(), DecodeError> {
        if self.layout == Layout::Xcdr2 {
            self.u32(field)?;
        }
        let count = self.count(field, least_bytes)?;
        if count > most {
            return Err(DecodeError::Value { field, cause: format!("{count} are more than {most}") });
        }
        out.resize_with(count, T::default);
        out.iter_mut().try_for_each(|element| read(self, element))
    }

    /// The bytes of the elements of a sequence, each of `element_bytes`.
    fn elements(&mut self, field: &'static str, element_bytes: usize) -> Result<&'a [u8], DecodeError> {
        let count = self.count(field, element_bytes)?;
        if count == 0 {
            return Ok(&[]); // no alignment without elements
        }
        self.align(element_bytes);
        self.take(field, count * element_bytes)
    }

    /// The number of elements that a sequence claims, if there is room for them.
    fn count(&mut self, field: &'static str, least_bytes: usize) -> Result<usize, DecodeError> {
        let claimed = self.u32(field)?;
        let needed_bytes = u64::from(claimed) * least_bytes as u64;
        let left_bytes = (self.message.len() - self.at) as u64;
        if needed_bytes > left_bytes {
            return Err(DecodeError::Length { field, claimed, needed_bytes, left_bytes });
        }
        Ok(claimed as usize)
    }

    fn array<const N: usize>(&mut self, field: &'static str) -> Result<[u8; N], DecodeError> {
        self.align(N);
        let bytes = self.take(field, N)?;
        Ok(*bytes.first_chunk().expect("as many bytes as were asked for"))
    }

    fn align(&mut self, value_bytes: usize) {
        let alignment = match self.layout {
            Layout::Ros1 => return,
            Layout::Xcdr1 => value_bytes,
            Layout::Xcdr2 => value_bytes.min(4),
        };
        self.at = self.origin + (self.at - self.origin).next_multiple_of(alignment);
    }

    fn take(&mut self, field: &'static str, bytes: usize) -> Result<&'a [u8], DecodeError> {
        let taken = self.message.get(self.at..).and_then(|left| left.get(..bytes));
        let taken = taken.ok_or(DecodeError::Ended { field, bytes: self.message.len() })?;
        self.at += bytes;
        Ok(taken)
    }
}

fn encapsulation_name(id: u16) -> &'static str {
    match id {
        2 | 3 => "PL_CDR",
        4 => "XML",
        0x08 | 0x09 | 0x14 | 0x15 => "XCDR2 (delimited)",
        0x0a | 0x0b | 0x12 | 0x13 => "XCDR2 (PL_CDR2)",
        _ => "of an unknown encoding",
    }
}
