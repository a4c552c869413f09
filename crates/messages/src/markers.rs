//! `visualization_msgs/msg/MarkerArray` in CDR: a [`Scene`] for RViz, and for Foxglove beside ROS.

use serde::Serialize;

use crate::message::encode;
use crate::odometry::Pose;
use crate::{Endian, Header, Quaternion, Scene, SceneArrow, SceneLine, SceneText, Time, Vector3};

/// The type of [`Scene::markers`].
pub const MARKERS_SCHEMA_NAME: &str = "visualization_msgs/msg/MarkerArray";

/// Values of a marker's `type` and `action`.
const ARROW: i32 = 0;
const LINE_STRIP: i32 = 4;
const TEXT_VIEW_FACING: i32 = 9;
const ADD: i32 = 0;
const DELETE_ALL: i32 = 3;

/// Width of lines, m.
const LINE_M: f64 = 0.05;
/// Height of a capital letter, m.
const TEXT_M: f64 = 0.4;

impl Scene {
    /// The scene as a message of ROS 2 in CDR. It removes what an earlier one has drawn.
    pub fn markers(&self) -> Vec<u8> {
        let clear = Marker { action: DELETE_ALL, ..Marker::default() };
        let lines = self.lines.iter().map(Marker::from);
        let arrows = self.arrows.iter().map(Marker::from);
        let texts = self.texts.iter().map(Marker::from);
        let mut markers: Vec<Marker> = [clear].into_iter().chain(lines).chain(arrows).chain(texts).collect();
        for (id, marker) in (0..).zip(&mut markers) {
            marker.header = Header { stamp: Time::from_ns(self.stamp_ns), frame_id: self.frame_id.clone() };
            marker.ns = "crosscut".to_owned();
            marker.id = id;
        }
        encode(&MarkerArray { markers }, Endian::Little)
    }
}

#[derive(Serialize)]
struct MarkerArray {
    markers: Vec<Marker>,
}

/// `visualization_msgs/msg/Marker` of ROS 2 Humble and later.
#[derive(Default, Serialize)]
struct Marker {
    header: Header,
    ns: String,
    id: i32,
    r#type: i32,
    action: i32,
    pose: Pose,
    scale: Vector3,
    color: ColorRgba,
    /// Seconds and nanoseconds; 0 is for ever.
    lifetime: (i32, u32),
    frame_locked: bool,
    points: Vec<Vector3>,
    colors: Vec<ColorRgba>,
    texture_resource: String,
    /// Header, format and bytes.
    texture: (Header, String, Vec<u8>),
    uv_coordinates: Vec<(f32, f32)>,
    text: String,
    mesh_resource: String,
    /// Name and bytes.
    mesh_file: (String, Vec<u8>),
    mesh_use_embedded_materials: bool,
}

/// `std_msgs/msg/ColorRGBA`.
#[derive(Clone, Copy, Default, Serialize)]
struct ColorRgba {
    r: f32,
    g: f32,
    b: f32,
    a: f32,
}

fn color([r, g, b]: [f64; 3]) -> ColorRgba {
    ColorRgba { r: r as f32, g: g as f32, b: b as f32, a: 1.0 }
}

fn vector([x, y, z]: [f64; 3]) -> Vector3 {
    Vector3 { x, y, z }
}

impl From<&SceneLine> for Marker {
    fn from(line: &SceneLine) -> Self {
        Self {
            r#type: LINE_STRIP,
            action: ADD,
            scale: vector([LINE_M, 0.0, 0.0]),
            color: color(line.colour),
            points: line.points_m.iter().map(|&point_m| vector(point_m)).collect(),
            ..Self::default()
        }
    }
}

impl From<&SceneArrow> for Marker {
    fn from(arrow: &SceneArrow) -> Self {
        Self {
            r#type: ARROW,
            action: ADD,
            pose: Pose { position: vector(arrow.from_m), orientation: Quaternion::from_yaw_rad(arrow.bearing_rad) },
            scale: vector([arrow.length_m, 0.05 * arrow.length_m, 0.05 * arrow.length_m]),
            color: color(arrow.colour),
            ..Self::default()
        }
    }
}

impl From<&SceneText> for Marker {
    fn from(text: &SceneText) -> Self {
        Self {
            r#type: TEXT_VIEW_FACING,
            action: ADD,
            pose: Pose { position: vector(text.at_m), ..Pose::default() },
            scale: vector([0.0, 0.0, TEXT_M]),
            color: color([0.5; 3]),
            text: text.text.clone(),
            ..Self::default()
        }
    }
}
