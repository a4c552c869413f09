//! A sweep of a 2D lidar.

use serde::Serialize;

use crate::{DecodeError, Fields, Header, Message, schema};

/// `sensor_msgs/msg/LaserScan`. Beam `i` looks at `angle_min + i * angle_increment`.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct LaserScan {
    /// Stamp of the first ray, and the sensor's frame.
    pub header: Header,
    /// Bearing of the first beam, rad, anticlockwise.
    pub angle_min: f32,
    /// Bearing of the last beam, rad.
    pub angle_max: f32,
    /// Angle from one beam to the next, rad; negative when the sensor turns clockwise.
    pub angle_increment: f32,
    /// Time from one beam to the next, s.
    pub time_increment: f32,
    /// Time from one scan to the next, s.
    pub scan_time: f32,
    /// Shortest range that can be measured, m.
    pub range_min: f32,
    /// Longest range that can be measured, m.
    pub range_max: f32,
    /// Ranges, m, one a beam.
    pub ranges: Vec<f32>,
    /// Intensities in the sensor's own unit, one a beam, or none at all.
    pub intensities: Vec<f32>,
}

impl LaserScan {
    /// Its type, as ROS 1 names it.
    pub const ROS1_SCHEMA_NAME: &'static str = "sensor_msgs/LaserScan";

    /// Reads all but the ranges and the intensities.
    pub(crate) fn read_geometry(&mut self, from: &mut Fields<'_>) -> Result<(), DecodeError> {
        self.header.read(from)?;
        self.angle_min = from.f32("angle_min")?;
        self.angle_max = from.f32("angle_max")?;
        self.angle_increment = from.f32("angle_increment")?;
        self.time_increment = from.f32("time_increment")?;
        self.scan_time = from.f32("scan_time")?;
        self.range_min = from.f32("range_min")?;
        self.range_max = from.f32("range_max")?;
        Ok(())
    }
}

impl Message for LaserScan {
    const SCHEMA_NAME: &'static str = "sensor_msgs/msg/LaserScan";
    const SCHEMA_TEXT: &'static str = schema::LASER_SCAN;

    fn read(&mut self, from: &mut Fields<'_>) -> Result<(), DecodeError> {
        self.read_geometry(from)?;
        from.f32s("ranges", &mut self.ranges)?;
        from.f32s("intensities", &mut self.intensities)
    }
}
