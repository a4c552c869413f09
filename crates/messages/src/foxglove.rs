//! Scans and clouds of Foxglove's schemas, in JSON or protobuf, and as messages of ROS (package `foxglove_msgs`).

use std::fmt;
use std::marker::PhantomData;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use prost::encoding::{DecodeContext, decode_key, skip_field};
use serde::de::{Error as _, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

use crate::cloud::{PackedField, PackedPoints};
use crate::{
    Cloud, DecodeError, Fields, Header, LaserScan, MOST_BEAMS, MOST_FIELDS, NumberType, Quaternion, Time, Vector3,
};

/// `foxglove.LaserScan`.
#[derive(Clone, PartialEq, prost::Message, Deserialize)]
#[serde(default)]
pub(crate) struct FoxgloveScan {
    #[prost(message, optional, tag = "1")]
    timestamp: Option<Timestamp>,
    #[prost(bytes = "vec", tag = "2")]
    #[serde(deserialize_with = "text_bytes")]
    frame_id: Vec<u8>,
    #[prost(message, optional, tag = "3")]
    pose: Option<FoxglovePose>,
    #[prost(double, tag = "4")]
    start_angle: f64,
    #[prost(double, tag = "5")]
    end_angle: f64,
    #[prost(double, repeated, tag = "6")]
    #[serde(deserialize_with = "numbers")]
    ranges: Vec<f64>,
    #[prost(double, repeated, tag = "7")]
    #[serde(deserialize_with = "numbers")]
    intensities: Vec<f64>,
}

/// Of [`FoxgloveCloud::fields`].
const FIELDS_TAG: u32 = 5;

/// `foxglove.PointCloud`.
#[derive(Clone, PartialEq, prost::Message, Deserialize)]
#[serde(default)]
pub(crate) struct FoxgloveCloud {
    #[prost(message, optional, tag = "1")]
    timestamp: Option<Timestamp>,
    #[prost(bytes = "vec", tag = "2")]
    #[serde(deserialize_with = "text_bytes")]
    frame_id: Vec<u8>,
    #[prost(message, optional, tag = "3")]
    pose: Option<FoxglovePose>,
    #[prost(fixed32, tag = "4")]
    point_stride: u32,
    #[prost(message, repeated, tag = "5")]
    #[serde(deserialize_with = "fields")]
    fields: Vec<PackedElementField>,
    #[prost(bytes = "vec", tag = "6")]
    #[serde(deserialize_with = "base64_bytes")]
    data: Vec<u8>,
}

#[derive(Clone, Copy, PartialEq, prost::Message, Deserialize)]
#[serde(default)]
pub(crate) struct Timestamp {
    #[prost(int64, tag = "1")]
    pub(crate) sec: i64,
    #[prost(int32, tag = "2")]
    pub(crate) nsec: i32,
}

#[derive(Clone, Copy, PartialEq, prost::Message, Deserialize)]
#[serde(default)]
pub(crate) struct FoxglovePose {
    #[prost(message, optional, tag = "1")]
    pub(crate) position: Option<FoxgloveVector>,
    #[prost(message, optional, tag = "2")]
    pub(crate) orientation: Option<FoxgloveQuaternion>,
}

#[derive(Clone, Copy, PartialEq, prost::Message, Deserialize)]
#[serde(default)]
pub(crate) struct FoxgloveVector {
    #[prost(double, tag = "1")]
    pub(crate) x: f64,
    #[prost(double, tag = "2")]
    pub(crate) y: f64,
    #[prost(double, tag = "3")]
    pub(crate) z: f64,
}

#[derive(Clone, Copy, PartialEq, prost::Message, Deserialize)]
#[serde(default)]
pub(crate) struct FoxgloveQuaternion {
    #[prost(double, tag = "1")]
    pub(crate) x: f64,
    #[prost(double, tag = "2")]
    pub(crate) y: f64,
    #[prost(double, tag = "3")]
    pub(crate) z: f64,
    #[prost(double, tag = "4")]
    pub(crate) w: f64,
}

#[derive(Clone, PartialEq, prost::Message, Deserialize)]
#[serde(default)]
struct PackedElementField {
    #[prost(bytes = "vec", tag = "1")]
    #[serde(deserialize_with = "text_bytes")]
    name: Vec<u8>,
    #[prost(fixed32, tag = "2")]
    offset: u32,
    #[prost(int32, tag = "3")]
    r#type: i32,
}

/// A message of JSON; bytes that are not UTF-8 become replacement characters.
pub(crate) fn of_json<T: for<'de> Deserialize<'de>>(message: &[u8]) -> Result<T, DecodeError> {
    let refused = |error: serde_json::Error| DecodeError::Format { encoding: "JSON", cause: error.to_string() };
    serde_json::from_str(&String::from_utf8_lossy(message)).map_err(refused)
}

/// A message of protobuf.
pub(crate) fn of_protobuf<T: prost::Message + Default>(message: &[u8]) -> Result<T, DecodeError> {
    T::decode(message).map_err(not_protobuf)
}

fn not_protobuf(error: prost::DecodeError) -> DecodeError {
    DecodeError::Format { encoding: "protobuf", cause: error.to_string() }
}

impl FoxgloveScan {
    /// The next `foxglove_msgs/LaserScan`.
    pub(crate) fn read(from: &mut Fields<'_>) -> Result<Self, DecodeError> {
        let (timestamp, frame_id, pose) = read_header(from)?;
        let mut scan = Self { timestamp, frame_id, pose, ..Self::default() };
        scan.start_angle = from.f64("start_angle")?;
        scan.end_angle = from.f64("end_angle")?;
        from.f64s("ranges", &mut scan.ranges)?;
        from.f64s("intensities", &mut scan.intensities)?;
        Ok(scan)
    }

    /// Writes the scan into `out`, whatever it held before. The schema has no limits of range; a pose turns the beams.
    pub(crate) fn write_scan(&self, out: &mut LaserScan) {
        write_header(self.timestamp, &self.frame_id, &mut out.header);
        let yaw_rad = self.pose.unwrap_or_default().rotation().yaw_rad();
        let steps = self.ranges.len().saturating_sub(1).max(1) as f64;
        out.angle_min = (yaw_rad + self.start_angle) as f32;
        out.angle_max = (yaw_rad + self.end_angle) as f32;
        out.angle_increment = ((self.end_angle - self.start_angle) / steps) as f32;
        (out.time_increment, out.scan_time) = (0.0, 0.0);
        (out.range_min, out.range_max) = (0.0, f32::INFINITY);
        for (from, to) in [(&self.ranges, &mut out.ranges), (&self.intensities, &mut out.intensities)] {
            to.clear();
            to.extend(from.iter().map(|&value| value as f32));
        }
    }
}

impl FoxgloveCloud {
    /// The next `foxglove_msgs/PointCloud`.
    pub(crate) fn read(from: &mut Fields<'_>) -> Result<Self, DecodeError> {
        let (timestamp, frame_id, pose) = read_header(from)?;
        let mut cloud = Self { timestamp, frame_id, pose, ..Self::default() };
        cloud.point_stride = from.u32("point_stride")?;
        // A name, an offset and a type.
        from.structures("fields", 9, MOST_FIELDS, &mut cloud.fields, |from, field| {
            let mut name = String::new();
            from.text("fields.name", &mut name)?;
            field.name = name.into_bytes();
            field.offset = from.u32("fields.offset")?;
            field.r#type = i32::from(from.u8("fields.type")?);
            Ok(())
        })?;
        cloud.data = from.bytes("data")?.to_vec();
        Ok(cloud)
    }

    /// A cloud of protobuf. An empty field takes 2 bytes in the message and 16 times that in memory, so that they are counted
    /// first.
    pub(crate) fn of_protobuf(message: &[u8]) -> Result<Self, DecodeError> {
        let (mut rest, mut fields) = (message, 0);
        while !rest.is_empty() && fields <= MOST_FIELDS {
            let (tag, wire_type) = decode_key(&mut rest).map_err(not_protobuf)?;
            skip_field(wire_type, tag, &mut rest, DecodeContext::default()).map_err(not_protobuf)?;
            fields += usize::from(tag == FIELDS_TAG);
        }
        if fields > MOST_FIELDS {
            let cause = format!("there are more than {MOST_FIELDS}");
            return Err(DecodeError::Value { field: "fields", cause });
        }
        of_protobuf(message)
    }

    /// Writes the points into `out`, whatever it held before, moved by the cloud's pose.
    pub(crate) fn write_cloud(&self, out: &mut Cloud) -> Result<(), DecodeError> {
        write_header(self.timestamp, &self.frame_id, &mut out.header);
        let packed = |field: &PackedElementField| PackedField {
            name: String::from_utf8_lossy(&field.name).into_owned(),
            offset: field.offset,
            number: field.number(),
        };
        let fields: Vec<_> = self.fields.iter().map(packed).collect();
        // Points of no bytes are refused below, as there is no room for x.
        let columns = self.data.len() / self.point_stride.max(1) as usize;
        let points = PackedPoints {
            rows: 1,
            columns: u32::try_from(columns).unwrap_or(u32::MAX),
            point_bytes: self.point_stride,
            row_bytes: 0,
            is_big_endian: false,
            fields: &fields,
            data: &self.data,
        };
        points.write(out)?;
        let pose = self.pose.unwrap_or_default();
        let FoxgloveVector { x, y, z } = pose.position.unwrap_or_default();
        let rotation = pose.rotation();
        if (rotation, [x, y, z]) != (Quaternion::default(), [0.0; 3]) {
            for point_m in &mut out.points_m {
                let turned = rotation.turn(Vector3 { x: point_m[0], y: point_m[1], z: point_m[2] });
                *point_m = [turned.x + x, turned.y + y, turned.z + z];
            }
        }
        Ok(())
    }
}

impl FoxglovePose {
    /// A quaternion that is left out, or all zeros, is no rotation.
    fn rotation(self) -> Quaternion {
        match self.orientation {
            Some(FoxgloveQuaternion { x, y, z, w }) if [x, y, z, w] != [0.0; 4] => Quaternion { x, y, z, w },
            _ => Quaternion::default(),
        }
    }
}

impl PackedElementField {
    fn number(&self) -> Option<NumberType> {
        Some(match self.r#type {
            1 => NumberType::U8,
            2 => NumberType::I8,
            3 => NumberType::U16,
            4 => NumberType::I16,
            5 => NumberType::U32,
            6 => NumberType::I32,
            7 => NumberType::F32,
            8 => NumberType::F64,
            _ => return None,
        })
    }
}

type Head = (Option<Timestamp>, Vec<u8>, Option<FoxglovePose>);

/// The fields that both messages begin with.
fn read_header(from: &mut Fields<'_>) -> Result<Head, DecodeError> {
    let mut stamp = Time::default();
    stamp.read(from)?;
    let timestamp = Timestamp { sec: i64::from(stamp.sec), nsec: i32::try_from(stamp.nanosec).unwrap_or(0) };
    let mut frame_id = String::new();
    from.text("frame_id", &mut frame_id)?;
    let mut number = || from.f64("pose");
    let position = FoxgloveVector { x: number()?, y: number()?, z: number()? };
    let orientation = FoxgloveQuaternion { x: number()?, y: number()?, z: number()?, w: number()? };
    let pose = FoxglovePose { position: Some(position), orientation: Some(orientation) };
    Ok((Some(timestamp), frame_id.into_bytes(), Some(pose)))
}

fn write_header(timestamp: Option<Timestamp>, frame_id: &[u8], out: &mut Header) {
    let Timestamp { sec, nsec } = timestamp.unwrap_or_default();
    let sec = sec.clamp(i64::from(i32::MIN), i64::from(i32::MAX)) as i32;
    out.stamp = Time { sec, nanosec: u32::try_from(nsec).unwrap_or(0) };
    out.frame_id.clear();
    out.frame_id.push_str(&String::from_utf8_lossy(frame_id));
}

fn text_bytes<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<u8>, D::Error> {
    Ok(String::deserialize(from)?.into_bytes())
}

fn base64_bytes<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<u8>, D::Error> {
    STANDARD.decode(String::deserialize(from)?).map_err(D::Error::custom)
}

/// JSON has no NaN and no infinity; writers give null, or their name.
struct JsonNumber(f64);

impl<'de> Deserialize<'de> for JsonNumber {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        struct Number;
        impl Visitor<'_> for Number {
            type Value = JsonNumber;

            fn expecting(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
                to.write_str("a number, its name or null")
            }

            fn visit_f64<E>(self, number: f64) -> Result<JsonNumber, E> {
                Ok(JsonNumber(number))
            }

            fn visit_i64<E>(self, number: i64) -> Result<JsonNumber, E> {
                Ok(JsonNumber(number as f64))
            }

            fn visit_u64<E>(self, number: u64) -> Result<JsonNumber, E> {
                Ok(JsonNumber(number as f64))
            }

            fn visit_str<E>(self, name: &str) -> Result<JsonNumber, E> {
                Ok(JsonNumber(name.parse().unwrap_or(f64::NAN)))
            }

            fn visit_unit<E>(self) -> Result<JsonNumber, E> {
                Ok(JsonNumber(f64::NAN))
            }
        }
        from.deserialize_any(Number)
    }
}

fn numbers<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<f64>, D::Error> {
    let numbers: Vec<JsonNumber> = at_most(MOST_BEAMS, from)?;
    Ok(numbers.into_iter().map(|JsonNumber(number)| number).collect())
}

fn fields<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<PackedElementField>, D::Error> {
    at_most(MOST_FIELDS, from)
}

/// The elements of a list. They may take more memory than their text: a longer list is refused while it is read.
fn at_most<'de, D: Deserializer<'de>, T: Deserialize<'de>>(most: usize, from: D) -> Result<Vec<T>, D::Error> {
    struct AtMost<T>(usize, PhantomData<T>);
    impl<'de, T: Deserialize<'de>> Visitor<'de> for AtMost<T> {
        type Value = Vec<T>;

        fn expecting(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
            write!(to, "a list of {} or less", self.0)
        }

        fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Vec<T>, A::Error> {
            let mut elements = Vec::new();
            while let Some(element) = list.next_element()? {
                if elements.len() == self.0 {
                    return Err(A::Error::custom(format!("a list has more than {} elements", self.0)));
                }
                elements.push(element);
            }
            Ok(elements)
        }
    }
    from.deserialize_seq(AtMost(most, PhantomData))
}
