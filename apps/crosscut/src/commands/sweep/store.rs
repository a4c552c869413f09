//! What a sweep has computed, one file for each flight and combination, under a name that holds for its input, settings and
//! program alone.

use std::io;
use std::path::{Path, PathBuf};
use std::thread::sleep;
use std::time::{Duration, Instant};

use anyhow::Context;
use serde_json::Value;

use crate::text_file;

/// Another sweep has this long to write a file that both write.
const PATIENCE: Duration = Duration::from_secs(5);
const PAUSE: Duration = Duration::from_millis(10);

/// The folder with the files.
pub(super) struct Store {
    folder: PathBuf,
}

impl Store {
    pub(super) fn open(folder: PathBuf) -> anyhow::Result<Self> {
        std::fs::create_dir_all(&folder).with_context(|| format!("cannot make the folder {}", folder.display()))?;
        Ok(Self { folder })
    }

    /// What was computed under this name; `None` if nothing was, or it is damaged.
    pub(super) fn get(&self, name: &str) -> Option<Value> {
        serde_json::from_str(&text_file::read(&self.path(name)).ok()?).ok()
    }

    /// Keeps what was computed. A file is there as a whole or not at all.
    pub(super) fn put(&self, name: &str, row: &Value) -> anyhow::Result<()> {
        let path = self.path(name);
        write(&path, format!("{row}\n")).with_context(|| format!("cannot write {}", path.display()))
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.join(format!("{name}.json"))
    }
}

/// Writes a whole file. Another sweep may be writing the same answers to it: it is done soon.
pub(super) fn write(path: &Path, text: String) -> io::Result<()> {
    let begun = Instant::now();
    loop {
        match crosscut_outfile::write(path, &text) {
            Err(error) if error.kind() == io::ErrorKind::ResourceBusy && begun.elapsed() < PATIENCE => sleep(PAUSE),
            written => return written,
        }
    }
}
