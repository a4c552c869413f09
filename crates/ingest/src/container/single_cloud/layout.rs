//! What a point of a file consists of, and points in text.

use std::borrow::Cow;

use crosscut_messages::{Header, NumberType, PointCloud2, PointField};

use crate::{Damage, LossKind};

/// The numbers of a point, in order.
#[derive(Default)]
pub(super) struct Layout {
    pub(super) fields: Vec<Field>,
}

/// One number of a point, or several.
pub(super) struct Field {
    pub(super) name: String,
    /// `None` for whole numbers of 8 bytes, which are passed over.
    pub(super) number: Option<NumberType>,
    /// Bytes of one number.
    pub(super) bytes: usize,
    pub(super) count: usize,
}

impl Field {
    fn all_bytes(&self) -> usize {
        self.bytes.saturating_mul(self.count)
    }
}

impl Layout {
    /// Bytes of a point.
    ///
    /// # Errors
    /// When there are none, or more than a message states.
    pub(super) fn point_bytes(&self) -> Result<usize, Damage> {
        let bytes = self.fields.iter().fold(0usize, |sum, field| sum.saturating_add(field.all_bytes()));
        if (1..=u32::MAX as usize).contains(&bytes) {
            Ok(bytes)
        } else {
            Err(Damage::Record(format!("its points have {bytes} bytes")))
        }
    }

    /// The cloud of the points in `data`, each of [`point_bytes`](Self::point_bytes).
    pub(super) fn cloud<'a>(
        &self,
        data: impl Into<Cow<'a, [u8]>>,
        is_bigendian: bool,
    ) -> Result<PointCloud2<'a>, Damage> {
        let (data, point_bytes) = (data.into(), self.point_bytes()?);
        let mut offset = 0;
        let mut fields = Vec::new();
        for field in &self.fields {
            fields.extend(field.number.map(|number| PointField::new(&field.name, offset as u32, number)));
            offset += field.all_bytes();
        }
        Ok(PointCloud2 {
            header: Header { frame_id: "cloud".to_owned(), ..Header::default() },
            height: 1,
            width: (data.len() / point_bytes) as u32,
            fields,
            is_bigendian,
            point_step: point_bytes as u32,
            row_step: data.len() as u32,
            data,
            is_dense: false,
        })
    }

    /// Reads up to `points` points from a text, one a line, beginning at this line and byte of its file. Lines that cannot
    /// be read are left out. A last line without an end counts only if it is that of the last point.
    pub(super) fn read_lines(&self, text: &[u8], (first_line, first_byte): (u64, u64), points: u64) -> Lines {
        let mut lines = Lines::default();
        let (mut rest, mut number, mut read, mut wrong) = (text, first_line, 0, None);
        while read < points {
            let at_byte = first_byte + (text.len() - rest.len()) as u64;
            let end = rest.iter().position(|byte| *byte == b'\n');
            let line = String::from_utf8_lossy(&rest[..end.unwrap_or(rest.len())]);
            let before = lines.data.len();
            let is_blank = line.trim().is_empty();
            let added = if is_blank { Ok(()) } else { self.add(&line, &mut lines.data) };
            read += u64::from(!is_blank);
            if end.is_none() && (added.is_err() || read < points) {
                lines.data.truncate(before);
                lines.losses.push(LossKind::CutOff { at_byte });
                break;
            }
            if let Err(cause) = added {
                lines.data.truncate(before);
                wrong.get_or_insert((number, 0, cause)).1 += 1;
            }
            match end {
                Some(end) => rest = &rest[end + 1..],
                None => lines.losses.push(LossKind::LastLine { line: number }),
            }
            number += 1;
        }
        lines.losses.extend(wrong.map(|(first, count, cause)| LossKind::Lines { first, count, cause }));
        lines
    }

    /// Adds the point in `line` to `data`, packed.
    fn add(&self, line: &str, data: &mut Vec<u8>) -> Result<(), String> {
        let mut words = line.split_whitespace();
        for field in &self.fields {
            for _ in 0..field.count {
                let word = words.next().ok_or_else(|| format!("it ends before its {}", field.name))?;
                let value: f64 = word.parse().map_err(|_| format!("`{word:.20}` is no {}", field.name))?;
                match field.number {
                    Some(number) => push(value, number, data),
                    None => data.extend([0; 8]),
                }
            }
        }
        Ok(())
    }
}

/// Points that were read from a text.
#[derive(Default)]
pub(super) struct Lines {
    /// Packed, in little-endian order.
    pub(super) data: Vec<u8>,
    pub(super) losses: Vec<LossKind>,
}

fn push(value: f64, number: NumberType, data: &mut Vec<u8>) {
    match number {
        NumberType::I8 => data.extend((value as i8).to_le_bytes()),
        NumberType::U8 => data.extend((value as u8).to_le_bytes()),
        NumberType::I16 => data.extend((value as i16).to_le_bytes()),
        NumberType::U16 => data.extend((value as u16).to_le_bytes()),
        NumberType::I32 => data.extend((value as i32).to_le_bytes()),
        NumberType::U32 => data.extend((value as u32).to_le_bytes()),
        NumberType::F32 => data.extend((value as f32).to_le_bytes()),
        NumberType::F64 => data.extend(value.to_le_bytes()),
    }
}

/// The points that are whole among the `points` in `data`, which begins at `at_byte` of its file, and what is missing.
pub(super) fn whole_points(data: &[u8], point_bytes: usize, points: u64, at_byte: usize) -> (&[u8], Vec<LossKind>) {
    let there = (data.len() / point_bytes).min(usize::try_from(points).unwrap_or(usize::MAX));
    let whole = &data[..there * point_bytes];
    let is_cut = (there as u64) < points;
    let loss = is_cut.then_some(LossKind::CutOff { at_byte: (at_byte + whole.len()) as u64 });
    (whole, loss.into_iter().collect())
}

/// The next line of a header without its end, and the bytes behind it; `None` where the bytes end before the line does.
pub(super) fn header_line(bytes: &[u8]) -> Option<(Cow<'_, str>, &[u8])> {
    let end = bytes.iter().take(4096).position(|byte| *byte == b'\n')?;
    let line = bytes[..end].strip_suffix(b"\r").unwrap_or(&bytes[..end]);
    Some((String::from_utf8_lossy(line), &bytes[end + 1..]))
}
