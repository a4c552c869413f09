//! Recordings read back: values by entity and revolution, as numbers and words.
//!
//! In: the .rrd files that `crosscut run --save` writes. Out: entities, their rows by revolution, and the difference
//! between two recordings.
//!
//! [`Recording::open`] goes through the file once and notes where the chunks of each entity lie; [`Recording::rows`]
//! then loads one chunk after the other, so that memory stays small whatever the size of the file. Rows come by
//! revolution, whatever chunks and files they were written in: the later parts of a long recording are found beside
//! the first. A damaged file is read as far as possible: [`Recording::damages`] lists what is missing.
//!
//! ```no_run
//! use crosscut_rrd::{ReadError, Recording, Value};
//!
//! # fn main() -> Result<(), ReadError> {
//! let recording = Recording::open("flight.rrd".as_ref())?;
//! for row in recording.rows("/spectral/eigenvalues")? {
//!     let row = row?;
//!     if let Value::Numbers(eigenvalues) = row.value("BarChart:values")? {
//!         println!("{:?}: {:?}", row.revolution, eigenvalues.to_f64());
//!     }
//! }
//! # Ok(())
//! # }
//! ```
//!
//! Values come out as they are stored: f64 and f32 as such, f16 widened to f32, whole numbers as i64. Pictures of W and
//! L become numbers by their scale, see [`Row::value`].

mod cell;
mod difference;
mod latest;
pub mod messages;
pub mod parts;
mod recording;
mod revolutions;
mod rows;
pub mod schema;
mod span;
mod value;

use std::path::{Path, PathBuf};

pub use difference::{Difference, Differences, differences};
pub use latest::Latest;
pub use recording::{Component, RecordedEntity, Recording, is_picture};
pub use revolutions::{RecordedScan, Revolutions};
pub use rows::{Row, Rows};
pub use value::{Array, Numbers, Value};

/// Why nothing can be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The file is not there, or it is no recording.
    #[error("cannot read the recording: {cause}: {}", path.display())]
    Open {
        /// Which file.
        path: PathBuf,
        /// What is wrong.
        cause: String,
    },
    /// A file or message that could be read before cannot be any more.
    #[error("the recording changed while it was read: {cause}: {}", path.display())]
    Changed {
        /// Which file.
        path: PathBuf,
        /// What is wrong.
        cause: String,
    },
    /// The file holds several recordings, and none was chosen.
    #[error("the file holds several recordings: {}: {}", ids.join(", "), path.display())]
    Several {
        /// Which file.
        path: PathBuf,
        /// The identifiers of its recordings, in the order of the file.
        ids: Vec<String>,
    },
    /// The file holds other recordings than the one asked for.
    #[error("the file holds no recording {id}, but {}: {}", ids.join(", "), path.display())]
    NoSuchRecording {
        /// Which file.
        path: PathBuf,
        /// What was asked for.
        id: String,
        /// The identifiers of its recordings, in the order of the file.
        ids: Vec<String>,
    },
    /// The recording has no such entity.
    #[error("the recording has no entity {entity}; there are {}", near.join(", "))]
    NoSuchEntity {
        /// What was asked for.
        entity: String,
        /// The entities of the same step, or all of them if it has none.
        near: Vec<String>,
    },
    /// The entity has no such component at this revolution.
    #[error("{entity} has no {component}; it has {}", known.join(", "))]
    NoSuchComponent {
        /// Which entity.
        entity: String,
        /// What was asked for.
        component: String,
        /// What there is.
        known: Vec<String>,
    },
    /// The component holds neither numbers nor words.
    #[error("{entity}, {component}: {cause}")]
    NotAValue {
        /// Which entity.
        entity: String,
        /// Which component.
        component: String,
        /// What it is instead.
        cause: String,
    },
}

/// What a recording lacks. Everything else is read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Damage {
    /// The file ends with a whole message, but not as a finished recording does.
    #[error(
        "ends without its footer, after {bytes} bytes: what wrote it was stopped; {}: {}", whole(*whole_to), path.display()
    )]
    Unfinished {
        /// Which file.
        path: PathBuf,
        /// Its length.
        bytes: u64,
        /// The last revolution that is whole, as all before it are.
        whole_to: Option<i64>,
    },
    /// The file ends in the middle of a message.
    #[error("cut off in the message at byte {at} of {bytes}; {}: {}", whole(*whole_to), path.display())]
    CutOff {
        /// Which file.
        path: PathBuf,
        /// Where the message starts.
        at: u64,
        /// Length of the file.
        bytes: u64,
        /// The last revolution that is whole, as all before it are.
        whole_to: Option<i64>,
    },
    /// A message that cannot be read.
    #[error("unreadable at byte {at}: {cause}: {}", path.display())]
    Unreadable {
        /// Which file.
        path: PathBuf,
        /// Where the message starts.
        at: u64,
        /// What is wrong.
        cause: String,
    },
    /// Parts of the recording are not there, though later ones are.
    #[error("{} missing: {}", parts(*first, *last), path.display())]
    PartsMissing {
        /// The file that was opened.
        path: PathBuf,
        /// The first part that is missing.
        first: u64,
        /// The last one.
        last: u64,
    },
    /// The last part that is there says that another one follows.
    #[error("part {part}, which continues the recording, is missing: {}", path.display())]
    EndMissing {
        /// The file that was opened.
        path: PathBuf,
        /// The part that would follow.
        part: u64,
    },
}

impl Damage {
    /// Whether the file was not written to its end.
    pub fn is_cut(&self) -> bool {
        matches!(self, Self::Unfinished { .. } | Self::CutOff { .. })
    }

    /// The file that it is in.
    pub fn path(&self) -> &Path {
        match self {
            Self::Unfinished { path, .. }
            | Self::CutOff { path, .. }
            | Self::Unreadable { path, .. }
            | Self::PartsMissing { path, .. }
            | Self::EndMissing { path, .. } => path,
        }
    }
}

fn whole(to: Option<i64>) -> String {
    to.map_or_else(|| "no revolution is whole".to_owned(), |to| format!("all is whole up to revolution {to}"))
}

fn parts(first: u64, last: u64) -> String {
    if first == last { format!("part {first} is") } else { format!("parts {first} to {last} are") }
}
