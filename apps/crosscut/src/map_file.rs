//! The file of a map, which a run replaces along the flight: a run that is killed leaves the map up to a second before.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::Context;
use crosscut_flight::Mapper;

use crate::unfinished::Unfinished;
use crate::{maps, outputs};

/// The file is replaced this often.
const EVERY: Duration = Duration::from_secs(1);

pub(crate) struct MapFile {
    path: PathBuf,
    /// Other than a pipe or standard output.
    is_file: bool,
    /// Holds the file, so that no other run writes to it.
    out: Box<dyn Write + Send>,
    /// When the file was replaced last.
    replaced: Instant,
}

impl MapFile {
    /// Opens the file before the work begins.
    pub(crate) fn create(path: &Path, read: &[PathBuf]) -> anyhow::Result<Self> {
        let out = outputs::create(path, read)?;
        Ok(Self { path: path.to_owned(), is_file: path.is_file(), out, replaced: Instant::now() })
    }

    /// Replaces the file if that is due. An error here is no error: the map may still be written at the end.
    pub(crate) fn update(&mut self, mapper: &Mapper) {
        if self.is_file && self.replaced.elapsed() >= EVERY {
            self.replace(mapper).ok();
            self.replaced = Instant::now();
        }
    }

    /// Writes the map of the whole flight.
    pub(crate) fn finish(&mut self, mapper: &Mapper) -> anyhow::Result<()> {
        let written = if self.is_file {
            self.replace(mapper)
        } else {
            self.out.write_all(maps::text(&self.path, mapper).as_bytes()).and_then(|()| self.out.flush())
        };
        written.with_context(|| format!("cannot write {}", self.path.display()))
    }

    /// Under another name first, so that the file is never half a map.
    fn replace(&mut self, mapper: &Mapper) -> io::Result<()> {
        let unfinished = Unfinished::beside(&self.path);
        unfinished.create()?.write_all(maps::text(&self.path, mapper).as_bytes())?;
        self.out = Box::new(io::sink()); // the file that was held is another one from now on
        unfinished.finish()?;
        if let Ok(out) = outputs::create(&self.path, &[]) {
            self.out = out;
        }
        Ok(())
    }
}
