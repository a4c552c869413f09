//! A sweep of a 2D lidar.

use byteorder::ByteOrder;
use serde::{Deserialize, Serialize};

use crate::{DecodeError, Header, Message, Reader, schema};

/// `sensor_msgs/msg/LaserScan`. Beam `i` looks at `angle_min + i * angle_increment`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
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

impl Message for LaserScan {
    const SCHEMA_NAME: &'static str = "sensor_msgs/msg/LaserScan";
    const SCHEMA_TEXT: &'static str = schema::LASER_SCAN;

    fn read<B: ByteOrder>(&mut self, from: &mut Reader<'_, B>) -> Result<(), DecodeError> {
        self.header = from.value("header")?;
        self.angle_min = from.value("angle_min")?;
        self.angle_max = from.value("angle_max")?;
        self.angle_increment = from.value("angle_increment")?;
        self.time_increment = from.value("time_increment")?;
        self.scan_time = from.value("scan_time")?;
        self.range_min = from.value("range_min")?;
        self.range_max = from.value("range_max")?;
        from.sequence("ranges", size_of::<f32>(), &mut self.ranges)?;
        from.sequence("intensities", size_of::<f32>(), &mut self.intensities)
    }
}
