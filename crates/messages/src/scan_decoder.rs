//! Any message that shows one turn of a lidar, or a part of one, whatever its type and encoding.

use std::fmt;

#[cfg(feature = "foxglove")]
use crate::foxglove::{FoxgloveCloud, FoxgloveScan, of_json, of_protobuf};
use crate::{
    CDR_ENCODING, Cloud, DecodeError, Echo, Fields, Header, JSON_ENCODING, LaserScan, MOST_BEAMS, Message as _,
    MultiEchoLaserScan, PROTOBUF_ENCODING, PointCloud2, ROS1_ENCODING,
};

/// What a message of a scan topic holds.
#[derive(Clone, Debug, PartialEq)]
pub enum ScanMessage {
    /// The ranges of a 2D lidar.
    Scan(LaserScan),
    /// The points of a 3D lidar.
    Cloud(Cloud),
}

/// The types of messages that can be read as scans.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)] // the names say it all
pub enum ScanType {
    LaserScan,
    MultiEchoLaserScan,
    PointCloud2,
    FoxgloveLaserScan,
    FoxglovePointCloud,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Encoding {
    Cdr,
    Ros1,
    Json,
    Protobuf,
}

/// Reads the messages of one topic.
///
/// ```
/// use crosscut_messages::{Endian, LaserScan, Message, ScanDecoder, ScanMessage};
///
/// let decoder = ScanDecoder::for_schema("sensor_msgs::msg::dds_::LaserScan_", "omgidl", "cdr").expect("a scan");
/// let bytes = LaserScan { ranges: vec![1.0, 2.5], ..LaserScan::default() }.encode(Endian::Big);
/// let mut message = ScanMessage::default();
/// decoder.decode_into(&bytes, &mut message)?;
/// let ScanMessage::Scan(scan) = message else { panic!("no scan") };
/// assert_eq!(scan.ranges, [1.0, 2.5]);
/// # Ok::<(), crosscut_messages::DecodeError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ScanDecoder {
    scan_type: ScanType,
    encoding: Encoding,
    /// Of several echoes of a beam, the one that counts.
    pub echo: Echo,
}

impl Default for ScanMessage {
    fn default() -> Self {
        Self::Scan(LaserScan::default())
    }
}

impl ScanMessage {
    /// Its stamp and frame.
    pub fn header(&self) -> &Header {
        match self {
            Self::Scan(scan) => &scan.header,
            Self::Cloud(cloud) => &cloud.header,
        }
    }

    fn as_scan_mut(&mut self) -> &mut LaserScan {
        if matches!(self, Self::Cloud(_)) {
            *self = Self::Scan(LaserScan::default());
        }
        match self {
            Self::Scan(scan) => scan,
            Self::Cloud(_) => unreachable!("it was made a scan"),
        }
    }

    fn as_cloud_mut(&mut self) -> &mut Cloud {
        if matches!(self, Self::Scan(_)) {
            *self = Self::Cloud(Cloud::default());
        }
        match self {
            Self::Cloud(cloud) => cloud,
            Self::Scan(_) => unreachable!("it was made a cloud"),
        }
    }
}

impl ScanType {
    /// All of them.
    pub const ALL: [Self; 5] = [
        Self::LaserScan,
        Self::MultiEchoLaserScan,
        Self::PointCloud2,
        Self::FoxgloveLaserScan,
        Self::FoxglovePointCloud,
    ];

    /// The type of this name, by whatever name recorders write; of our own types the last part will do.
    pub fn of_name(name: &str) -> Option<Self> {
        let name = plain_type_name(name);
        Self::ALL.into_iter().find(|scan_type| {
            let known = scan_type.name();
            let in_ros = known.replace("foxglove.", "foxglove_msgs/");
            name == known || name == in_ros || known.strip_prefix("sensor_msgs/").is_some_and(|last| last == name)
        })
    }

    /// Its name, as ROS 1 and Foxglove write it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::LaserScan => "sensor_msgs/LaserScan",
            Self::MultiEchoLaserScan => "sensor_msgs/MultiEchoLaserScan",
            Self::PointCloud2 => "sensor_msgs/PointCloud2",
            Self::FoxgloveLaserScan => "foxglove.LaserScan",
            Self::FoxglovePointCloud => "foxglove.PointCloud",
        }
    }
}

impl fmt::Display for ScanType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl Encoding {
    /// The encoding of messages; where the recording does not name it, that of its schemas says.
    fn of(message_encoding: &str, schema_encoding: &str) -> Option<Self> {
        match (message_encoding, schema_encoding) {
            (CDR_ENCODING, _) | ("", "ros2msg" | "ros2idl" | "omgidl") => Some(Self::Cdr),
            (ROS1_ENCODING, _) | ("", "ros1msg") => Some(Self::Ros1),
            (JSON_ENCODING, _) | ("", "jsonschema") => Some(Self::Json),
            (PROTOBUF_ENCODING, _) | ("", "protobuf") => Some(Self::Protobuf),
            _ => None,
        }
    }
}

impl ScanDecoder {
    /// The decoder for the messages of a channel, if they are scans that can be read.
    ///
    /// Types are known by whatever name recorders write: `sensor_msgs/msg/LaserScan`, `sensor_msgs/LaserScan`,
    /// `sensor_msgs::msg::LaserScan`, `sensor_msgs::msg::dds_::LaserScan_`.
    pub fn for_schema(schema_name: &str, schema_encoding: &str, message_encoding: &str) -> Option<Self> {
        let scan_type = ScanType::of_name(schema_name)?;
        // A name without its package says too little where nobody asked for that type.
        let is_full = schema_name.contains(['/', ':', '.']);
        Self::new(scan_type, Encoding::of(message_encoding, schema_encoding)?).filter(|_| is_full)
    }

    /// The decoder for messages that are known to be of `scan_type`, whatever their schema says, if their encoding can be
    /// one of that type. Without a name of an encoding they are in CDR.
    pub fn for_type(scan_type: ScanType, message_encoding: &str) -> Option<Self> {
        let encoding = Encoding::of(message_encoding, "ros2msg")?;
        let is_of_foxglove = matches!(encoding, Encoding::Json | Encoding::Protobuf);
        let scan_type = match scan_type {
            ScanType::LaserScan if is_of_foxglove => ScanType::FoxgloveLaserScan,
            ScanType::PointCloud2 if is_of_foxglove => ScanType::FoxglovePointCloud,
            other => other,
        };
        Self::new(scan_type, encoding)
    }

    fn new(scan_type: ScanType, encoding: Encoding) -> Option<Self> {
        let is_of_foxglove = matches!(scan_type, ScanType::FoxgloveLaserScan | ScanType::FoxglovePointCloud);
        let fits = is_of_foxglove || matches!(encoding, Encoding::Cdr | Encoding::Ros1);
        let is_built = cfg!(feature = "foxglove") || !is_of_foxglove;
        (fits && is_built).then_some(Self { scan_type, encoding, echo: Echo::default() })
    }

    /// The type that messages are read as.
    pub fn scan_type(self) -> ScanType {
        self.scan_type
    }

    /// Whether messages are clouds.
    pub fn gives_clouds(self) -> bool {
        matches!(self.scan_type, ScanType::PointCloud2 | ScanType::FoxglovePointCloud)
    }

    /// Reads a message into `out`, whatever it held before, keeping its buffers.
    ///
    /// # Errors
    /// When it is not of the type, cut, or has more than [`MOST_BEAMS`] or [`MOST_POINTS`](crate::MOST_POINTS); `out` is
    /// then partly overwritten.
    pub fn decode_into(self, message: &[u8], out: &mut ScanMessage) -> Result<(), DecodeError> {
        self.read(message, out)?;
        match out {
            ScanMessage::Scan(scan) if scan.ranges.len() > MOST_BEAMS => {
                let cause = format!("{} are more than {MOST_BEAMS}", scan.ranges.len());
                Err(DecodeError::Value { field: "ranges", cause })
            }
            _ => Ok(()),
        }
    }

    fn read(self, message: &[u8], out: &mut ScanMessage) -> Result<(), DecodeError> {
        let fields = || match self.encoding {
            Encoding::Ros1 => Ok(Fields::ros1(message)),
            _ => Fields::cdr(message),
        };
        match self.scan_type {
            ScanType::LaserScan => out.as_scan_mut().read(&mut fields()?),
            ScanType::MultiEchoLaserScan => {
                let mut scan = MultiEchoLaserScan::default();
                scan.read(&mut fields()?)?;
                scan.write_scan(self.echo, out.as_scan_mut());
                Ok(())
            }
            ScanType::PointCloud2 => PointCloud2::read(&mut fields()?)?.write_cloud(out.as_cloud_mut()),
            #[cfg(feature = "foxglove")]
            ScanType::FoxgloveLaserScan => {
                let scan: FoxgloveScan = match self.encoding {
                    Encoding::Json => of_json(message)?,
                    Encoding::Protobuf => of_protobuf(message)?,
                    Encoding::Cdr | Encoding::Ros1 => FoxgloveScan::read(&mut fields()?)?,
                };
                scan.write_scan(out.as_scan_mut());
                Ok(())
            }
            #[cfg(feature = "foxglove")]
            ScanType::FoxglovePointCloud => {
                let cloud = match self.encoding {
                    Encoding::Json => of_json(message)?,
                    Encoding::Protobuf => FoxgloveCloud::of_protobuf(message)?,
                    Encoding::Cdr | Encoding::Ros1 => FoxgloveCloud::read(&mut fields()?)?,
                };
                cloud.write_cloud(out.as_cloud_mut())
            }
            #[cfg(not(feature = "foxglove"))]
            ScanType::FoxgloveLaserScan | ScanType::FoxglovePointCloud => unreachable!("no decoder is made for them"),
        }
    }
}

/// A type by the name of ROS 1, whichever way a recorder writes it: `sensor_msgs/LaserScan` of
/// `sensor_msgs/msg/LaserScan`, `sensor_msgs::msg::LaserScan` and `sensor_msgs::msg::dds_::LaserScan_`.
pub fn plain_type_name(name: &str) -> String {
    let parts: Vec<&str> = name.split(['/', ':']).filter(|part| !["", "msg"].contains(part)).collect();
    let is_dds = parts.contains(&"dds_");
    let kept = parts.iter().filter(|part| **part != "dds_");
    kept.map(|part| if is_dds { part.trim_end_matches('_') } else { part }).collect::<Vec<_>>().join("/")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_spelling_of_a_type_is_known() {
        for name in [
            "sensor_msgs/msg/LaserScan",
            "sensor_msgs/LaserScan",
            "sensor_msgs::msg::LaserScan",
            "sensor_msgs::msg::dds_::LaserScan_",
            "sensor_msgs/msg/dds_/LaserScan_",
        ] {
            let decoder = ScanDecoder::for_schema(name, "ros2idl", "cdr").map(ScanDecoder::scan_type);
            assert_eq!(decoder, Some(ScanType::LaserScan), "{name}");
        }
        for name in ["LaserScan", "my_msgs/msg/LaserScan", "sensor_msgs/msg/Image", ""] {
            assert_eq!(ScanDecoder::for_schema(name, "ros2msg", "cdr"), None, "{name}");
        }
    }

    #[test]
    fn encodings_that_do_not_belong_to_a_type_are_refused() {
        assert_eq!(ScanDecoder::for_schema("sensor_msgs/msg/LaserScan", "jsonschema", "json"), None);
        let in_ros = ScanDecoder::for_schema("foxglove_msgs/msg/LaserScan", "ros2msg", "cdr");
        assert_eq!(in_ros.map(ScanDecoder::scan_type), Some(ScanType::FoxgloveLaserScan));
        assert_eq!(ScanDecoder::for_schema("foxglove.LaserScan", "flatbuffer", "flatbuffer"), None);
        assert!(ScanDecoder::for_schema("sensor_msgs/LaserScan", "ros1msg", "").is_some());
    }

    #[test]
    fn a_named_type_needs_no_schema() {
        let named = |name: &str, encoding: &str| {
            ScanDecoder::for_type(ScanType::of_name(name)?, encoding).map(ScanDecoder::scan_type)
        };
        assert_eq!(named("LaserScan", "cdr"), Some(ScanType::LaserScan));
        assert_eq!(named("PointCloud2", ""), Some(ScanType::PointCloud2));
        assert_eq!(named("sensor_msgs/msg/LaserScan", "protobuf"), Some(ScanType::FoxgloveLaserScan));
        assert_eq!((named("Image", "cdr"), named("MultiEchoLaserScan", "json")), (None, None));
    }
}
