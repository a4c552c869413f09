//! A file that replaces an older one only when it is complete.

use std::fs::File;
use std::hash::{BuildHasher as _, RandomState};
use std::io;
use std::path::{Path, PathBuf};

use anyhow::Context;

use crate::exit::INTERRUPTED;

/// A file that is written beside the one that it will replace. Dropped before it is finished, it is removed.
pub(crate) struct Unfinished {
    target: PathBuf,
    path: PathBuf,
}

impl Unfinished {
    /// In the folder of the target, so that a rename replaces the target. If that is a link, the linked file is replaced.
    pub(crate) fn beside(target: &Path) -> Self {
        let target = target.canonicalize().unwrap_or_else(|_| target.to_owned());
        let name = target.file_name().unwrap_or_default().to_string_lossy();
        let path = target.with_file_name(format!(".{name}.{}", unique()));
        Self { target, path }
    }

    /// Writes the target as a whole.
    pub(crate) fn write(target: &Path, contents: impl AsRef<[u8]>) -> io::Result<()> {
        let unfinished = Self::beside(target);
        std::fs::write(&unfinished.path, contents)?;
        unfinished.finish()
    }

    pub(crate) fn create(&self) -> io::Result<File> {
        File::create(&self.path)
    }

    /// Replaces the target.
    pub(crate) fn finish(self) -> io::Result<()> {
        std::fs::rename(&self.path, &self.target)
    }

    /// From now on Ctrl-C removes the file and ends the program.
    pub(crate) fn remove_on_interrupt(&self) -> anyhow::Result<()> {
        let path = self.path.clone();
        ctrlc::set_handler(move || {
            std::fs::remove_file(&path).ok(); // it may not be there yet, or finished
            std::process::exit(i32::from(INTERRUPTED));
        })
        .context("cannot listen for Ctrl-C")
    }
}

/// A part of a name that no other thread or process takes, also on another computer.
pub(crate) fn unique() -> String {
    format!("{:016x}", RandomState::new().hash_one(()))
}

impl Drop for Unfinished {
    fn drop(&mut self) {
        std::fs::remove_file(&self.path).ok(); // finished, it has another name
    }
}
