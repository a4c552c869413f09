//! ROS and Foxglove messages, and truth, as Rust values.
//!
//! In: the bytes of one message, as a recording holds them. Out: a value ([`ScanMessage`], [`Odometry`], [`TfMessage`],
//! [`Truth`]), or a [`DecodeError`] / [`TruthError`] that names the wrong field and the reason. No I/O.
//!
//! | type | CDR | ROS 1 | JSON | protobuf |
//! |---|---|---|---|---|
//! | `sensor_msgs/LaserScan`, `MultiEchoLaserScan`, `PointCloud2` | read, written | read | | |
//! | `nav_msgs/Odometry`, `tf2_msgs/TFMessage` | read, written | read | | |
//! | `foxglove.LaserScan`, `foxglove.PointCloud` | read | read | read | read |
//! | [`Scene`]: `visualization_msgs/MarkerArray`, `foxglove.SceneUpdate` | written | | | written |
//! | [`Truth`] | | | read, written | |
//!
//! [`ScanDecoder`] finds the decoder for the messages of a scan topic by the names of their type and encoding. Fields
//! carry the names of their definition; units are in their documentation.
//!
//! CDR begins with an encapsulation header of 4 bytes; then every value is aligned to its own size, counted from the end
//! of that header (to 4 bytes at most in XCDR2). Both byte orders are read. XCDR2 that is not plain, and PL_CDR, are
//! refused by name. A length field is believed only as far as there are bytes for it: no memory is allocated for more.
//! A scan of more than [`MOST_BEAMS`], a cloud of more than [`MOST_POINTS`] and points of more than [`MOST_FIELDS`] are
//! refused. Bytes after the last field are ignored (writers pad to 4). Texts that are not UTF-8 have replacement characters.
//!
//! [`Message::SCHEMA_NAME`] and [`Message::SCHEMA_TEXT`] (in [`SCHEMA_ENCODING`]) are what an MCAP channel needs for
//! any ROS 2 tool to read what was written. Times are [`Time`]s as on the wire and nanoseconds elsewhere.
//!
//! ```
//! use crosscut_messages::{Endian, LaserScan, Message};
//!
//! let scan = LaserScan { angle_increment: 0.1, ranges: vec![1.0, f32::NAN, 2.5], ..LaserScan::default() };
//! let bytes = scan.encode(Endian::Little);
//! let back = LaserScan::decode(&bytes)?;
//! assert_eq!(back.ranges[2], 2.5);
//!
//! let cut = LaserScan::decode(&bytes[..bytes.len() - 6]).unwrap_err();
//! assert_eq!(cut.to_string(), "`ranges` claims 3 elements, at least 12 bytes, but 10 bytes of the message are left");
//! # Ok::<(), crosscut_messages::DecodeError>(())
//! ```
//!
//! Feature `foxglove` has Foxglove's messages and the scenes, feature `encode` the writing of CDR. Both are on by default; a
//! robot's own program builds without them, and so without 17 crates.
//!
//! To add a message: declare its fields in ROS order, derive `Serialize`, add its definition to [`schema`], implement
//! [`Message::read`], and add it to the round trips in `tests/`. If it shows a scan, add it to [`ScanType`] too.

mod cloud;
mod error;
mod fields;
#[cfg(feature = "foxglove")]
mod foxglove;
mod laser_scan;
#[cfg(feature = "foxglove")]
mod markers;
mod message;
mod multi_echo;
mod odometry;
mod point_cloud2;
pub mod ros;
mod scan_decoder;
#[cfg(feature = "foxglove")]
mod scene;
pub mod schema;
mod standard;
mod tf;
mod truth;
mod truth_map;

pub use cloud::{Cloud, NumberType};
pub use error::DecodeError;
pub use fields::{Endian, Fields};
pub use laser_scan::LaserScan;
#[cfg(feature = "foxglove")]
pub use markers::MARKERS_SCHEMA_NAME;
pub use message::Message;
pub use multi_echo::{Echo, LaserEcho, MultiEchoLaserScan};
pub use odometry::{Odometry, Pose, PoseWithCovariance, Twist, TwistWithCovariance};
pub use point_cloud2::{PointCloud2, PointField};
pub use scan_decoder::{ScanDecoder, ScanMessage, ScanType, plain_type_name};
#[cfg(feature = "foxglove")]
pub use scene::{SCENE_SCHEMA_NAME, Scene, SceneArrow, SceneLine, SceneText};
pub use schema::SCHEMA_ENCODING;
pub use standard::{Header, NS_PER_S, Quaternion, Time, Vector3};
pub use tf::{TfMessage, Transform, TransformStamped};
pub use truth::{
    TRUTH_SCHEMA_NAME, TRUTH_SCHEMA_TEXT, Truth, TruthError, TruthKind, TruthOpening, TruthPlace, TruthPose,
};
pub use truth_map::{
    TRUTH_MAP_SCHEMA_NAME, TRUTH_MAP_SCHEMA_TEXT, TruthEdge, TruthMap, TruthMapError, TruthNode, TruthWay,
};

/// A scan with more beams is refused.
pub const MOST_BEAMS: usize = 1 << 20;
/// A cloud with more points is refused.
pub const MOST_POINTS: usize = 1 << 24;
/// A cloud whose points have more fields is refused.
pub const MOST_FIELDS: usize = 1 << 12;
/// A message of more transforms is refused.
pub(crate) const MOST_TRANSFORMS: usize = 1 << 16;

/// Message encoding of ROS 2 messages in an MCAP channel.
pub const CDR_ENCODING: &str = "cdr";
/// Message encoding of ROS 1 messages in an MCAP channel.
pub const ROS1_ENCODING: &str = "ros1";
/// Message encoding of protobuf messages in an MCAP channel.
pub const PROTOBUF_ENCODING: &str = "protobuf";
/// Message encoding of truth, and of Foxglove's messages in JSON, in an MCAP channel.
pub const JSON_ENCODING: &str = "json";
/// Schema encoding of truth in an MCAP channel.
pub const JSON_SCHEMA_ENCODING: &str = "jsonschema";
/// Where scans are written; recordings may name their scan topic otherwise.
pub const SCAN_TOPIC: &str = "/scan";
/// Where clouds are written.
pub const POINTS_TOPIC: &str = "/points";
/// Where odometry is written.
pub const ODOMETRY_TOPIC: &str = "/odom";
/// Where transforms are written.
pub const TF_TOPIC: &str = "/tf";
/// Where truth is written, at the log time of the scan that it belongs to.
pub const TRUTH_TOPIC: &str = "/truth";
/// Where the map of a flight's mine is written, once.
pub const TRUTH_MAP_TOPIC: &str = "/truth/map";
