//! PLY: a header in text that declares elements, then the elements, in text or packed. Of these `vertex` has the points.

use crosscut_messages::NumberType;

use super::Parsed;
use super::layout::{Field, Layout, header_line, whole_points};
use crate::Damage;

/// A kind of element, and how many there are.
struct Element {
    name: String,
    count: u64,
    layout: Layout,
    /// For each list among its properties: its place among the fields, the type of its length, bytes of an entry.
    lists: Vec<(usize, NumberType, usize)>,
}

fn number_of(name: &str) -> Option<(NumberType, usize)> {
    Some(match name {
        "char" | "int8" => (NumberType::I8, 1),
        "uchar" | "uint8" => (NumberType::U8, 1),
        "short" | "int16" => (NumberType::I16, 2),
        "ushort" | "uint16" => (NumberType::U16, 2),
        "int" | "int32" => (NumberType::I32, 4),
        "uint" | "uint32" => (NumberType::U32, 4),
        "float" | "float32" => (NumberType::F32, 4),
        "double" | "float64" => (NumberType::F64, 8),
        _ => return None,
    })
}

/// Reads the points that are whole.
///
/// # Errors
/// When there are none.
pub(super) fn parse(bytes: &[u8]) -> Result<Parsed<'_>, Damage> {
    let (mut rest, mut encoding, mut elements, mut lines) = (bytes, String::new(), Vec::<Element>::new(), 0);
    loop {
        let (line, behind) = header_line(rest).ok_or(Damage::Ended)?;
        (rest, lines) = (behind, lines + 1);
        let wrong = || Damage::Record(format!("its line `{line:.60}` cannot be read"));
        match line.split_whitespace().collect::<Vec<_>>()[..] {
            ["format", name, _] => encoding = name.to_owned(),
            ["element", name, count] => {
                let count = count.parse().map_err(|_| wrong())?;
                let (name, layout) = (name.to_owned(), Layout::default());
                elements.push(Element { name, count, layout, lists: Vec::new() });
            }
            ["property", "list", length, entry, _] => {
                let element = elements.last_mut().ok_or_else(wrong)?;
                let ((length, _), (_, bytes)) = number_of(length).zip(number_of(entry)).ok_or_else(wrong)?;
                element.lists.push((element.layout.fields.len(), length, bytes));
            }
            ["property", kind, name] => {
                let (number, bytes) = number_of(kind).ok_or_else(wrong)?;
                let field = Field { name: name.to_owned(), number: Some(number), bytes, count: 1 };
                elements.last_mut().ok_or_else(wrong)?.layout.fields.push(field);
            }
            ["element" | "property" | "format", ..] => return Err(wrong()),
            ["end_header"] => break,
            _ => {}
        }
    }
    let Some(at) = elements.iter().position(|element| element.name == "vertex") else {
        return Err(Damage::Record("it has no element `vertex`".to_owned()));
    };
    let (before, vertex) = (&elements[..at], &elements[at]);
    if !vertex.lists.is_empty() {
        return Err(Damage::Record("its points have lists".to_owned()));
    }
    let is_bigendian = encoding == "binary_big_endian";
    let (cloud, losses) = match encoding.as_str() {
        "ascii" => {
            let passed: u64 = before.iter().map(|element| element.count).fold(0, u64::saturating_add);
            for _ in 0..passed {
                (_, rest) = text_line(rest).ok_or(Damage::Ended)?;
            }
            let at_byte = (bytes.len() - rest.len()) as u64;
            let read = vertex.layout.read_lines(rest, (lines + passed + 1, at_byte), vertex.count);
            (vertex.layout.cloud(read.data, false)?, read.losses)
        }
        "binary_little_endian" | "binary_big_endian" => {
            for element in before {
                rest = element.pass(rest, is_bigendian)?;
            }
            let at_byte = bytes.len() - rest.len();
            let (data, losses) = whole_points(rest, vertex.layout.point_bytes()?, vertex.count, at_byte);
            (vertex.layout.cloud(data, is_bigendian)?, losses)
        }
        _ => return Err(Damage::Record(format!("its format is `{encoding:.20}`, which is not known"))),
    };
    if cloud.width == 0 && vertex.count > 0 {
        return Err(Damage::Ended);
    }
    Ok(Parsed { cloud, encoding, losses })
}

/// The next line of a text, and what is behind it.
fn text_line(text: &[u8]) -> Option<(&[u8], &[u8])> {
    let end = text.iter().position(|byte| *byte == b'\n')?;
    Some((&text[..end], &text[end + 1..]))
}

impl Element {
    /// What is behind all elements of this kind in `data`.
    fn pass<'a>(&self, data: &'a [u8], is_bigendian: bool) -> Result<&'a [u8], Damage> {
        let bytes_of = |fields: &[Field]| fields.iter().map(|field| field.bytes).sum::<usize>();
        if self.lists.is_empty() {
            let bytes =
                usize::try_from(self.count).ok().and_then(|count| count.checked_mul(bytes_of(&self.layout.fields)));
            return bytes.and_then(|bytes| data.get(bytes..)).ok_or(Damage::Ended);
        }
        let mut rest = data;
        for _ in 0..self.count {
            let mut passed = 0;
            for &(place, length, entry_bytes) in &self.lists {
                rest = rest.get(bytes_of(&self.layout.fields[passed..place])..).ok_or(Damage::Ended)?;
                passed = place;
                let (entries, behind) = length_of(rest, length, is_bigendian).ok_or(Damage::Ended)?;
                rest = entries.checked_mul(entry_bytes).and_then(|bytes| behind.get(bytes..)).ok_or(Damage::Ended)?;
            }
            rest = rest.get(bytes_of(&self.layout.fields[passed..])..).ok_or(Damage::Ended)?;
        }
        Ok(rest)
    }
}

/// The length of a list, which no writer states as a float, and what is behind it.
fn length_of(data: &[u8], number: NumberType, is_bigendian: bool) -> Option<(usize, &[u8])> {
    let bytes = match number {
        NumberType::I8 | NumberType::U8 => 1,
        NumberType::I16 | NumberType::U16 => 2,
        NumberType::I32 | NumberType::U32 => 4,
        NumberType::F32 | NumberType::F64 => return None,
    };
    let (length, behind) = data.split_at_checked(bytes)?;
    let add = |sum: usize, byte: &u8| sum << 8 | usize::from(*byte);
    let length = if is_bigendian { length.iter().fold(0, add) } else { length.iter().rev().fold(0, add) };
    Some((length, behind))
}
