//! What a recording should have given and could not.

use std::path::PathBuf;

use crosscut_messages::DecodeError;
use crosscut_stage::counted;

/// Something that was lost, or had to be read another way. It did not stop the reading of the rest.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{kind}, in {}", file.display())]
pub struct Loss {
    /// Where.
    pub file: PathBuf,
    /// What.
    pub kind: LossKind,
}

/// What was lost.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LossKind {
    /// The file ends before its end: whatever was recorded after that is not there.
    #[error(
        "cut off within the record that begins at byte {at_byte}: every whole message was read, what came after is missing"
    )]
    CutOff {
        /// Where the record that is not whole begins.
        at_byte: u64,
    },
    /// All messages are there, but not what would put them in order.
    #[error("the index at its end cannot be used ({damage}): read in file order")]
    Index {
        /// What is wrong with it.
        damage: Damage,
    },
    /// The file goes on behind the end of the recording.
    #[error("the recording ends at byte {at_byte}; {bytes} bytes behind that were not read (another recording?)")]
    Behind {
        /// Where the recording ends.
        at_byte: u64,
        /// How much there is behind it.
        bytes: u64,
    },
    /// A chunk, or a record outside of chunks, gave nothing; the rest was read.
    #[error("the {} at byte {at_byte} is lost: {damage}", scans_at(*scans))]
    Part {
        /// Where it begins.
        at_byte: u64,
        /// How many scans were in it, if that is known.
        scans: Option<u64>,
        /// What is wrong with it.
        damage: Damage,
    },
    /// From here on nothing can be read.
    #[error("nothing can be read from byte {at_byte} on: {damage}")]
    Rest {
        /// Where.
        at_byte: u64,
        /// What is wrong there.
        damage: Damage,
    },
    /// Scan messages that are there but make no sense; each is an empty revolution in the results.
    #[error("{} of {topic} cannot be decoded, the first is number {first_seq}: {cause}", counted(*count, "message"))]
    Messages {
        /// Topic of the scans.
        topic: String,
        /// Index of the first one in its topic.
        first_seq: u64,
        /// How many.
        count: u64,
        /// What is wrong with the first one.
        cause: DecodeError,
    },
    /// Odometry of which nothing is of use.
    #[error("no message of {topic} can be used: {cause}")]
    NoneUsable {
        /// Topic of the odometry.
        topic: String,
        /// What is wrong with its first message.
        cause: DecodeError,
    },
    /// Lines of a text file that cannot be read.
    #[error("{} cannot be read, the first is number {first}: {cause}", counted(*count, "line"))]
    Lines {
        /// Number of the first one, counted from 1.
        first: u64,
        /// How many.
        count: u64,
        /// What is wrong with the first one.
        cause: String,
    },
    /// The last line of a text file has no end.
    #[error("line {line} has no end: its last number may be cut short")]
    LastLine {
        /// Its number, counted from 1.
        line: u64,
    },
    /// Messages whose topic is not defined in any part that can be read.
    #[error("the definition of a topic is lost, and with it {}", counted(*count, "message"))]
    UnknownTopic {
        /// How many.
        count: u64,
    },
    /// The recording counts more scans than can be found, and no damage explains it.
    #[error("{} of {topic} that the recording counts cannot be found", counted(*count, "message"))]
    Missing {
        /// Topic of the scans.
        topic: String,
        /// How many.
        count: u64,
    },
    /// The file is compressed as a whole, and the rest of it cannot be decompressed.
    #[error("it can be decompressed up to byte {read_bytes} only: {damage}")]
    Compressed {
        /// How many bytes were decompressed.
        read_bytes: u64,
        /// What is wrong behind them.
        damage: Damage,
    },
    /// Everything could be read, but some of it is not what was written.
    #[error("its content was altered after it was written, at an unknown place: {damage}")]
    Altered {
        /// Which checksum is wrong.
        damage: Damage,
    },
    /// Messages of a live robot that it sent and that did not arrive, by their numbers.
    #[error("{} of {topic} did not arrive", counted(*count, "message"))]
    NotArrived {
        /// The topic.
        topic: String,
        /// How many.
        count: u64,
    },
    /// Messages of a live robot for which there was no time.
    #[error("{} of {topic} came faster than they could be answered, and were left out", counted(*count, "message"))]
    TooLate {
        /// The topic.
        topic: String,
        /// How many.
        count: u64,
    },
    /// One of several files of a flight is of no use.
    #[error("left out: {cause}")]
    File {
        /// Why.
        cause: String,
    },
}

fn scans_at(scans: Option<u64>) -> String {
    scans.map_or_else(|| "part".to_owned(), |scans| format!("part with {}", counted(scans, "scan")))
}

/// What is wrong with a stretch of bytes.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Damage {
    /// It is shorter than it says.
    #[error("it ends in the middle of a record")]
    Ended,
    /// Its bytes are not those that were written.
    #[error("its checksum is {calculated:#010x} instead of {saved:#010x}")]
    Checksum {
        /// As written.
        saved: u32,
        /// Of the bytes that are there.
        calculated: u32,
    },
    /// Compressed in a way that this program does not know.
    #[error("its compression `{0}` is not known")]
    Compression(String),
    /// Larger than anything that is read.
    #[error("{bytes} bytes are more than the {limit} that are read")]
    TooLarge {
        /// As it claims.
        bytes: u64,
        /// The limit.
        limit: u64,
    },
    /// The decompression or the disk says no.
    #[error("it cannot be read: {0}")]
    Unreadable(String),
    /// A record that cannot be.
    #[error("{0}")]
    Record(String),
}

impl From<std::io::Error> for Damage {
    fn from(error: std::io::Error) -> Self {
        match error.kind() {
            std::io::ErrorKind::UnexpectedEof => Self::Ended,
            _ => Self::Unreadable(error.to_string()),
        }
    }
}

impl From<mcap::McapError> for Damage {
    fn from(error: mcap::McapError) -> Self {
        Self::Record(error.to_string())
    }
}
