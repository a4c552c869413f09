//! What a file is that is not an MCAP, and how to make one of it.

use std::fmt;

/// What was found in place of an MCAP.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
#[allow(missing_docs)] // each says in words what it is
pub enum Found {
    Empty,
    Zeros,
    OtherMcapVersion,
    CutMcap,
    Ros1Bag,
    Sqlite,
    Rerun,
    Compressed,
    Zip,
    Pcap,
    ULog,
    BagMetadata,
    Carmen,
    Json,
    Table,
    /// Its first bytes.
    Unknown(Vec<u8>),
}

/// The signs of binary formats, at the start of the file.
const SIGNS: &[(&[u8], Found)] = &[
    (b"\x89MCAP", Found::OtherMcapVersion),
    (b"#ROSBAG V", Found::Ros1Bag),
    (b"SQLite format 3\0", Found::Sqlite),
    (b"RRF", Found::Rerun),
    (b"\x28\xb5\x2f\xfd", Found::Compressed),
    (b"\x1f\x8b", Found::Compressed),
    (b"\x04\x22\x4d\x18", Found::Compressed),
    (b"PK\x03\x04", Found::Zip),
    (b"\xd4\xc3\xb2\xa1", Found::Pcap),
    (b"\xa1\xb2\xc3\xd4", Found::Pcap),
    (b"\x0a\x0d\x0d\x0a", Found::Pcap),
    (b"ULog", Found::ULog),
];

/// The first word of a line in a CARMEN log.
const CARMEN_WORDS: &[&str] = &["FLASER", "RLASER", "ROBOTLASER1", "RAWLASER1", "ODOM", "PARAM", "SYNC", "TRUEPOS"];

impl Found {
    /// What a file is that begins with `start`.
    pub(crate) fn in_file(start: &[u8]) -> Self {
        if start.is_empty() {
            return Self::Empty;
        }
        if start.iter().all(|&byte| byte == 0) {
            return Self::Zeros;
        }
        if mcap::MAGIC.starts_with(start) {
            return Self::CutMcap;
        }
        if let Some((_, found)) = SIGNS.iter().find(|(sign, _)| start.starts_with(sign)) {
            return found.clone();
        }
        Self::in_text(start).unwrap_or_else(|| Self::Unknown(start[..start.len().min(8)].to_vec()))
    }

    fn in_text(start: &[u8]) -> Option<Self> {
        // The last character may be cut in two.
        let valid = match std::str::from_utf8(start) {
            Ok(text) => text,
            Err(error) if error.error_len().is_none() => std::str::from_utf8(&start[..error.valid_up_to()]).ok()?,
            Err(_) => return None,
        };
        let text = valid.trim_start_matches('\u{feff}').trim_start();
        if text.contains("rosbag2_bagfile_information") {
            return Some(Self::BagMetadata);
        }
        if text.starts_with('{') || text.starts_with('[') {
            return Some(Self::Json);
        }
        let words_of = |line: &str| line.split_whitespace().next().map(str::to_owned);
        if text.lines().filter_map(words_of).any(|word| CARMEN_WORDS.contains(&word.as_str())) {
            return Some(Self::Carmen);
        }
        let first_line = text.lines().next()?;
        let is_separator = |c: char| matches!(c, ',' | ';' | '\t' | ' ');
        let mut cells = first_line.split(is_separator).filter(|cell| !cell.is_empty());
        // The last cell may be cut.
        let first_cells: Vec<_> = cells.by_ref().take(3).collect();
        let numbers = first_cells.len() == 3 && first_cells.iter().all(|cell| cell.parse::<f64>().is_ok());
        (numbers || first_line.matches(',').count() >= 3).then_some(Self::Table)
    }

    /// A file that a crash may have left in place of a recording; not one that was named by mistake.
    pub(crate) fn may_be_a_wreck(&self) -> bool {
        matches!(self, Self::Empty | Self::Zeros | Self::CutMcap)
    }
}

impl fmt::Display for Found {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Empty => "it is empty",
            Self::Zeros => "it holds nothing but zeros, as a crash of the recording machine leaves it",
            Self::OtherMcapVersion => "it is of another version of that format; `mcap recover` may read it",
            Self::CutMcap => "it is cut off within the first 8 bytes of one",
            Self::Ros1Bag => {
                "it is a ROS 1 bag; convert it with `mcap convert FLIGHT.bag FLIGHT.mcap`, or `rosbags-convert \
                 --src FLIGHT.bag --dst FLIGHT --dst-storage mcap` (pip install rosbags)"
            }
            Self::Sqlite => {
                "it is an SQLite file, such as a rosbag2 .db3; convert it with `mcap convert FLIGHT.db3 FLIGHT.mcap` or \
                 `ros2 bag convert`"
            }
            Self::Rerun => "it is a Rerun recording, which is what crosscut writes; give it the MCAP that it was made of",
            Self::Compressed => "it is a compressed file; decompress it first",
            Self::Zip => "it is a ZIP archive; unpack it first",
            Self::Pcap => "it is a capture of network packets; convert it with the driver of the sensor",
            Self::ULog => "it is a PX4 ULog, which has no laser scans",
            Self::BagMetadata => "it is the metadata of a rosbag2; give its folder, or the .mcap files in it",
            Self::Carmen => {
                "it is a CARMEN log; convert its laser lines to sensor_msgs/msg/LaserScan in an MCAP, for example with \
                 the Python packages mcap and mcap-ros2-support"
            }
            Self::Json => "it is JSON, such as results of crosscut; give the MCAP that they were made of",
            Self::Table => {
                "it is a table, such as CSV; convert its rows to sensor_msgs/msg/LaserScan in an MCAP, for example with \
                 the Python packages mcap and mcap-ros2-support"
            }
            Self::Unknown(start) => return write!(f, "it begins with the bytes {start:02x?}, which is no known format"),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_formats_are_told_apart_by_their_first_lines() {
        let found = |text: &str| Found::in_file(text.as_bytes());
        assert_eq!(found("# message_name [message contents]\nPARAM a 1\nFLASER 3 1 2 3\n"), Found::Carmen);
        assert_eq!(found("\u{feff}0.018,nan,1.25,3\n"), Found::Table);
        assert_eq!(found("1.0 2.0 3.0\n"), Found::Table);
        assert_eq!(found("seq,stamp,r0,r1\n"), Found::Table);
        assert_eq!(found("{\"seq\":0}\n"), Found::Json);
        assert_eq!(found("rosbag2_bagfile_information:\n  version: 9\n"), Found::BagMetadata);
        assert!(matches!(found("Dear reader"), Found::Unknown(_)));
    }

    #[test]
    fn binary_formats_are_told_apart_by_their_signs() {
        assert_eq!(Found::in_file(b""), Found::Empty);
        assert_eq!(Found::in_file(&[0; 100]), Found::Zeros);
        assert_eq!(Found::in_file(b"\x89MCA"), Found::CutMcap);
        assert_eq!(Found::in_file(b"#ROSBAG V2.0\n"), Found::Ros1Bag);
        assert_eq!(Found::in_file(b"SQLite format 3\0\x10"), Found::Sqlite);
        assert_eq!(Found::in_file(b"RRF2\0\0"), Found::Rerun);
        assert_eq!(Found::in_file(b"\xff\xfe\xfd"), Found::Unknown(vec![0xff, 0xfe, 0xfd]));
    }
}
