//! The small types that messages are made of.

use serde::Serialize;

use crate::{DecodeError, Fields};

/// Nanoseconds in a second.
pub const NS_PER_S: f64 = 1e9;
const WHOLE_NS: u64 = NS_PER_S as u64;

/// `builtin_interfaces/msg/Time`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Time {
    /// Seconds since the epoch.
    pub sec: i32,
    /// Nanoseconds after `sec`.
    pub nanosec: u32,
}

impl Time {
    /// From nanoseconds since the epoch; `sec` stays at its largest value, in 2038, for anything later.
    pub fn from_ns(ns: u64) -> Self {
        Self { sec: i32::try_from(ns / WHOLE_NS).unwrap_or(i32::MAX), nanosec: (ns % WHOLE_NS) as u32 }
    }

    pub(crate) fn read(&mut self, from: &mut Fields<'_>) -> Result<(), DecodeError> {
        self.sec = if from.is_ros1() {
            i32::try_from(from.u32("stamp.sec")?).unwrap_or(i32::MAX)
        } else {
            from.i32("stamp.sec")?
        };
        self.nanosec = from.u32("stamp.nanosec")?;
        Ok(())
    }

    /// Nanoseconds since the epoch; `None` for a time before it.
    pub fn to_ns(self) -> Option<u64> {
        Some(u64::try_from(self.sec).ok()? * WHOLE_NS + u64::from(self.nanosec))
    }
}

/// `std_msgs/msg/Header`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Header {
    /// When it was measured.
    pub stamp: Time,
    /// The frame that the data is in.
    pub frame_id: String,
}

impl Header {
    pub(crate) fn read(&mut self, from: &mut Fields<'_>) -> Result<(), DecodeError> {
        if from.is_ros1() {
            from.u32("header.seq")?;
        }
        self.stamp.read(from)?;
        from.text("header.frame_id", &mut self.frame_id)
    }
}

/// `geometry_msgs/msg/Vector3`, also `Point`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[allow(missing_docs)] // the names say it all
pub struct Vector3 {
    pub x: f64,
    pub y: f64,
    pub z: f64,
}

impl Vector3 {
    pub(crate) fn read(&mut self, from: &mut Fields<'_>, field: &'static str) -> Result<(), DecodeError> {
        [self.x, self.y, self.z] = [from.f64(field)?, from.f64(field)?, from.f64(field)?];
        Ok(())
    }
}

/// `geometry_msgs/msg/Quaternion`; the default is no rotation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[allow(missing_docs)] // the names say it all
pub struct Quaternion {
    pub x: f64,
    pub y: f64,
    pub z: f64,
    pub w: f64,
}

impl Default for Quaternion {
    fn default() -> Self {
        Self { x: 0.0, y: 0.0, z: 0.0, w: 1.0 }
    }
}

impl Quaternion {
    /// A turn about z, anticlockwise.
    pub fn from_yaw_rad(yaw_rad: f64) -> Self {
        let (z, w) = (yaw_rad / 2.0).sin_cos();
        Self { x: 0.0, y: 0.0, z, w }
    }

    /// Its length.
    pub fn length(&self) -> f64 {
        let Self { x, y, z, w } = *self;
        (x * x + y * y + z * z + w * w).sqrt()
    }

    /// Whether its length is 1, as that of a rotation.
    pub(crate) fn is_unit(&self) -> bool {
        const ROUNDING: f64 = 0.01;
        (self.length() - 1.0).abs() <= ROUNDING
    }

    /// The turn about z: the direction of the turned x axis in the x-y plane.
    pub fn yaw_rad(&self) -> f64 {
        let Self { x, y, z, w } = *self;
        (2.0 * (w * z + x * y)).atan2(w * w + x * x - y * y - z * z)
    }

    /// `vector` turned by this quaternion, of whatever length it is but 0.
    pub fn turn(&self, vector: Vector3) -> Vector3 {
        let Self { x, y, z, w } = *self;
        let s = 2.0 / (x * x + y * y + z * z + w * w);
        let Vector3 { x: a, y: b, z: c } = vector;
        Vector3 {
            x: a * (1.0 - s * (y * y + z * z)) + b * s * (x * y - w * z) + c * s * (x * z + w * y),
            y: a * s * (x * y + w * z) + b * (1.0 - s * (x * x + z * z)) + c * s * (y * z - w * x),
            z: a * s * (x * z - w * y) + b * s * (y * z + w * x) + c * (1.0 - s * (x * x + y * y)),
        }
    }

    pub(crate) fn read(&mut self, from: &mut Fields<'_>, field: &'static str) -> Result<(), DecodeError> {
        [self.x, self.y, self.z, self.w] = [from.f64(field)?, from.f64(field)?, from.f64(field)?, from.f64(field)?];
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_survives_the_way_to_nanoseconds_and_back() {
        let ns = 1_577_836_800_700_000_001;
        assert_eq!(Time::from_ns(ns), Time { sec: 1_577_836_800, nanosec: 700_000_001 });
        assert_eq!(Time::from_ns(ns).to_ns(), Some(ns));
    }

    #[test]
    fn times_outside_the_range_of_the_message_do_not_wrap_around() {
        assert_eq!(Time { sec: -1, nanosec: 5 }.to_ns(), None);
        assert_eq!(Time::from_ns(u64::MAX).sec, i32::MAX);
    }

    #[test]
    fn a_quarter_turn_about_each_axis_moves_the_next_axis_to_the_one_after() {
        let [x, y, z] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        for (axis, from, to) in [(x, y, z), (y, z, x), (z, x, y)] {
            let turned = Quaternion { x: axis[0], y: axis[1], z: axis[2], w: 1.0 }.turn(Vector3 {
                x: from[0],
                y: from[1],
                z: from[2],
            });
            assert_eq!([turned.x, turned.y, turned.z], to);
        }
    }

    #[test]
    fn a_yaw_of_a_quarter_turn_is_the_quaternion_of_the_textbook() {
        let q = Quaternion::from_yaw_rad(std::f64::consts::FRAC_PI_2);
        let half = std::f64::consts::FRAC_1_SQRT_2;
        assert!((q.z - half).abs() < 1e-15 && (q.w - half).abs() < 1e-15 && (q.x, q.y) == (0.0, 0.0));
        assert!((q.yaw_rad() - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
    }
}
