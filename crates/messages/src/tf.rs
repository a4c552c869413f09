//! How frames lie to each other.

use serde::Serialize;

use crate::{DecodeError, Fields, Header, MOST_TRANSFORMS, Message, Quaternion, Vector3, schema};

/// `tf2_msgs/msg/TFMessage`.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct TfMessage {
    /// The transforms.
    pub transforms: Vec<TransformStamped>,
}

/// `geometry_msgs/msg/TransformStamped`.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
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

    fn read(&mut self, from: &mut Fields<'_>) -> Result<(), DecodeError> {
        self.header.read(from)?;
        from.text("child_frame_id", &mut self.child_frame_id)?;
        self.transform.translation.read(from, "transform.translation")?;
        self.transform.rotation.read(from, "transform.rotation")
    }
}

/// `geometry_msgs/msg/Transform`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Transform {
    /// Metres.
    pub translation: Vector3,
    /// Unit quaternion.
    pub rotation: Quaternion,
}

impl Message for TfMessage {
    const SCHEMA_NAME: &'static str = "tf2_msgs/msg/TFMessage";
    const SCHEMA_TEXT: &'static str = schema::TF_MESSAGE;

    fn is_sound(&self) -> bool {
        self.transforms.iter().all(|one| one.transform.rotation.is_unit())
    }

    fn read(&mut self, from: &mut Fields<'_>) -> Result<(), DecodeError> {
        let read = |from: &mut Fields<'_>, transform: &mut TransformStamped| transform.read(from);
        from.structures("transforms", TransformStamped::LEAST_BYTES, MOST_TRANSFORMS, &mut self.transforms, read)
    }
}
