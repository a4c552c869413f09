//! As much of Thrift's compact protocol as the headers of a Parquet file take.

/// The types of fields and of list elements.
const I32: u8 = 5;
const I64: u8 = 6;
const BINARY: u8 = 8;
const LIST: u8 = 9;
const STRUCT: u8 = 12;

/// A struct being written, field by field in the order of their numbers.
#[derive(Default)]
pub(super) struct Struct {
    bytes: Vec<u8>,
    last_field: u8,
}

impl Struct {
    pub(super) fn i32(self, field: u8, value: i32) -> Self {
        self.field(field, I32, &varint(zigzag(value.into())))
    }

    pub(super) fn i64(self, field: u8, value: i64) -> Self {
        self.field(field, I64, &varint(zigzag(value)))
    }

    pub(super) fn text(self, field: u8, text: &str) -> Self {
        self.field(field, BINARY, &binary(text))
    }

    pub(super) fn group(self, field: u8, group: Self) -> Self {
        self.field(field, STRUCT, &group.end())
    }

    pub(super) fn groups(self, field: u8, groups: impl IntoIterator<Item = Self>) -> Self {
        self.list(field, STRUCT, groups.into_iter().map(Self::end).collect())
    }

    pub(super) fn i32s(self, field: u8, values: &[i32]) -> Self {
        self.list(field, I32, values.iter().map(|&value| varint(zigzag(value.into()))).collect())
    }

    pub(super) fn texts(self, field: u8, texts: &[&str]) -> Self {
        self.list(field, BINARY, texts.iter().map(|text| binary(text)).collect())
    }

    /// Its bytes.
    pub(super) fn end(mut self) -> Vec<u8> {
        self.bytes.push(0);
        self.bytes
    }

    /// A field's number is written as what it is more than the one before.
    fn field(mut self, field: u8, kind: u8, value: &[u8]) -> Self {
        debug_assert!((1..16).contains(&(field - self.last_field)), "fields come in order");
        self.bytes.push((field - self.last_field) << 4 | kind);
        self.bytes.extend_from_slice(value);
        self.last_field = field;
        self
    }

    fn list(self, field: u8, kind: u8, items: Vec<Vec<u8>>) -> Self {
        let mut bytes = match items.len() {
            few @ 0..15 => vec![(few as u8) << 4 | kind],
            many => [vec![0xF0 | kind], varint(many as u64)].concat(),
        };
        bytes.extend(items.concat());
        self.field(field, LIST, &bytes)
    }
}

fn binary(text: &str) -> Vec<u8> {
    [&varint(text.len() as u64), text.as_bytes()].concat()
}

/// 0, -1, 1, -2... as 0, 1, 2, 3...
fn zigzag(value: i64) -> u64 {
    (value.cast_unsigned() << 1) ^ (value >> 63).cast_unsigned()
}

/// Seven bits a byte, the lowest first.
fn varint(mut value: u64) -> Vec<u8> {
    let mut bytes = Vec::new();
    while value >= 0x80 {
        bytes.push(value as u8 | 0x80);
        value >>= 7;
    }
    bytes.push(value as u8);
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_those_of_the_protocol() {
        assert_eq!([0, -1, 1, i64::MIN].map(zigzag), [0, 1, 2, u64::MAX]);
        assert_eq!(varint(300), [0xAC, 0x02]);
        assert_eq!(Struct::default().i32(1, 1).text(4, "ab").end(), [0x15, 2, 0x38, 2, b'a', b'b', 0]);
        assert_eq!(Struct::default().i32s(2, &[0; 2]).end(), [0x29, 0x25, 0, 0, 0]);
        assert_eq!(Struct::default().i32s(2, &[0; 20]).end()[..3], [0x29, 0xF5, 20]);
    }
}
