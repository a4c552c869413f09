//! Lines, arrows and texts for a viewer, and how they become `foxglove.SceneUpdate` in protobuf. Fields that are not used
//! are left out of the definition, as protobuf allows.

use prost::Message as _;

use crate::foxglove::{FoxglovePose, FoxgloveQuaternion, FoxgloveVector, Timestamp};

/// The type of [`Scene::encode`].
pub const SCENE_SCHEMA_NAME: &str = "foxglove.SceneUpdate";

/// What is drawn at one time; it replaces what was drawn before.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scene {
    /// Nanoseconds since the epoch.
    pub stamp_ns: u64,
    /// The frame of all places.
    pub frame_id: String,
    /// Lines from place to place.
    pub lines: Vec<SceneLine>,
    /// Arrows.
    pub arrows: Vec<SceneArrow>,
    /// Texts.
    pub texts: Vec<SceneText>,
}

/// A line from place to place.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SceneLine {
    /// Its corners, m.
    pub points_m: Vec<[f64; 3]>,
    /// Red, green, blue, each 0 to 1.
    pub colour: [f64; 3],
}

/// An arrow in the plane.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SceneArrow {
    /// Where it begins, m.
    pub from_m: [f64; 3],
    /// Its direction, anticlockwise from x.
    pub bearing_rad: f64,
    /// Its length, m.
    pub length_m: f64,
    /// Red, green, blue, each 0 to 1.
    pub colour: [f64; 3],
}

/// A text that faces the viewer.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SceneText {
    /// Where it is, m.
    pub at_m: [f64; 3],
    /// Its words.
    pub text: String,
}

impl Scene {
    /// The scene as a message in protobuf.
    pub fn encode(&self) -> Vec<u8> {
        let entity = SceneEntity {
            timestamp: Some(Timestamp {
                sec: (self.stamp_ns / 1_000_000_000) as i64,
                nsec: (self.stamp_ns % 1_000_000_000) as i32,
            }),
            frame_id: self.frame_id.clone(),
            // An entity replaces the one that had its id before.
            id: "crosscut".to_owned(),
            lines: self.lines.iter().map(Into::into).collect(),
            arrows: self.arrows.iter().map(Into::into).collect(),
            texts: self.texts.iter().map(Into::into).collect(),
        };
        SceneUpdate { entities: vec![entity] }.encode_to_vec()
    }

    /// The definition of the message and of all that it depends on, as a `FileDescriptorSet` in protobuf.
    pub fn schema() -> &'static [u8] {
        include_bytes!("scene_update.binpb")
    }
}

#[derive(Clone, PartialEq, prost::Message)]
struct SceneUpdate {
    #[prost(message, repeated, tag = "2")]
    entities: Vec<SceneEntity>,
}

#[derive(Clone, PartialEq, prost::Message)]
struct SceneEntity {
    #[prost(message, optional, tag = "1")]
    timestamp: Option<Timestamp>,
    #[prost(string, tag = "2")]
    frame_id: String,
    #[prost(string, tag = "3")]
    id: String,
    #[prost(message, repeated, tag = "7")]
    arrows: Vec<ArrowPrimitive>,
    #[prost(message, repeated, tag = "11")]
    lines: Vec<LinePrimitive>,
    #[prost(message, repeated, tag = "13")]
    texts: Vec<TextPrimitive>,
}

#[derive(Clone, PartialEq, prost::Message)]
struct ArrowPrimitive {
    #[prost(message, optional, tag = "1")]
    pose: Option<FoxglovePose>,
    #[prost(double, tag = "2")]
    shaft_length: f64,
    #[prost(double, tag = "3")]
    shaft_diameter: f64,
    #[prost(double, tag = "4")]
    head_length: f64,
    #[prost(double, tag = "5")]
    head_diameter: f64,
    #[prost(message, optional, tag = "6")]
    color: Option<Color>,
}

/// A `LINE_STRIP`.
#[derive(Clone, PartialEq, prost::Message)]
struct LinePrimitive {
    #[prost(message, optional, tag = "2")]
    pose: Option<FoxglovePose>,
    #[prost(double, tag = "3")]
    thickness: f64,
    #[prost(bool, tag = "4")]
    scale_invariant: bool,
    #[prost(message, repeated, tag = "5")]
    points: Vec<FoxgloveVector>,
    #[prost(message, optional, tag = "6")]
    color: Option<Color>,
}

#[derive(Clone, PartialEq, prost::Message)]
struct TextPrimitive {
    #[prost(message, optional, tag = "1")]
    pose: Option<FoxglovePose>,
    #[prost(bool, tag = "2")]
    billboard: bool,
    #[prost(double, tag = "3")]
    font_size: f64,
    #[prost(bool, tag = "4")]
    scale_invariant: bool,
    #[prost(message, optional, tag = "5")]
    color: Option<Color>,
    #[prost(string, tag = "6")]
    text: String,
}

#[derive(Clone, Copy, PartialEq, prost::Message)]
struct Color {
    #[prost(double, tag = "1")]
    r: f64,
    #[prost(double, tag = "2")]
    g: f64,
    #[prost(double, tag = "3")]
    b: f64,
    #[prost(double, tag = "4")]
    a: f64,
}

fn vector([x, y, z]: [f64; 3]) -> FoxgloveVector {
    FoxgloveVector { x, y, z }
}

fn pose(at_m: [f64; 3], bearing_rad: f64) -> Option<FoxglovePose> {
    let (z, w) = (0.5 * bearing_rad).sin_cos();
    let orientation = FoxgloveQuaternion { z, w, ..FoxgloveQuaternion::default() };
    Some(FoxglovePose { position: Some(vector(at_m)), orientation: Some(orientation) })
}

fn color([r, g, b]: [f64; 3]) -> Option<Color> {
    Some(Color { r, g, b, a: 1.0 })
}

impl From<&SceneLine> for LinePrimitive {
    fn from(line: &SceneLine) -> Self {
        let points = line.points_m.iter().map(|&point_m| vector(point_m)).collect();
        Self {
            pose: pose([0.0; 3], 0.0),
            thickness: 3.0, // pixels
            scale_invariant: true,
            points,
            color: color(line.colour),
        }
    }
}

impl From<&SceneArrow> for ArrowPrimitive {
    fn from(arrow: &SceneArrow) -> Self {
        let head_length = 0.25 * arrow.length_m;
        Self {
            pose: pose(arrow.from_m, arrow.bearing_rad),
            shaft_length: arrow.length_m - head_length,
            shaft_diameter: 0.05 * arrow.length_m,
            head_length,
            head_diameter: 0.15 * arrow.length_m,
            color: color(arrow.colour),
        }
    }
}

impl From<&SceneText> for TextPrimitive {
    fn from(text: &SceneText) -> Self {
        Self {
            pose: pose(text.at_m, 0.0),
            billboard: true,
            font_size: 14.0, // pixels
            scale_invariant: true,
            color: color([0.5; 3]),
            text: text.text.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use prost_types::FileDescriptorSet;

    use super::*;

    #[test]
    fn the_definition_has_every_field_that_a_scene_is_written_with() {
        let FileDescriptorSet { file } = FileDescriptorSet::decode(Scene::schema()).expect("descriptors");
        let [time, scene] = &file[..] else { panic!("two files: {file:?}") };
        assert_eq!([time, scene].map(prost_types::FileDescriptorProto::package), ["google.protobuf", "foxglove"]);
        assert_eq!(scene.dependency, [time.name()]);
        let numbers = |name: &str| -> Vec<i32> {
            let message = scene.message_type.iter().find(|message| message.name() == name).expect("it is defined");
            message.field.iter().map(prost_types::FieldDescriptorProto::number).collect()
        };
        // The tags of the messages of this file.
        assert_eq!(numbers("SceneUpdate"), [2]);
        assert_eq!(numbers("SceneEntity"), [1, 2, 3, 7, 11, 13]);
        assert_eq!(numbers("LinePrimitive"), [1, 2, 3, 4, 5, 6]);
        for name in ["ArrowPrimitive", "TextPrimitive"] {
            assert_eq!(numbers(name), [1, 2, 3, 4, 5, 6], "{name}");
        }
        assert_eq!((numbers("Color"), numbers("Quaternion")), (vec![1, 2, 3, 4], vec![1, 2, 3, 4]));
    }
}
