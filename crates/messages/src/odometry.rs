//! Where the vehicle believes to be, and how it moves.

use byteorder::ByteOrder;
use serde::{Deserialize, Serialize};

use crate::{DecodeError, Header, Message, Quaternion, Reader, Vector3, schema};

/// `nav_msgs/msg/Odometry`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Odometry {
    /// Stamp, and the frame that the pose is in.
    pub header: Header,
    /// The vehicle's own frame, which the twist is in.
    pub child_frame_id: String,
    /// Pose of the vehicle.
    pub pose: PoseWithCovariance,
    /// Velocity of the vehicle.
    pub twist: TwistWithCovariance,
}

/// `geometry_msgs/msg/PoseWithCovariance`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PoseWithCovariance {
    /// The pose.
    pub pose: Pose,
    /// Covariance of x, y, z, and the rotations about them, row by row.
    pub covariance: [[f64; 6]; 6],
}

/// `geometry_msgs/msg/Pose`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// Metres.
    pub position: Vector3,
    /// Unit quaternion.
    pub orientation: Quaternion,
}

/// `geometry_msgs/msg/TwistWithCovariance`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TwistWithCovariance {
    /// The twist.
    pub twist: Twist,
    /// Covariance of the linear, then the angular velocity, row by row.
    pub covariance: [[f64; 6]; 6],
}

/// `geometry_msgs/msg/Twist`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Twist {
    /// Metres per second.
    pub linear: Vector3,
    /// Radians per second.
    pub angular: Vector3,
}

impl Message for Odometry {
    const SCHEMA_NAME: &'static str = "nav_msgs/msg/Odometry";
    const SCHEMA_TEXT: &'static str = schema::ODOMETRY;

    fn read<B: ByteOrder>(&mut self, from: &mut Reader<'_, B>) -> Result<(), DecodeError> {
        self.header = from.value("header")?;
        self.child_frame_id = from.value("child_frame_id")?;
        self.pose = from.value("pose")?;
        self.twist = from.value("twist")?;
        Ok(())
    }
}
