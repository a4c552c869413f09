//! Poses in messages of a robot.

use crosscut_messages::{Message, Odometry, Quaternion, TfMessage, Vector3, plain_type_name};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::error::Class;

/// Stamp in nanoseconds, parent and child frame, x and y in metres, yaw in radians.
type Pose = (u64, String, String, f64, f64, f64);

/// The poses in a message of ROS 2 (CDR): of `nav_msgs/msg/Odometry` one, of `tf2_msgs/msg/TFMessage` one a transform.
#[pyfunction]
pub(crate) fn poses_of_message(py: Python<'_>, message: &[u8], message_type: &str) -> PyResult<Vec<Pose>> {
    let pose = |stamp: crosscut_messages::Time, frames: [String; 2], at: Vector3, turned: &Quaternion| {
        let [parent, child] = frames;
        (stamp.to_ns().unwrap_or(0), parent, child, at.x, at.y, turned.yaw_rad())
    };
    let type_name = plain_type_name(message_type);
    if type_name == plain_type_name(Odometry::SCHEMA_NAME) {
        let odometry = Odometry::decode(message).map_err(|error| Class::Read.because(py, &error))?;
        let of_vehicle = odometry.pose.pose;
        let frames = [odometry.header.frame_id, odometry.child_frame_id];
        Ok(vec![pose(odometry.header.stamp, frames, of_vehicle.position, &of_vehicle.orientation)])
    } else if type_name == plain_type_name(TfMessage::SCHEMA_NAME) {
        let transforms = TfMessage::decode(message).map_err(|error| Class::Read.because(py, &error))?.transforms;
        let of_transform = |of: crosscut_messages::TransformStamped| {
            let frames = [of.header.frame_id, of.child_frame_id];
            pose(of.header.stamp, frames, of.transform.translation, &of.transform.rotation)
        };
        Ok(transforms.into_iter().map(of_transform).collect())
    } else {
        Err(PyValueError::new_err(format!(
            "{message_type} has no poses: nav_msgs/msg/Odometry and tf2_msgs/msg/TFMessage do"
        )))
    }
}
