//! The one way to write a file.
//!
//! A file is written by one program at a time: a second one is refused with [`BUSY`]. Its bytes go into a part file beside
//! it (`.NAME.part`), which takes its name when there is something worth having, so that an older file of that name is
//! there until then. When that is, is the choice between
//!
//! - [`Whole`], for a file that is of use only when it is complete: a picture, a converted recording;
//! - [`Replaced`], for a file that is written again and again, each time as a whole: the map of a flight on its way;
//! - [`Growing`], for a file that is of use from its first line on, and whose written part survives a kill: results,
//!   recordings, journals.
//!
//! [`Keep::ThroughPowerLoss`] is for what a robot writes. A program that is killed leaves a part file behind, which the
//! next one that writes to the name takes over. Pipes and devices are written to directly.

mod growing;
mod part;
mod replaced;
mod whole;

use std::io::{self, Write as _};
use std::path::Path;

pub use growing::Growing;
pub use part::BUSY;
pub use replaced::Replaced;
pub use whole::Whole;

/// What a file that was written outlasts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Keep {
    /// The end of the program, also a sudden one. The operating system writes it to the disk within half a minute.
    ThroughKill,
    /// A loss of power, up to a second before.
    ThroughPowerLoss,
}

/// Writes a whole file.
///
/// # Errors
/// When it cannot be written, or another program writes to it; what was there is then still there.
pub fn write(path: &Path, contents: impl AsRef<[u8]>) -> io::Result<()> {
    let mut whole = Whole::create(path, Keep::ThroughKill)?;
    whole.write_all(contents.as_ref())?;
    whole.finish()
}
