//! Recordings read back: values by entity and revolution, as numbers and words.
//!
//! [`Recording::open`] goes through the file once and notes where the chunks of each entity lie; [`Recording::rows`]
//! then loads one chunk after the other, so that memory stays small whatever the size of the file. Rows come by
//! revolution, however the writer cut them into chunks and files: those that a long recording goes on in are found
//! beside the first. A file that was cut off or damaged is read as far as it goes: [`Recording::damages`] says what is
//! missing.
//!
//! ```no_run
//! use crosscut_recorder::{ReadError, Recording, Value};
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

mod difference;
pub(crate) mod messages;
mod picture;
mod recording;
mod rows;
mod span;
mod value;

use std::path::PathBuf;

pub use difference::{Difference, Differences, differences};
pub use recording::{Component, Entity, Recording, is_picture};
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
    /// The recording has no such entity.
    #[error("the recording has no entity {entity}; there are {}", near.join(", "))]
    NoSuchEntity {
        /// What was asked for.
        entity: String,
        /// What there is of the same step; all there is if nothing is.
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

/// What a recording lacks. Everything else of it is read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Damage {
    /// The file ends with a whole message, but not as a finished recording does.
    #[error("ends without its footer, after {bytes} bytes: what wrote it was stopped: {}", path.display())]
    Unfinished {
        /// Which file.
        path: PathBuf,
        /// Its length.
        bytes: u64,
    },
    /// The file ends in the middle of a message.
    #[error("cut off in the message at byte {at} of {bytes}: {}", path.display())]
    CutOff {
        /// Which file.
        path: PathBuf,
        /// Where the message starts.
        at: u64,
        /// Length of the file.
        bytes: u64,
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
    #[error("part {part}, in which the recording goes on, is missing: {}", path.display())]
    EndMissing {
        /// The file that was opened.
        path: PathBuf,
        /// The part that would follow.
        part: u64,
    },
}

fn parts(first: u64, last: u64) -> String {
    if first == last { format!("part {first} is") } else { format!("parts {first} to {last} are") }
}
