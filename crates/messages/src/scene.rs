//! Lines, arrows and texts for a viewer, and how they become `foxglove.SceneUpdate` in protobuf. Fields that are not used
//! are left out of the definition, as protobuf allows.

use prost::Message as _;
use prost_types::field_descriptor_proto::{Label, Type};
use prost_types::{
    DescriptorProto, EnumDescriptorProto, EnumValueDescriptorProto, FieldDescriptorProto, FileDescriptorProto,
    FileDescriptorSet,
};

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
    pub fn schema() -> Vec<u8> {
        let timestamp = FileDescriptorProto {
            name: Some("google/protobuf/timestamp.proto".to_owned()),
            package: Some("google.protobuf".to_owned()),
            message_type: vec![message("Timestamp", &[("seconds", 1, Kind::I64), ("nanos", 2, Kind::I32)])],
            syntax: Some("proto3".to_owned()),
            ..FileDescriptorProto::default()
        };
        let mut messages: Vec<DescriptorProto> = MESSAGES.iter().map(|(name, fields)| message(name, fields)).collect();
        let value = |(number, name): (i32, &str)| EnumValueDescriptorProto {
            name: Some(name.to_owned()),
            number: Some(number),
            options: None,
        };
        let line = messages.iter_mut().find(|message| message.name.as_deref() == Some("LinePrimitive"));
        line.expect("it is one of them").enum_type = vec![EnumDescriptorProto {
            name: Some("Type".to_owned()),
            value: (0..).zip(["LINE_STRIP", "LINE_LOOP", "LINE_LIST"]).map(value).collect(),
            ..EnumDescriptorProto::default()
        }];
        let scene = FileDescriptorProto {
            name: Some("foxglove/SceneUpdate.proto".to_owned()),
            package: Some("foxglove".to_owned()),
            dependency: vec!["google/protobuf/timestamp.proto".to_owned()],
            message_type: messages,
            syntax: Some("proto3".to_owned()),
            ..FileDescriptorProto::default()
        };
        FileDescriptorSet { file: vec![timestamp, scene] }.encode_to_vec()
    }
}

/// The type of a field.
#[derive(Clone, Copy)]
enum Kind {
    I32,
    I64,
    F64,
    Flag,
    Text,
    Enum(&'static str),
    One(&'static str),
    Many(&'static str),
}

type Fields = &'static [(&'static str, i32, Kind)];

/// The messages with the fields that are used; names and numbers are those of Foxglove.
const MESSAGES: [(&str, Fields); 10] = [
    ("SceneUpdate", &[("entities", 2, Kind::Many(".foxglove.SceneEntity"))]),
    (
        "SceneEntity",
        &[
            ("timestamp", 1, Kind::One(".google.protobuf.Timestamp")),
            ("frame_id", 2, Kind::Text),
            ("id", 3, Kind::Text),
            ("arrows", 7, Kind::Many(".foxglove.ArrowPrimitive")),
            ("lines", 11, Kind::Many(".foxglove.LinePrimitive")),
            ("texts", 13, Kind::Many(".foxglove.TextPrimitive")),
        ],
    ),
    (
        "ArrowPrimitive",
        &[
            ("pose", 1, Kind::One(".foxglove.Pose")),
            ("shaft_length", 2, Kind::F64),
            ("shaft_diameter", 3, Kind::F64),
            ("head_length", 4, Kind::F64),
            ("head_diameter", 5, Kind::F64),
            ("color", 6, Kind::One(".foxglove.Color")),
        ],
    ),
    (
        "LinePrimitive",
        &[
            ("type", 1, Kind::Enum(".foxglove.LinePrimitive.Type")),
            ("pose", 2, Kind::One(".foxglove.Pose")),
            ("thickness", 3, Kind::F64),
            ("scale_invariant", 4, Kind::Flag),
            ("points", 5, Kind::Many(".foxglove.Point3")),
            ("color", 6, Kind::One(".foxglove.Color")),
        ],
    ),
    (
        "TextPrimitive",
        &[
            ("pose", 1, Kind::One(".foxglove.Pose")),
            ("billboard", 2, Kind::Flag),
            ("font_size", 3, Kind::F64),
            ("scale_invariant", 4, Kind::Flag),
            ("color", 5, Kind::One(".foxglove.Color")),
            ("text", 6, Kind::Text),
        ],
    ),
    ("Pose", &[("position", 1, Kind::One(".foxglove.Vector3")), ("orientation", 2, Kind::One(".foxglove.Quaternion"))]),
    ("Vector3", XYZ),
    ("Point3", XYZ),
    ("Quaternion", &[("x", 1, Kind::F64), ("y", 2, Kind::F64), ("z", 3, Kind::F64), ("w", 4, Kind::F64)]),
    ("Color", &[("r", 1, Kind::F64), ("g", 2, Kind::F64), ("b", 3, Kind::F64), ("a", 4, Kind::F64)]),
];

const XYZ: Fields = &[("x", 1, Kind::F64), ("y", 2, Kind::F64), ("z", 3, Kind::F64)];

fn message(name: &str, fields: &[(&str, i32, Kind)]) -> DescriptorProto {
    let field = |&(name, number, kind): &(&str, i32, Kind)| {
        let (field_type, type_name) = match kind {
            Kind::I32 => (Type::Int32, None),
            Kind::I64 => (Type::Int64, None),
            Kind::F64 => (Type::Double, None),
            Kind::Flag => (Type::Bool, None),
            Kind::Text => (Type::String, None),
            Kind::Enum(name) => (Type::Enum, Some(name)),
            Kind::One(name) | Kind::Many(name) => (Type::Message, Some(name)),
        };
        let label = if matches!(kind, Kind::Many(_)) { Label::Repeated } else { Label::Optional };
        FieldDescriptorProto {
            name: Some(name.to_owned()),
            number: Some(number),
            label: Some(label.into()),
            r#type: Some(field_type.into()),
            type_name: type_name.map(str::to_owned),
            ..FieldDescriptorProto::default()
        }
    };
    DescriptorProto {
        name: Some(name.to_owned()),
        field: fields.iter().map(field).collect(),
        ..DescriptorProto::default()
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
