//! The small types that messages are made of.

use serde::{Deserialize, Serialize};

const NS_PER_S: u64 = 1_000_000_000;

/// `builtin_interfaces/msg/Time`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Time {
    /// Seconds since the epoch.
    pub sec: i32,
    /// Nanoseconds after `sec`.
    pub nanosec: u32,
}

impl Time {
    /// From nanoseconds since the epoch; `sec` stays at its largest value, in 2038, for anything later.
    pub fn from_ns(ns: u64) -> Self {
        Self { sec: i32::try_from(ns / NS_PER_S).unwrap_or(i32::MAX), nanosec: (ns % NS_PER_S) as u32 }
    }

    /// Nanoseconds since the epoch; `None` for a time before it.
    pub fn to_ns(self) -> Option<u64> {
        Some(u64::try_from(self.sec).ok()? * NS_PER_S + u64::from(self.nanosec))
    }
}

/// `std_msgs/msg/Header`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Header {
    /// When it was measured.
    pub stamp: Time,
    /// The frame that the data is in.
    pub frame_id: String,
}

/// `geometry_msgs/msg/Vector3`, also `Point`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs)] // the names say it all
pub struct Vector3 {
    pub x: f64,
    pub y: f64,
    pub z: f64,
}

/// `geometry_msgs/msg/Quaternion`; the default is no rotation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
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
    fn a_yaw_of_a_quarter_turn_is_the_quaternion_of_the_textbook() {
        let q = Quaternion::from_yaw_rad(std::f64::consts::FRAC_PI_2);
        let half = std::f64::consts::FRAC_1_SQRT_2;
        assert!((q.z - half).abs() < 1e-15 && (q.w - half).abs() < 1e-15 && (q.x, q.y) == (0.0, 0.0));
    }
}
