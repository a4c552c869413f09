//! The file of a map, which a run replaces along the flight: a run that is killed leaves the map up to a second before.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crosscut_flight::Mapper;
use crosscut_outfile::Keep;

use crate::maps;
use crate::outputs::Document;

/// The file is replaced this often.
const EVERY: Duration = Duration::from_secs(1);

pub(crate) struct MapFile {
    path: PathBuf,
    document: Document,
    /// When the file was replaced last.
    replaced: Instant,
}

impl MapFile {
    /// Opens the file before the work begins.
    pub(crate) fn create(path: &Path, read: &[PathBuf]) -> anyhow::Result<Self> {
        let document = Document::create(path, read, Keep::ThroughPowerLoss)?;
        Ok(Self { path: path.to_owned(), document, replaced: Instant::now() })
    }

    /// Replaces the file if that is due. An error here is no error: the map may still be written at the end.
    pub(crate) fn update(&mut self, mapper: &Mapper) {
        if self.document.is_file() && self.replaced.elapsed() >= EVERY {
            self.finish(mapper).ok();
            self.replaced = Instant::now();
        }
    }

    /// Writes the map of the whole flight.
    pub(crate) fn finish(&mut self, mapper: &Mapper) -> anyhow::Result<()> {
        self.document.write(&maps::text(&self.path, mapper))
    }
}
