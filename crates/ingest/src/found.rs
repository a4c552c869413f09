//! What a file is that is no recording, and what to do about it.

use std::fmt;

/// What was found in place of a recording.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
#[allow(missing_docs)] // each says in words what it is
pub enum Found {
    Empty,
    Zeros,
    CutMcap,
    CutRosBag,
    Sqlite,
    /// A compressed file in a compressed file.
    CompressedTwice,
    /// Another kind of file: what it is, and what to do.
    Known(&'static str),
    /// A return a row, by its angle and its distance, that make no turn.
    AngleTable,
    /// A point a row, that make no turn.
    PointTable,
    /// The columns of a table that has no ranges; empty without names.
    OtherTable(String),
    /// Rows of `ros2 topic echo --csv` without all of their ranges.
    ShortenedEcho,
    /// Read by a container; never reported.
    Pcd,
    /// Read by a container; never reported.
    Ply,
    /// Text that is no table of ranges.
    Text,
    /// Its first bytes.
    Unknown(Vec<u8>),
}

/// The first bytes of a bag.
pub(crate) const ROS1_BAG_MAGIC: &[u8] = b"#ROSBAG V2.0\n";

const TEXT_MODE: Found = Found::Known(
    "it is an MCAP in which line ends were changed, by git (autocrlf) or a transfer in text mode; copy it again as a binary file",
);
const OLD_BAG: Found = Found::Known(
    "it is a ROS 1 bag of a version before 2.0, which only ROS 1 itself can bring up to date: `rosbag fix OLD.bag NEW.bag`",
);
const CLOUD: Found = Found::Known(
    "it is a point cloud in LAS, LAZ or E57; `pdal translate FILE.las FILE.ply` makes a PLY that is read, as one revolution",
);

/// The byte at which a kind of file has its sign, the sign, and the kind.
const SIGNS: &[(usize, &[u8], Found)] = &[
    (0, b"\x89MCAP0\n", TEXT_MODE),
    (0, b"\x89MCAP0\r\r\n", TEXT_MODE),
    (0, b"\x89MCAP", Found::Known("it is an MCAP of a version that is not known")),
    (0, b"#ROSRECORD V", OLD_BAG),
    (0, b"#ROSBAG V1", OLD_BAG),
    (0, b"SQLite format 3\0", Found::Sqlite),
    (
        0,
        b"RRF",
        Found::Known(
            "it is a Rerun recording, as `run --save` writes it: give its name to `crosscut run` or `crosscut debug`, or to \
             `crosscut rrd ls`, which lists what is in it",
        ),
    ),
    (0, b"\x1f\x8b", Found::Known("it is compressed with gzip; decompress it first: `gunzip FILE`")),
    (0, b"\xfd7zXZ\0", Found::Known("it is compressed with xz; decompress it first: `unxz FILE`")),
    (
        0,
        b"PK\x03\x04",
        Found::Known("it is a ZIP archive or a spreadsheet; unpack it first, `unzip FILE`, or save its table as CSV"),
    ),
    (257, b"ustar", Found::Known("it is a tar archive; unpack it first: `tar xf FILE`")),
    (
        0,
        b"\x93NUMPY",
        Found::Known(
            "it is a NumPy array; of one with a scan a row, `python3 -c 'import numpy, sys; numpy.savetxt(\"ranges.csv\", \
             numpy.load(sys.argv[1]), delimiter=\",\")' FILE.npy` makes a table that is read",
        ),
    ),
    (0, b"LASF", CLOUD),
    (0, b"ASTM-E57", CLOUD),
    (0, b"# .PCD", Found::Pcd),
    (0, b"VERSION .", Found::Pcd),
    (0, b"VERSION 0.", Found::Pcd),
    (0, b"ply\n", Found::Ply),
    (0, b"ply\r\n", Found::Ply),
    (
        0,
        b"version https://git-lfs.github.com/",
        Found::Known("it is a Git LFS pointer, not the file itself; fetch that with `git lfs pull`"),
    ),
];

const WEB_PAGE: &str = "it is a web page: the download failed, or needs a login; download the file again";
const BAG_METADATA: &str = "it is the metadata of a rosbag2; give its folder";
const JSON: &str = "it is JSON; of results of crosscut, give the recording that they were made of; save other scans as a table \
                    with a scan a row: time, r0, r1, ...";
const ECHO: &str = "it is text that `rostopic echo` or `ros2 topic echo` printed; what is read is a recording (`rosbag record`, \
                    `ros2 bag record`), or rows: `rostopic echo -p TOPIC`, `ros2 topic echo --csv --full-length TOPIC`";

/// How web pages begin, in small letters.
const PAGE_STARTS: [&str; 4] = ["<!doctype html", "<html", "<head", "<?xml"];

/// Of this many characters of a text, one may be damaged.
const READABLE: usize = 64;

impl Found {
    /// What a file is that begins with `start`.
    pub(crate) fn in_file(start: &[u8]) -> Self {
        let has = |(at, sign, _): &&(usize, &[u8], Self)| start.get(*at..).is_some_and(|rest| rest.starts_with(sign));
        let known = || SIGNS.iter().find(has).map(|(.., found)| found.clone());
        match start {
            [] => Self::Empty,
            _ if start.iter().all(|&byte| byte == 0) => Self::Zeros,
            _ if mcap::MAGIC.starts_with(start) => Self::CutMcap,
            _ if ROS1_BAG_MAGIC.starts_with(start) => Self::CutRosBag,
            _ => known()
                .or_else(|| Self::in_text(start))
                .unwrap_or_else(|| Self::Unknown(start[..start.len().min(8)].to_vec())),
        }
    }

    /// `None` if these bytes, of which the last character may be cut, are not what people read.
    fn in_text(start: &[u8]) -> Option<Self> {
        let whole = match std::str::from_utf8(start) {
            Err(error) if error.error_len().is_none() => &start[..error.valid_up_to()],
            _ => start,
        };
        let text = std::str::from_utf8(whole).ok()?.trim_start_matches('\u{feff}').trim_start();
        let is_control = |c: &char| c.is_control() && !c.is_whitespace();
        if text.chars().filter(is_control).count() > text.len() / READABLE {
            return None;
        }
        let lowercase: String = text.chars().take(20).collect::<String>().to_lowercase();
        let is_echo = |line: &str| line.trim_end() == "header:" || line.starts_with("angle_min: ");
        Some(match text {
            _ if PAGE_STARTS.iter().any(|page| lowercase.starts_with(page)) => Self::Known(WEB_PAGE),
            _ if text.contains("rosbag2_bagfile_information") => Self::Known(BAG_METADATA),
            _ if text.starts_with(['{', '[']) => Self::Known(JSON),
            _ if text.lines().any(is_echo) => Self::Known(ECHO),
            _ => Self::Text,
        })
    }

    /// A file that a crash may have left in place of a recording; not one that was named by mistake.
    pub(crate) fn may_be_a_wreck(&self) -> bool {
        matches!(self, Self::Empty | Self::Zeros | Self::CutMcap | Self::CutRosBag)
    }
}

impl fmt::Display for Found {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Empty => "it is empty",
            Self::Zeros => "it holds nothing but zeros, as a crash of the recording machine leaves it",
            Self::CutMcap => "it is cut off within the first 8 bytes of an MCAP",
            Self::CutRosBag => "it is cut off within the first 13 bytes of a ROS 1 bag",
            Self::Sqlite => "it is an SQLite file without the tables `topics` and `messages` of a rosbag2",
            Self::CompressedTwice => "it is compressed twice; decompress it first, once: `zstd -d FILE`, `lz4 -d`, `bunzip2`",
            Self::Known(kind) => kind,
            Self::AngleTable => {
                "it may be a list with an angle and a distance in each row, but it has too few rows to be a turn of a \
                 lidar, or they show no angle that goes round; name its columns: --set csv.columns=angle,distance"
            }
            Self::PointTable => {
                "its rows may be points, but they are too few, or places of a vehicle on its way; where they are what \
                 a lidar saw, name their columns: --set csv.columns=x,y, or x,y,turn"
            }
            Self::OtherTable(columns) if columns.is_empty() => {
                "it is a table without ranges; a table of ranges has a scan a row: time, r0, r1, ..."
            }
            Self::OtherTable(columns) => {
                return write!(
                    f,
                    "it is a table with the columns {columns}, of which none are known to be ranges; where it has a scan a \
                     row, say which they are: --set csv.columns=time,r*; where it has a return a row: \
                     --set csv.columns=time,angle,distance"
                );
            }
            Self::ShortenedEcho => {
                "its rows were shortened by `ros2 topic echo`; write them as a whole: `ros2 topic echo --csv \
                 --full-length TOPIC`"
            }
            Self::Pcd => "it is a point cloud in PCD",
            Self::Ply => "it is a point cloud in PLY",
            Self::Text => "it is text, but no table of ranges; such a table has a scan a row: time, r0, r1, ...",
            Self::Unknown(start) => {
                return write!(f, "it begins with the bytes {start:02x?}, which is no known format");
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kinds_of_files_are_told_apart_by_their_first_bytes() {
        let tar = [&[b'n'; 257][..], b"ustar"].concat();
        for (start, words) in [
            (&b""[..], "is empty"),
            (&[0; 100], "nothing but zeros"),
            (b"\x89MCA", "cut off within the first 8 bytes"),
            (b"#ROSB", "cut off within the first 13 bytes"),
            (b"#ROSRECORD V1.2\n", "rosbag fix"),
            (b"#ROSBAG V1.1\n", "rosbag fix"),
            (b"\x89MCAP0\n\x01", "line ends were changed"), // the magic has CR LF to show just this
            (b"\x89MCAP0\r\r\n\x01", "line ends were changed"),
            (b"\x89MCAP1\r\n", "version that is not known"),
            (b"SQLite format 3\0\x10", "SQLite"),
            (b"\xfd7zXZ\0\0", "unxz"),
            (&tar, "tar xf"),
            (b"RRF2\0\0", "Rerun"),
            (b"PK\x03\x04", "unzip"),
            (b"# .PCD v0.7 - Point Cloud Data\n", "PCD"),
            (b"ply\r\nformat binary_little_endian 1.0\r\n", "PLY"),
            (b"\xff\xfe\xfd", "bytes [ff, fe, fd]"),
            (b"header:\n  stamp:\n    sec: 5\n", "echo"),
            (b"{\"seq\":0}\n", "JSON"),
            (b"version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\n", "git lfs pull"),
            (b"\n<!DOCTYPE html>\n<title>Sign in</title>", "web page"),
            (b"rosbag2_bagfile_information:\n  version: 9\n", "give its folder"),
            (b"MIT License\n\nCopyright (c) 2026 whoever\n", "it is text"),
        ] {
            let found = Found::in_file(start).to_string();
            assert!(found.contains(words), "{words}: {found}");
        }
    }
}
