//! How frames lie to each other.

use byteorder::ByteOrder;
use serde::{Deserialize, Serialize};

use crate::{DecodeError, Header, Message, Quaternion, Reader, Vector3, schema};

/// `tf2_msgs/msg/TFMessage`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TfMessage {
    /// The transforms.
    pub transforms: Vec<TransformStamped>,
}

/// `geometry_msgs/msg/TransformStamped`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TransformStamped {
    /// Stamp, and the parent frame.
    pub header: Header,
    /// The child frame.
    pub child_frame_id: String,
    /// The child frame's pose in the parent frame.
    pub transform: Transform,
}

impl TransformStamped {
    /// A stamp (8), two text lengths (4 each) and seven f64 are there even when both texts are empty.
    const LEAST_BYTES: usize = 8 + 2 * 4 + 7 * 8;
}

/// `geometry_msgs/msg/Transform`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Transform {
    /// Metres.
    pub translation: Vector3,
    /// Unit quaternion.
    pub rotation: Quaternion,
}

impl Message for TfMessage {
    const SCHEMA_NAME: &'static str = "tf2_msgs/msg/TFMessage";
    const SCHEMA_TEXT: &'static str = schema::TF_MESSAGE;

    fn read<B: ByteOrder>(&mut self, from: &mut Reader<'_, B>) -> Result<(), DecodeError> {
        from.sequence("transforms", TransformStamped::LEAST_BYTES, &mut self.transforms)
    }
}
