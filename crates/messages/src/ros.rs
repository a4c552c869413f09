//! Messages of ROS that are no scans, in CDR as of ROS 2 or in the encoding of ROS 1.

use crate::{CDR_ENCODING, DecodeError, Fields, Message, Odometry, ROS1_ENCODING, TfMessage, plain_type_name};

/// The type of transforms before tf2.
const OLD_TF_TYPE: &str = "tf/tfMessage";

/// Whether this type in this encoding is odometry that can be read.
pub fn is_odometry(type_name: &str, encoding: &str) -> bool {
    is_ros(encoding) && plain_type_name(type_name) == plain_type_name(Odometry::SCHEMA_NAME)
}

/// Whether this type in this encoding is transforms that can be read.
pub fn is_transforms(type_name: &str, encoding: &str) -> bool {
    let type_name = plain_type_name(type_name);
    is_ros(encoding) && (type_name == OLD_TF_TYPE || type_name == plain_type_name(TfMessage::SCHEMA_NAME))
}

fn is_ros(encoding: &str) -> bool {
    [CDR_ENCODING, ROS1_ENCODING].contains(&encoding)
}

/// Reads a message in the encoding of ROS 1, or in CDR. One in CDR that is not sound is tried with the alignment of
/// writers that count it from the start of the message: a quaternion of length 1 tells which it is.
///
/// # Errors
/// When the bytes are no such message.
pub fn decode<M: Message>(encoding: &str, data: &[u8]) -> Result<M, DecodeError> {
    let mut message = M::default();
    match encoding {
        ROS1_ENCODING => message.decode_ros1_into(data)?,
        _ => {
            let usual = message.decode_into(data);
            if usual.is_err() || !message.is_sound() {
                let mut other = M::default();
                if other.read(&mut Fields::cdr_from_start(data)?).is_ok() && other.is_sound() {
                    return Ok(other);
                }
            }
            usual?;
        }
    }
    Ok(message)
}

/// The name of a frame without the slash that ROS 1 has in front.
pub fn plain_frame(frame: &str) -> &str {
    frame.trim_start_matches('/')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn odometry_and_transforms_are_known_by_every_spelling() {
        for name in ["nav_msgs/msg/Odometry", "nav_msgs/Odometry", "nav_msgs::msg::dds_::Odometry_"] {
            assert!(is_odometry(name, "cdr") && is_odometry(name, "ros1"), "{name}");
        }
        for name in ["tf2_msgs/msg/TFMessage", "tf2_msgs::msg::dds_::TFMessage_", "tf/tfMessage"] {
            assert!(is_transforms(name, "cdr") && !is_odometry(name, "cdr"), "{name}");
        }
        assert!(!is_odometry("nav_msgs/Odometry", "json") && !is_transforms("sensor_msgs/LaserScan", "ros1"));
    }
}
