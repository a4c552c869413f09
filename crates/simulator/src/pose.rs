//! The pose of the lidar, and its motion during a sweep.

use crate::network::Point;

/// Position and orientation of the lidar.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Position in the plane of the mine.
    pub position_m: Point,
    /// Heading, anticlockwise from the x axis of the mine.
    pub heading_rad: f64,
    /// Roll, positive with the right side down.
    pub roll_rad: f64,
    /// Pitch, positive with the nose down.
    pub pitch_rad: f64,
}

/// The poses at the first beam of a sweep and one sweep later, with linear interpolation in between.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Pose at the first beam.
    pub start: Pose,
    /// Pose one sweep later.
    pub end: Pose,
}

impl Pose {
    /// A level pose.
    pub fn level(position_m: Point, heading_rad: f64) -> Self {
        Self { position_m, heading_rad, roll_rad: 0.0, pitch_rad: 0.0 }
    }
}

impl Motion {
    /// The motion of a lidar at rest.
    pub fn still(pose: Pose) -> Self {
        Self { start: pose, end: pose }
    }

    /// The pose at a fraction of the sweep.
    pub fn at(&self, fraction: f64) -> Pose {
        let mix = |from: f64, to: f64| from + (to - from) * fraction;
        Pose {
            position_m: self.start.position_m + (self.end.position_m - self.start.position_m) * fraction,
            heading_rad: mix(self.start.heading_rad, self.end.heading_rad),
            roll_rad: mix(self.start.roll_rad, self.end.roll_rad),
            pitch_rad: mix(self.start.pitch_rad, self.end.pitch_rad),
        }
    }
}
