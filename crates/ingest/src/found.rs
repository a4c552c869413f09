//! What a file is that is no recording, and what to do about it.

use std::fmt;

use crate::container;

/// What was found in place of a recording.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
#[allow(missing_docs)] // each says in words what it is
pub enum Found {
    Empty,
    Zeros,
    OtherMcapVersion,
    /// An MCAP in which line ends were changed.
    TextMode,
    CutMcap,
    OldRosBag,
    CutRosBag,
    Sqlite,
    Rerun,
    /// A compressed file in a compressed file.
    CompressedTwice,
    Gzip,
    Xz,
    SevenZip,
    Zip,
    Spreadsheet,
    Tar,
    Pcap,
    ULog,
    NumPy,
    Las,
    E57,
    Matlab,
    Hdf5,
    Parquet,
    Pickle,
    Picture,
    Mesh,
    LfsPointer,
    WebPage,
    BagMetadata,
    /// Read by a container; never reported.
    Carmen,
    Json,
    /// A return a row, by its angle and its distance.
    AngleTable,
    /// A point a row.
    PointTable,
    /// The columns of a table that has no ranges; empty without names.
    OtherTable(String),
    /// Rows of `ros2 topic echo --csv` without all of their ranges.
    ShortenedEcho,
    /// Messages as `rostopic echo` and `ros2 topic echo` print them.
    EchoText,
    /// Read by a container; never reported.
    Pcd,
    /// Read by a container; never reported.
    Ply,
    /// Text of no known format.
    Text,
    /// Its first bytes.
    Unknown(Vec<u8>),
}

/// The first bytes of binary formats.
const SIGNS: &[(&[u8], Found)] = &[
    (b"\x89MCAP0\n", Found::TextMode),
    (b"\x89MCAP0\r\r\n", Found::TextMode),
    (b"\x89MCAP", Found::OtherMcapVersion),
    (b"#ROSRECORD V", Found::OldRosBag),
    (b"#ROSBAG V1", Found::OldRosBag),
    (b"SQLite format 3\0", Found::Sqlite),
    (b"RRF", Found::Rerun),
    (b"\x1f\x8b", Found::Gzip),
    (b"\xfd7zXZ\0", Found::Xz),
    (b"7z\xbc\xaf\x27\x1c", Found::SevenZip),
    (ZIP, Found::Zip),
    (b"\xd4\xc3\xb2\xa1", Found::Pcap),
    (b"\xa1\xb2\xc3\xd4", Found::Pcap),
    (b"\x0a\x0d\x0d\x0a", Found::Pcap),
    (b"ULog", Found::ULog),
    (b"\x93NUMPY", Found::NumPy),
    (b"LASF", Found::Las),
    (b"ASTM-E57", Found::E57),
    (b"MATLAB ", Found::Matlab),
    (b"\x89HDF\r\n\x1a\n", Found::Hdf5),
    (b"PAR1", Found::Parquet),
    (b"\x80\x03", Found::Pickle),
    (b"\x80\x04\x95", Found::Pickle),
    (b"\x80\x05\x95", Found::Pickle),
    (b"\x89PNG", Found::Picture),
    (b"\xff\xd8\xff", Found::Picture),
    (b"P2\n", Found::Picture),
    (b"P5\n", Found::Picture),
    (b"solid ", Found::Mesh),
    (b"# .PCD", Found::Pcd),
    (b"VERSION .", Found::Pcd),
    (b"VERSION 0.", Found::Pcd),
    (b"ply\n", Found::Ply),
    (b"ply\r\n", Found::Ply),
    (b"version https://git-lfs.github.com/", Found::LfsPointer),
];

/// How a ZIP archive begins, and where the name of its first file stands.
const ZIP: &[u8] = b"PK\x03\x04";
const ZIP_NAME_AT: usize = 30;
/// The first file of documents that are ZIP archives: of Excel and its kin, and of LibreOffice.
const FIRST_IN_DOCUMENTS: [&[u8]; 2] = [b"[Content_Types].xml", b"mimetype"];

/// What a tar archive has at this byte.
const TAR_SIGN: (usize, &[u8]) = (257, b"ustar");

/// How web pages begin, in small letters.
const PAGE_STARTS: [&str; 4] = ["<!doctype html", "<html", "<head", "<?xml"];

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
        if container::ROS1_BAG_MAGIC.starts_with(start) {
            return Self::CutRosBag;
        }
        if container::is_compressed(start) {
            return Self::CompressedTwice;
        }
        if start.get(TAR_SIGN.0..).is_some_and(|rest| rest.starts_with(TAR_SIGN.1)) {
            return Self::Tar;
        }
        let first_in_zip = start.get(ZIP_NAME_AT..).filter(|_| start.starts_with(ZIP)).unwrap_or_default();
        if FIRST_IN_DOCUMENTS.iter().any(|name| first_in_zip.starts_with(name)) {
            return Self::Spreadsheet;
        }
        if let Some((_, found)) = SIGNS.iter().find(|(sign, _)| start.starts_with(sign)) {
            return found.clone();
        }
        let unknown = || if is_text(start) { Self::Text } else { Self::Unknown(start[..start.len().min(8)].to_vec()) };
        Self::in_text(start).unwrap_or_else(unknown)
    }

    fn in_text(start: &[u8]) -> Option<Self> {
        // The last character may be cut in two.
        let valid = match std::str::from_utf8(start) {
            Ok(text) => text,
            Err(error) if error.error_len().is_none() => std::str::from_utf8(&start[..error.valid_up_to()]).ok()?,
            Err(_) => return None,
        };
        let text = valid.trim_start_matches('\u{feff}').trim_start();
        let lowercase: String = text.chars().take(20).collect::<String>().to_lowercase();
        if PAGE_STARTS.iter().any(|page| lowercase.starts_with(page)) {
            return Some(Self::WebPage);
        }
        if text.contains("rosbag2_bagfile_information") {
            return Some(Self::BagMetadata);
        }
        if text.starts_with('{') || text.starts_with('[') {
            return Some(Self::Json);
        }
        if container::is_carmen_log(text) {
            return Some(Self::Carmen);
        }
        if text.lines().any(|line| line.trim_end() == "header:" || line.starts_with("angle_min: ")) {
            return Some(Self::EchoText);
        }
        // As the example of the RPLidar's SDK prints it.
        if text.lines().any(|line| line.contains("theta:") && line.contains("Dist:")) {
            return Some(Self::AngleTable);
        }
        None
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
            Self::OtherMcapVersion => "it is an MCAP of a version that is not known",
            Self::TextMode => {
                "it is an MCAP in which line ends were changed, by git (autocrlf) or a transfer in text mode; copy it \
                 again as a binary file"
            }
            Self::CutMcap => "it is cut off within the first 8 bytes of an MCAP",
            Self::OldRosBag => {
                "it is a ROS 1 bag of a version before 2.0, which only ROS 1 itself can bring up to date: \
                 `rosbag fix OLD.bag NEW.bag`"
            }
            Self::CutRosBag => "it is cut off within the first 13 bytes of a ROS 1 bag",
            Self::Sqlite => "it is an SQLite file without the tables `topics` and `messages` of a rosbag2",
            Self::Rerun => {
                "it is a Rerun recording, as `run --save` writes it: give its name to `crosscut run` or `crosscut debug`, or to \
                 `crosscut rrd ls`, which lists what is in it"
            },
            Self::CompressedTwice => "it is compressed twice; decompress it first, once: `zstd -d FILE`, `lz4 -d`, `bunzip2`",
            Self::Gzip => "it is compressed with gzip; decompress it first: `gunzip FILE`",
            Self::Xz => "it is compressed with xz; decompress it first: `unxz FILE`",
            Self::SevenZip => "it is a 7z archive; unpack it first: `7z x FILE`",
            Self::Zip => "it is a ZIP archive; unpack it first: `unzip FILE`",
            Self::Spreadsheet => "it is a document such as a spreadsheet; save its table as CSV, a scan a row: time, r0, r1, ...",
            Self::Tar => "it is a tar archive; unpack it first: `tar xf FILE`",
            Self::Pcap => "it is a capture of network packets; the driver of the sensor makes scans of it",
            Self::ULog => "it is a PX4 ULog, which has no laser scans",
            Self::NumPy => {
                "it is a NumPy array; of one with a scan a row, `python3 -c 'import numpy, sys; \
                 numpy.savetxt(\"ranges.csv\", numpy.load(sys.argv[1]), delimiter=\",\")' FILE.npy` makes a table that is \
                 read"
            }
            Self::Las => {
                "it is a point cloud in LAS or LAZ; `pdal translate FILE.las FILE.ply` makes a PLY that is read, as one \
                 revolution"
            }
            Self::E57 => {
                "it is a point cloud in E57; `pdal translate FILE.e57 FILE.ply` makes a PLY that is read, as one \
                 revolution"
            }
            Self::Matlab => {
                "it is a MATLAB file; of a matrix with a scan a row, `writematrix(ranges, 'ranges.csv')` makes a table \
                 that is read"
            }
            Self::Hdf5 => {
                "it is an HDF5 file; a table with a scan a row is read as CSV: time, r0, r1, ... (docs/recordings.md)"
            }
            Self::Parquet => {
                "it is a Parquet file; a table with a scan a row is read as CSV: `python3 -c 'import pandas, sys; \
                 pandas.read_parquet(sys.argv[1]).to_csv(\"ranges.csv\", index=False)' FILE`"
            }
            Self::Pickle => "it is a Python pickle, which is not read; save a scan a row as CSV: time, r0, r1, ...",
            Self::Picture => "it is a picture; crosscut reads the scans of a lidar, no maps",
            Self::Mesh => "it is a mesh (STL), which holds no scans; crosscut reads the recordings of a lidar",
            Self::LfsPointer => "it is a Git LFS pointer, not the file itself; fetch that with `git lfs pull`",
            Self::WebPage => "it is a web page: the download failed, or needs a login; download the file again",
            Self::BagMetadata => "it is the metadata of a rosbag2; give its folder",
            Self::Carmen => "it is a CARMEN log",
            Self::Json => {
                "it is JSON; of results of crosscut, give the recording that they were made of; save other scans as a table \
                 with a scan a row: time, r0, r1, ..."
            }
            Self::AngleTable => {
                "it is a table with an angle and a distance in each row; a table of ranges has a scan a row: write the \
                 distances of each turn, by angle, into one row, and give the bearings of the first and the last one \
                 (docs/recordings.md has the lines of Python that do it)"
            }
            Self::PointTable => {
                "its rows are points, not the ranges of scans; save the points of each turn as a PLY or PCD of its own, \
                 and give their folder"
            }
            Self::OtherTable(columns) if columns.is_empty() => {
                "it is a table without ranges; a table of ranges has a scan a row: time, r0, r1, ..."
            }
            Self::OtherTable(columns) => {
                return write!(
                    f,
                    "it is a table with the columns {columns}, of which none are known to be ranges; where it has a scan a row, \
                     say which they are: --set csv.columns=time,r*"
                );
            }
            Self::ShortenedEcho => {
                "its rows were shortened by `ros2 topic echo`; write them as a whole: `ros2 topic echo --csv \
                 --full-length TOPIC`"
            }
            Self::EchoText => {
                "it is text that `rostopic echo` or `ros2 topic echo` printed; what is read is a recording (`rosbag record`, \
                 `ros2 bag record`), or rows: `rostopic echo -p TOPIC`, `ros2 topic echo --csv --full-length TOPIC`"
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

/// Whether these bytes, of which the last may be cut, are characters that people read.
fn is_text(start: &[u8]) -> bool {
    let whole = match std::str::from_utf8(start) {
        Err(error) if error.error_len().is_none() => std::str::from_utf8(&start[..error.valid_up_to()]),
        whole => whole,
    };
    whole.is_ok_and(|text| !text.contains(|c: char| c.is_control() && !c.is_whitespace()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_formats_are_told_apart_by_their_first_lines() {
        let found = |text: &str| Found::in_file(text.as_bytes());
        assert_eq!(found("# message_name [message contents]\nPARAM a 1\nFLASER 3 1 2 3\n"), Found::Carmen);
        assert_eq!(found("header:\n  stamp:\n    sec: 5\n"), Found::EchoText);
        assert_eq!(found("{\"seq\":0}\n"), Found::Json);
        assert_eq!(found("version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\n"), Found::LfsPointer);
        assert_eq!(found("\n<!DOCTYPE html>\n<title>Sign in</title>"), Found::WebPage);
        assert_eq!(found("rosbag2_bagfile_information:\n  version: 9\n"), Found::BagMetadata);
        assert_eq!(found("MIT License\n\nCopyright (c) 2026 whoever\n"), Found::Text);
    }

    #[test]
    fn binary_formats_are_told_apart_by_their_signs() {
        assert_eq!(Found::in_file(b""), Found::Empty);
        assert_eq!(Found::in_file(&[0; 100]), Found::Zeros);
        assert_eq!(Found::in_file(b"\x89MCA"), Found::CutMcap);
        assert_eq!(Found::in_file(b"#ROSB"), Found::CutRosBag);
        for old in [&b"#ROSRECORD V1.2\n"[..], b"#ROSBAG V1.1\n"] {
            assert_eq!(Found::in_file(old), Found::OldRosBag);
        }
        for changed in [&b"\x89MCAP0\n\x01"[..], b"\x89MCAP0\r\r\n\x01"] {
            assert_eq!(Found::in_file(changed), Found::TextMode, "the magic has CR LF to show just this");
        }
        assert_eq!(Found::in_file(b"\x89MCAP1\r\n"), Found::OtherMcapVersion);
        assert_eq!(Found::in_file(b"SQLite format 3\0\x10"), Found::Sqlite);
        assert_eq!(Found::in_file(b"\xfd7zXZ\0\0"), Found::Xz);
        assert_eq!(Found::in_file(&[&[b'n'; 257][..], b"ustar"].concat()), Found::Tar);
        assert_eq!(Found::in_file(b"RRF2\0\0"), Found::Rerun);
        assert_eq!(Found::in_file(b"PK\x03\x04"), Found::Zip);
        assert_eq!(Found::in_file(&[ZIP, &[1; 26], b"[Content_Types].xml"].concat()), Found::Spreadsheet);
        assert_eq!(Found::in_file(b"solid mine\n facet normal 0 0 1\n"), Found::Mesh);
        assert_eq!(Found::in_file(b"P2\n4 4\n255\n"), Found::Picture);
        assert_eq!(Found::in_file(b"# .PCD v0.7 - Point Cloud Data\n"), Found::Pcd);
        assert_eq!(Found::in_file(b"ply\r\nformat binary_little_endian 1.0\r\n"), Found::Ply);
        assert_eq!(Found::in_file(b"\xff\xfe\xfd"), Found::Unknown(vec![0xff, 0xfe, 0xfd]));
    }
}
