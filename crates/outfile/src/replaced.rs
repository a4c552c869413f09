//! A file that is written again and again, each time as a whole.

use std::io::{self, Write as _};
use std::path::Path;

use crate::Keep;
use crate::part::Part;

/// A file that is held as long as this value is there, and is complete at any time.
pub struct Replaced {
    part: Part,
}

impl Replaced {
    /// Holds the file: a second program is refused. What is there stays until it is replaced.
    ///
    /// # Errors
    /// When it cannot be written, or another program writes to it.
    pub fn create(path: &Path, keep: Keep) -> io::Result<Self> {
        Ok(Self { part: Part::create(path, keep)? })
    }

    /// Other than a pipe or a device, of which everything that is ever written is read.
    pub fn is_file(&self) -> bool {
        self.part.is_file()
    }

    /// Writes the whole file.
    ///
    /// # Errors
    /// When it cannot be written; what was there is then still there.
    pub fn replace(&mut self, contents: impl AsRef<[u8]>) -> io::Result<()> {
        if self.part.is_file() {
            if self.part.path().is_none() {
                self.part = self.part.next()?;
            }
            self.part.cut(0)?; // the last attempt may have failed
        }
        self.part.file().write_all(contents.as_ref())?;
        self.part.take_name()
    }
}
