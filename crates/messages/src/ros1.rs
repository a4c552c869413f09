//! Scans in the encoding of ROS 1: little endian, no header of its own, no alignment, texts without a final zero.

use std::str::from_utf8;

use crate::{DecodeError, LaserScan, Time};

const F32_BYTES: usize = size_of::<f32>();

impl LaserScan {
    /// Its type, as ROS 1 names it.
    pub const ROS1_SCHEMA_NAME: &'static str = "sensor_msgs/LaserScan";

    /// Reads a `sensor_msgs/LaserScan` of ROS 1 into `self`, keeping its buffers. Its fields are those of ROS 2, but for
    /// a number at the start of the header, which is not kept.
    ///
    /// # Errors
    /// At the first field that cannot be read; `self` is then partly overwritten.
    pub fn decode_ros1_into(&mut self, message: &[u8]) -> Result<(), DecodeError> {
        let mut from = Fields { left: message, message_bytes: message.len() };
        from.u32("header.seq")?;
        let sec = i32::try_from(from.u32("header.stamp.sec")?).unwrap_or(i32::MAX);
        self.header.stamp = Time { sec, nanosec: from.u32("header.stamp.nsec")? };
        from.text("header.frame_id", &mut self.header.frame_id)?;
        self.angle_min = from.f32("angle_min")?;
        self.angle_max = from.f32("angle_max")?;
        self.angle_increment = from.f32("angle_increment")?;
        self.time_increment = from.f32("time_increment")?;
        self.scan_time = from.f32("scan_time")?;
        self.range_min = from.f32("range_min")?;
        self.range_max = from.f32("range_max")?;
        from.f32s("ranges", &mut self.ranges)?;
        from.f32s("intensities", &mut self.intensities)
    }
}

/// The fields of a message, one after the other.
struct Fields<'a> {
    left: &'a [u8],
    message_bytes: usize,
}

impl<'a> Fields<'a> {
    fn array<const N: usize>(&mut self, field: &'static str) -> Result<[u8; N], DecodeError> {
        let ended = DecodeError::Ended { field, bytes: self.message_bytes };
        let (array, left) = self.left.split_first_chunk().ok_or(ended)?;
        self.left = left;
        Ok(*array)
    }

    fn u32(&mut self, field: &'static str) -> Result<u32, DecodeError> {
        self.array(field).map(u32::from_le_bytes)
    }

    fn f32(&mut self, field: &'static str) -> Result<f32, DecodeError> {
        self.array(field).map(f32::from_le_bytes)
    }

    /// The bytes of a sequence whose elements take `element_bytes` each.
    fn sequence(&mut self, field: &'static str, element_bytes: usize) -> Result<&'a [u8], DecodeError> {
        let claimed = self.u32(field)?;
        let needed_bytes = u64::from(claimed) * element_bytes as u64;
        let left_bytes = self.left.len() as u64;
        if needed_bytes > left_bytes {
            return Err(DecodeError::Length { field, claimed, needed_bytes, left_bytes });
        }
        let (sequence, left) = self.left.split_at(needed_bytes as usize);
        self.left = left;
        Ok(sequence)
    }

    fn text(&mut self, field: &'static str, out: &mut String) -> Result<(), DecodeError> {
        let text = from_utf8(self.sequence(field, 1)?);
        let text = text.map_err(|error| DecodeError::Value { field, cause: error.to_string() })?;
        text.clone_into(out);
        Ok(())
    }

    fn f32s(&mut self, field: &'static str, out: &mut Vec<f32>) -> Result<(), DecodeError> {
        let (values, _) = self.sequence(field, F32_BYTES)?.as_chunks();
        out.clear();
        out.extend(values.iter().copied().map(f32::from_le_bytes));
        Ok(())
    }
}
