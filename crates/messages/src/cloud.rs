//! Point clouds, as the packed points of a message give them.

use crate::{DecodeError, Header, MOST_POINTS};

/// Points measured more than this before or after the stamp are not of one turn: their times are of another unit.
const LONGEST_TURN_S: f64 = 10.0;

/// Times that count seconds or nanoseconds since the epoch, and not since the stamp, are beyond these.
const EPOCH_S: f64 = 1e8;
const EPOCH_NS: f64 = 1e15;

/// Names under which drivers give the time of a point: Ouster, Velodyne, Hesai and RoboSense, Livox.
const TIME_NAMES: [&str; 4] = ["t", "time", "timestamp", "offset_time"];
/// Names under which drivers give the ring of a point: Velodyne, Hesai, Ouster and RoboSense; Livox.
const RING_NAMES: [&str; 3] = ["ring", "channel", "line"];

/// The points of one message.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cloud {
    /// Stamp, and the frame that the points are in.
    pub header: Header,
    /// Places, m, in the order of the message. In an organised cloud those without a return are NaN.
    pub points_m: Vec<[f64; 3]>,
    /// When each point was measured, s after the stamp; empty if the message does not say.
    pub times_s: Vec<f64>,
    /// The ring of each point, which is its laser in a rotating lidar; empty if the message does not say.
    pub rings: Vec<u32>,
}

/// The type of a number in a packed point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)] // the names say it all
pub enum NumberType {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

/// One field of a packed point.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct PackedField {
    pub(crate) name: String,
    pub(crate) offset: u32,
    /// `None` for a type that is not known, which matters only if the field is used.
    pub(crate) number: Option<NumberType>,
}

/// How the points of a message lie in its data.
#[derive(Debug)]
pub(crate) struct PackedPoints<'a> {
    pub(crate) rows: u32,
    pub(crate) columns: u32,
    pub(crate) point_bytes: u32,
    /// From a row to the next, which may be padded; what is less than the points of a row take is not believed.
    pub(crate) row_bytes: u32,
    pub(crate) is_big_endian: bool,
    pub(crate) fields: &'a [PackedField],
    pub(crate) data: &'a [u8],
}

/// Where a number lies in each point.
#[derive(Clone, Copy)]
struct Column {
    offset: usize,
    number: NumberType,
    is_big_endian: bool,
}

impl NumberType {
    const fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    fn is_whole(self) -> bool {
        !matches!(self, Self::F32 | Self::F64)
    }
}

impl Column {
    /// The number in `point`, which has room for it.
    fn of(self, point: &[u8]) -> f64 {
        let bytes = &point[self.offset..];
        macro_rules! number {
            ($type:ty) => {{
                let bytes = *bytes.first_chunk().expect("the field was checked to lie within the point");
                if self.is_big_endian { <$type>::from_be_bytes(bytes) } else { <$type>::from_le_bytes(bytes) }
            }};
        }
        match self.number {
            NumberType::I8 => f64::from(number!(i8)),
            NumberType::U8 => f64::from(number!(u8)),
            NumberType::I16 => f64::from(number!(i16)),
            NumberType::U16 => f64::from(number!(u16)),
            NumberType::I32 => f64::from(number!(i32)),
            NumberType::U32 => f64::from(number!(u32)),
            NumberType::F32 => f64::from(number!(f32)),
            NumberType::F64 => number!(f64),
        }
    }
}

impl<'a> PackedPoints<'a> {
    /// Writes the points into `out`, whose header is there already, whatever else it held before.
    ///
    /// # Errors
    /// When there is no x or y, a field that is used lies beyond its point, the data is shorter than the points are, or
    /// there are more than [`MOST_POINTS`].
    pub(crate) fn write(&self, out: &mut Cloud) -> Result<(), DecodeError> {
        out.points_m.clear();
        out.times_s.clear();
        out.rings.clear();
        if self.rows == 0 || self.columns == 0 {
            return Ok(());
        }
        let (x, y) = (self.required("x")?, self.required("y")?);
        let z = self.column(&["z"])?;
        self.check_room()?;
        let place = |point| [x.of(point), y.of(point), z.map_or(0.0, |z| z.of(point))];
        out.points_m.extend(self.points().map(place));
        if let Some(ring) = self.column(&RING_NAMES)? {
            out.rings.extend(self.points().map(|point| ring.of(point) as u32));
        }
        if let Some(time) = self.column(&TIME_NAMES)? {
            out.times_s.extend(self.points().map(|point| time.of(point)));
            let stamp_ns = out.header.stamp.to_ns().unwrap_or(0) as f64;
            let seconds = if time.number.is_whole() { 1e-9 } else { 1.0 };
            let since_stamp_s = |time: f64| match time.abs() {
                EPOCH_NS.. => (time - stamp_ns) * 1e-9,
                EPOCH_S.. if seconds == 1.0 => time - stamp_ns * 1e-9,
                _ => time * seconds,
            };
            out.times_s.iter_mut().for_each(|time| *time = since_stamp_s(*time));
            if out.times_s.iter().any(|time_s| !(-LONGEST_TURN_S..=LONGEST_TURN_S).contains(time_s)) {
                out.times_s.clear();
            }
        }
        Ok(())
    }

    fn required(&self, name: &'static str) -> Result<Column, DecodeError> {
        self.column(&[name])?
            .ok_or_else(|| DecodeError::Value { field: "fields", cause: format!("there is no `{name}` among them") })
    }

    /// The first field with one of these names.
    fn column(&self, names: &[&'static str]) -> Result<Option<Column>, DecodeError> {
        let Some(field) = names.iter().find_map(|name| self.fields.iter().find(|field| field.name == *name)) else {
            return Ok(None);
        };
        let refused = |cause| Err(DecodeError::Value { field: "fields", cause });
        let Some(number) = field.number else {
            return refused(format!("the type of `{}` is not known", field.name));
        };
        if u64::from(field.offset) + number.bytes() as u64 > u64::from(self.point_bytes) {
            return refused(format!("`{}` lies beyond the {} bytes of a point", field.name, self.point_bytes));
        }
        Ok(Some(Column { offset: field.offset as usize, number, is_big_endian: self.is_big_endian }))
    }

    fn bytes_of_a_row(&self) -> u64 {
        u64::from(self.row_bytes).max(u64::from(self.columns) * u64::from(self.point_bytes))
    }

    /// The last row need not be padded.
    fn check_room(&self) -> Result<(), DecodeError> {
        let last = u128::from(self.columns) * u128::from(self.point_bytes);
        let needed = u128::from(self.rows - 1) * u128::from(self.bytes_of_a_row()) + last;
        if needed > self.data.len() as u128 {
            let cause = format!(
                "{} x {} points of {} bytes take {needed} bytes, but it has {}",
                self.rows,
                self.columns,
                self.point_bytes,
                self.data.len()
            );
            return Err(DecodeError::Value { field: "data", cause });
        }
        let points = u64::from(self.rows) * u64::from(self.columns);
        if points > MOST_POINTS as u64 {
            let cause = format!("{points} points are more than {MOST_POINTS}");
            return Err(DecodeError::Value { field: "data", cause });
        }
        Ok(())
    }

    /// The bytes of each point, for which there is room.
    fn points(&self) -> impl Iterator<Item = &'a [u8]> {
        let (columns, point_bytes) = (self.columns as usize, self.point_bytes as usize);
        let rows = self.data.chunks(self.bytes_of_a_row() as usize).take(self.rows as usize);
        rows.flat_map(move |row| row.chunks_exact(point_bytes).take(columns))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Time;

    fn field(name: &str, offset: u32, number: NumberType) -> PackedField {
        PackedField { name: name.to_owned(), offset, number: Some(number) }
    }

    fn times_of(name: &str, number: NumberType, data: &[u8]) -> Vec<f64> {
        let fields = [field("x", 0, NumberType::U8), field("y", 0, NumberType::U8), field(name, 0, number)];
        let points = PackedPoints {
            rows: 1,
            columns: 1,
            point_bytes: data.len() as u32,
            row_bytes: 0,
            is_big_endian: false,
            fields: &fields,
            data,
        };
        let header = Header { stamp: Time { sec: 1_700_000_000, nanosec: 0 }, ..Header::default() };
        let mut cloud = Cloud { header, ..Cloud::default() };
        points.write(&mut cloud).expect("one point");
        cloud.times_s
    }

    #[test]
    fn times_of_every_driver_become_seconds_after_the_stamp() {
        let near = |times_s: &[f64]| assert!((times_s[0] - 0.05).abs() < 1e-6, "{times_s:?}");
        near(&times_of("t", NumberType::U32, &50_000_000u32.to_le_bytes()));
        near(&times_of("offset_time", NumberType::U32, &50_000_000u32.to_le_bytes()));
        near(&times_of("time", NumberType::F32, &0.05f32.to_le_bytes()));
        near(&times_of("timestamp", NumberType::F64, &1_700_000_000.05f64.to_le_bytes()));
        near(&times_of("timestamp", NumberType::F64, &1_700_000_000_050_000_000f64.to_le_bytes()));
        assert_eq!(times_of("time", NumberType::F32, &5e4f32.to_le_bytes()), [0.0; 0], "microseconds are of no use");
        assert_eq!(times_of("time", NumberType::F32, &f32::NAN.to_le_bytes()), [0.0; 0]);
        assert_eq!(times_of("intensity", NumberType::F32, &0.05f32.to_le_bytes()), [0.0; 0]);
    }
}
