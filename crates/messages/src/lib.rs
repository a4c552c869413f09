//! ROS messages and truth as Rust values, to and from CDR and JSON.
//!
//! In: the bytes of one message, as a recording holds them. Out: a value ([`LaserScan`], [`Odometry`], [`TfMessage`],
//! [`Truth`]), or a [`DecodeError`] / [`TruthError`] that says which field is wrong and why. And back again. No I/O.
//!
//! Fields carry the names of their ROS definition, so that anybody who knows the message knows the type; units are in
//! their documentation. CDR is read and written as ROS 2 does: a 4-byte encapsulation header, then every value aligned
//! to its own size, counted from the end of that header. Little and big endian are read; PL_CDR and XCDR2 are refused
//! by name. A length field is believed only as far as there are bytes for it: nothing is allocated on its word alone.
//! Bytes after the last field (writers pad to 4) are ignored. Scans are read in the encoding of ROS 1 as well
//! ([`LaserScan::decode_ros1_into`]), as recordings have them that were converted from ROS 1 bags; they are not written.
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
//! To add a message: declare its fields in ROS order with serde's derives, add its definition to [`schema`], implement
//! [`Message::read`], and add it to the round trips in `tests/`.

mod cdr;
mod laser_scan;
mod odometry;
mod ros1;
pub mod schema;
mod standard;
mod tf;
mod truth;

pub use cdr::{DecodeError, Endian, Message, Reader};
pub use laser_scan::LaserScan;
pub use odometry::{Odometry, Pose, PoseWithCovariance, Twist, TwistWithCovariance};
pub use schema::SCHEMA_ENCODING;
pub use standard::{Header, Quaternion, Time, Vector3};
pub use tf::{TfMessage, Transform, TransformStamped};
pub use truth::{TRUTH_SCHEMA_NAME, TRUTH_SCHEMA_TEXT, Truth, TruthError, TruthOpening};

/// Message encoding of ROS 2 messages in an MCAP channel.
pub const CDR_ENCODING: &str = "cdr";
/// Message encoding of ROS 1 messages in an MCAP channel.
pub const ROS1_ENCODING: &str = "ros1";
/// Message encoding of truth in an MCAP channel.
pub const JSON_ENCODING: &str = "json";
/// Schema encoding of truth in an MCAP channel.
pub const JSON_SCHEMA_ENCODING: &str = "jsonschema";
/// Where scans are written; recordings may name their scan topic otherwise.
pub const SCAN_TOPIC: &str = "/scan";
/// Where odometry is written.
pub const ODOMETRY_TOPIC: &str = "/odom";
/// Where transforms are written.
pub const TF_TOPIC: &str = "/tf";
/// Where truth is written, at the log time of the scan that it belongs to.
pub const TRUTH_TOPIC: &str = "/truth";
