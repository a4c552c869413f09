//! Where the vehicle believes to be, and how it moves.

use serde::Serialize;

use crate::{DecodeError, Fields, Header, Message, Quaternion, Vector3, schema};

/// `nav_msgs/msg/Odometry`.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
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
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct PoseWithCovariance {
    /// The pose.
    pub pose: Pose,
    /// Covariance of x, y, z, and the rotations about them, row by row.
    pub covariance: [[f64; 6]; 6],
}

/// `geometry_msgs/msg/Pose`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Pose {
    /// Metres.
    pub position: Vector3,
    /// Unit quaternion.
    pub orientation: Quaternion,
}

/// `geometry_msgs/msg/TwistWithCovariance`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct TwistWithCovariance {
    /// The twist.
    pub twist: Twist,
    /// Covariance of the linear, then the angular velocity, row by row.
    pub covariance: [[f64; 6]; 6],
}

/// `geometry_msgs/msg/Twist`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Twist {
    /// Metres per second.
    pub linear: Vector3,
    /// Radians per second.
    pub angular: Vector3,
}

impl Message for Odometry {
    const SCHEMA_NAME: &'static str = "nav_msgs/msg/Odometry";
    const SCHEMA_TEXT: &'static str = schema::ODOMETRY;

    fn is_sound(&self) -> bool {
        self.pose.pose.orientation.is_unit()
    }

    fn read(&mut self, from: &mut Fields<'_>) -> Result<(), DecodeError> {
        self.header.read(from)?;
        from.text("child_frame_id", &mut self.child_frame_id)?;
        self.pose.pose.position.read(from, "pose.position")?;
        self.pose.pose.orientation.read(from, "pose.orientation")?;
        read_covariance(&mut self.pose.covariance, from, "pose.covariance")?;
        self.twist.twist.linear.read(from, "twist.linear")?;
        self.twist.twist.angular.read(from, "twist.angular")?;
        read_covariance(&mut self.twist.covariance, from, "twist.covariance")
    }
}

fn read_covariance(
    covariance: &mut [[f64; 6]; 6],
    from: &mut Fields<'_>,
    field: &'static str,
) -> Result<(), DecodeError> {
    covariance.as_flattened_mut().iter_mut().try_for_each(|entry| {
        *entry = from.f64(field)?;
        Ok(())
    })
}
