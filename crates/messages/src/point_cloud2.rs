//! `sensor_msgs/msg/PointCloud2`.

use std::borrow::Cow;

use serde::Serialize;

use crate::cloud::{PackedField, PackedPoints};
use crate::{Cloud, DecodeError, Fields, Header, MOST_FIELDS, NumberType, schema};

/// `sensor_msgs/msg/PointCloud2`: points packed into bytes, in rows. Its data is borrowed from the message.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct PointCloud2<'a> {
    /// Stamp, and the frame that the points are in.
    pub header: Header,
    /// Rows.
    pub height: u32,
    /// Points in a row.
    pub width: u32,
    /// What a point consists of.
    pub fields: Vec<PointField>,
    /// The byte order of the data.
    pub is_bigendian: bool,
    /// Bytes from a point to the next.
    pub point_step: u32,
    /// Bytes from a row to the next.
    pub row_step: u32,
    /// The points.
    pub data: Cow<'a, [u8]>,
    /// Whether every point is a return.
    pub is_dense: bool,
}

/// `sensor_msgs/msg/PointField`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct PointField {
    /// Its name, such as `x`.
    pub name: String,
    /// Where it begins in a point.
    pub offset: u32,
    /// Its type, as a number.
    pub datatype: u8,
    /// How many numbers of that type it has.
    pub count: u32,
}

impl PointField {
    /// An empty name and the numbers.
    const LEAST_BYTES: usize = 4 + 4 + 1 + 4;

    /// One number of a point.
    pub fn new(name: &str, offset: u32, number: NumberType) -> Self {
        let datatype = match number {
            NumberType::I8 => 1,
            NumberType::U8 => 2,
            NumberType::I16 => 3,
            NumberType::U16 => 4,
            NumberType::I32 => 5,
            NumberType::U32 => 6,
            NumberType::F32 => 7,
            NumberType::F64 => 8,
        };
        Self { name: name.to_owned(), offset, datatype, count: 1 }
    }

    fn number(&self) -> Option<NumberType> {
        Some(match self.datatype {
            1 => NumberType::I8,
            2 => NumberType::U8,
            3 => NumberType::I16,
            4 => NumberType::U16,
            5 => NumberType::I32,
            6 => NumberType::U32,
            7 => NumberType::F32,
            8 => NumberType::F64,
            _ => return None,
        })
    }

    fn read(&mut self, from: &mut Fields<'_>) -> Result<(), DecodeError> {
        from.text("fields", &mut self.name)?;
        self.offset = from.u32("fields")?;
        self.datatype = from.u8("fields")?;
        self.count = from.u32("fields")?;
        Ok(())
    }
}

impl From<&Cloud> for PointCloud2<'static> {
    /// A message of the same points: `x`, `y`, `z`, and `ring` and `time` if the cloud has them.
    fn from(cloud: &Cloud) -> Self {
        let has_rings = !cloud.rings.is_empty();
        let has_times = !cloud.times_s.is_empty();
        let columns = [("x", 8, true), ("y", 8, true), ("z", 8, true), ("ring", 4, has_rings), ("time", 8, has_times)];
        let (mut fields, mut point_step) = (Vec::new(), 0);
        for (name, bytes, is_there) in columns {
            if is_there {
                let number = if bytes == 4 { NumberType::U32 } else { NumberType::F64 };
                fields.push(PointField::new(name, point_step, number));
                point_step += bytes;
            }
        }
        let mut data = Vec::with_capacity(cloud.points_m.len() * point_step as usize);
        for (i, point_m) in cloud.points_m.iter().enumerate() {
            data.extend(point_m.iter().flat_map(|value| value.to_le_bytes()));
            data.extend(cloud.rings.get(i).into_iter().flat_map(|ring| ring.to_le_bytes()));
            data.extend(cloud.times_s.get(i).into_iter().flat_map(|time_s| time_s.to_le_bytes()));
        }
        Self {
            header: cloud.header.clone(),
            height: 1,
            width: cloud.points_m.len() as u32,
            fields,
            is_bigendian: false,
            point_step,
            row_step: data.len() as u32,
            data: data.into(),
            is_dense: false,
        }
    }
}

impl<'a> PointCloud2<'a> {
    /// Its type, as ROS 2 names it.
    pub const SCHEMA_NAME: &'static str = "sensor_msgs/msg/PointCloud2";
    /// Its definition with all that it depends on, in [`SCHEMA_ENCODING`](crate::SCHEMA_ENCODING).
    pub const SCHEMA_TEXT: &'static str = schema::POINT_CLOUD2;

    /// Reads the fields in order.
    ///
    /// # Errors
    /// At the first field that cannot be read.
    pub fn read(from: &mut Fields<'a>) -> Result<Self, DecodeError> {
        let mut cloud = Self::default();
        cloud.header.read(from)?;
        cloud.height = from.u32("height")?;
        cloud.width = from.u32("width")?;
        let read = |from: &mut Fields<'a>, field: &mut PointField| field.read(from);
        from.structures("fields", PointField::LEAST_BYTES, MOST_FIELDS, &mut cloud.fields, read)?;
        cloud.is_bigendian = from.u8("is_bigendian")? != 0;
        cloud.point_step = from.u32("point_step")?;
        cloud.row_step = from.u32("row_step")?;
        cloud.data = Cow::Borrowed(from.bytes("data")?);
        cloud.is_dense = from.u8("is_dense")? != 0;
        Ok(cloud)
    }

    /// Writes the points into `out`, whatever it held before.
    ///
    /// # Errors
    /// When there is no x or y, a field that is used lies beyond its point, or the data is shorter than the points are.
    pub fn write_cloud(&self, out: &mut Cloud) -> Result<(), DecodeError> {
        out.header.clone_from(&self.header);
        let packed =
            |field: &PointField| PackedField { name: field.name.clone(), offset: field.offset, number: field.number() };
        let fields: Vec<_> = self.fields.iter().map(packed).collect();
        let points = PackedPoints {
            rows: self.height,
            columns: self.width,
            point_bytes: self.point_step,
            row_bytes: self.row_step,
            is_big_endian: self.is_bigendian,
            fields: &fields,
            data: &self.data,
        };
        points.write(out)
    }

    /// The message in CDR with its encapsulation header.
    #[cfg(feature = "encode")]
    pub fn encode(&self, endian: crate::Endian) -> Vec<u8> {
        crate::message::encode(self, endian)
    }
}
