//! PCD, of the Point Cloud Library: a header in text, then points as text, packed, or packed by field and compressed.
//!
//! The points are taken in the frame that they are stored in: VIEWPOINT is not applied, as PCL's own tools do not.

use crosscut_messages::NumberType;

use super::Parsed;
use super::layout::{Field, Layout, header_line, whole_points};
use crate::{Damage, limits};

/// The header, as far as it was read.
#[derive(Default)]
struct Head {
    layout: Layout,
    width: u64,
    height: u64,
    points: Option<u64>,
    lines: u64,
}

impl Head {
    /// Takes a line of the header; `true` if it is the last one.
    fn take(&mut self, line: &str) -> Result<bool, Damage> {
        let wrong = || Damage::Record(format!("its line `{line:.60}` cannot be read"));
        let mut words = line.split_whitespace();
        let key = words.next().unwrap_or_default();
        let values: Vec<&str> = words.collect();
        let number = || values.first().and_then(|value| value.parse().ok()).ok_or_else(wrong);
        let sizes = || values.iter().map(|value| value.parse::<u16>().map(usize::from).ok());
        let fields = &mut self.layout.fields;
        let fits = values.len() == fields.len();
        match key {
            "FIELDS" | "COLUMNS" => {
                let field = |name: &&str| Field { name: (*name).to_owned(), number: None, bytes: 4, count: 1 };
                *fields = values.iter().map(field).collect();
            }
            "SIZE" if fits => {
                for (field, bytes) in fields.iter_mut().zip(sizes()) {
                    field.bytes = bytes.ok_or_else(wrong)?;
                }
            }
            "COUNT" if fits => {
                for (field, count) in fields.iter_mut().zip(sizes()) {
                    field.count = count.ok_or_else(wrong)?;
                }
            }
            "TYPE" if fits => {
                for (field, kind) in fields.iter_mut().zip(&values) {
                    field.number = number_of(kind, field.bytes);
                    if field.number.is_none() && field.bytes != 8 {
                        return Err(wrong());
                    }
                }
            }
            "WIDTH" => self.width = number()?,
            "HEIGHT" => self.height = number()?,
            "POINTS" => self.points = Some(number()?),
            "SIZE" | "COUNT" | "TYPE" => return Err(wrong()),
            "DATA" => return Ok(true),
            _ => {}
        }
        Ok(false)
    }

    fn points(&self) -> u64 {
        self.points.unwrap_or(self.width.saturating_mul(self.height))
    }
}

fn number_of(kind: &str, bytes: usize) -> Option<NumberType> {
    Some(match (kind, bytes) {
        ("I", 1) => NumberType::I8,
        ("I", 2) => NumberType::I16,
        ("I", 4) => NumberType::I32,
        ("U", 1) => NumberType::U8,
        ("U", 2) => NumberType::U16,
        ("U", 4) => NumberType::U32,
        ("F", 4) => NumberType::F32,
        ("F", 8) => NumberType::F64,
        _ => return None,
    })
}

/// Reads the points that are whole.
///
/// # Errors
/// When there are none.
pub(super) fn parse(bytes: &[u8]) -> Result<Parsed<'_>, Damage> {
    let (mut head, mut rest) = (Head::default(), bytes);
    let encoding = loop {
        let (line, behind) = header_line(rest).ok_or(Damage::Ended)?;
        rest = behind;
        head.lines += 1;
        if head.take(&line)? {
            break line.split_whitespace().nth(1).unwrap_or_default().to_lowercase();
        }
    };
    let (layout, points, at_byte) = (&head.layout, head.points(), bytes.len() - rest.len());
    let point_bytes = layout.point_bytes()?;
    let (cloud, losses) = match encoding.as_str() {
        "ascii" => {
            let lines = layout.read_lines(rest, (head.lines + 1, at_byte as u64), points);
            (layout.cloud(lines.data, false)?, lines.losses)
        }
        "binary" => {
            let (data, losses) = whole_points(rest, point_bytes, points, at_byte);
            (layout.cloud(data, false)?, losses)
        }
        "binary_compressed" => (layout.cloud(uncompressed(rest, layout, point_bytes, points)?, false)?, Vec::new()),
        _ => return Err(Damage::Record(format!("its data is `{encoding:.20}`, which is not known"))),
    };
    if cloud.width == 0 && points > 0 {
        return Err(Damage::Ended);
    }
    Ok(Parsed { cloud, encoding, losses })
}

/// Decompresses points that are stored field by field, and packs them point by point.
fn uncompressed(data: &[u8], layout: &Layout, point_bytes: usize, points: u64) -> Result<Vec<u8>, Damage> {
    let (sizes, data) = data.split_first_chunk::<8>().ok_or(Damage::Ended)?;
    let [compressed, plain] =
        [0, 4].map(|at| u32::from_le_bytes([sizes[at], sizes[at + 1], sizes[at + 2], sizes[at + 3]]));
    if u64::from(plain) > limits::MESSAGE_BYTES {
        return Err(Damage::TooLarge { bytes: plain.into(), limit: limits::MESSAGE_BYTES });
    }
    let data = data.get(..compressed as usize).ok_or(Damage::Ended)?;
    if u64::from(plain) != points.saturating_mul(point_bytes as u64) {
        return Err(Damage::Record(format!("{points} points of {point_bytes} bytes do not take {plain} bytes")));
    }
    let by_field = lzf(data, plain as usize).ok_or_else(|| Damage::Record("it cannot be decompressed".to_owned()))?;
    let mut packed = vec![0; by_field.len()];
    let (mut from, mut offset) = (&by_field[..], 0);
    for field in &layout.fields {
        let bytes = field.bytes * field.count;
        let (column, behind) = from.split_at(bytes * points as usize);
        if bytes > 0 {
            for (value, point) in column.chunks_exact(bytes).zip(packed.chunks_exact_mut(point_bytes)) {
                point[offset..offset + bytes].copy_from_slice(value);
            }
        }
        (from, offset) = (behind, offset + bytes);
    }
    Ok(packed)
}

/// Decompresses LZF: runs of bytes, and copies of what came before. `None` if the result would not have `bytes` bytes.
fn lzf(mut input: &[u8], bytes: usize) -> Option<Vec<u8>> {
    let mut out = Vec::new();
    while let Some((&control, rest)) = input.split_first() {
        let control = usize::from(control);
        if control < 32 {
            let (run, rest) = rest.split_at_checked(control + 1)?;
            out.extend_from_slice(run);
            input = rest;
        } else {
            let (mut length, mut rest) = ((control >> 5) + 2, rest);
            if length == 9 {
                let (&more, behind) = rest.split_first()?;
                (length, rest) = (length + usize::from(more), behind);
            }
            let (&low, rest) = rest.split_first()?;
            let from =
                out.len().checked_sub((control & 31) << 8 | usize::from(low)).and_then(|at| at.checked_sub(1))?;
            for at in from..from + length {
                out.push(out[at]);
            }
            input = rest;
        }
        if out.len() > bytes {
            return None;
        }
    }
    (out.len() == bytes).then_some(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_and_copies_are_decompressed() {
        // "abc", then 7 bytes from 3 back, which the copy itself makes, then 9 + 1 bytes from 1 back.
        let packed = [2, b'a', b'b', b'c', (5 << 5), 2, (7 << 5), 1, 0];
        assert_eq!(lzf(&packed, 20).as_deref(), Some(&b"abcabcabcaaaaaaaaaaa"[..]));
        assert_eq!(lzf(&packed, 19), None);
        assert_eq!(lzf(&packed[..8], 20), None, "cut");
        assert_eq!(lzf(&[32, 0, 0], 3), None, "a copy of what is not there");
        assert_eq!(lzf(&[], 0), Some(Vec::new()));
    }
}
