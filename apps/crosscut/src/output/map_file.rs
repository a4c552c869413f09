//! The file of a map, which a run replaces along the flight: a run that is killed leaves the map up to a second before.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crosscut_flight::{MapDrawing, Mapper, NoPlace};
use crosscut_outfile::Keep;
use crosscut_stage::Frame;

use crate::output::{Document, maps};

/// The file is replaced this often.
const EVERY: Duration = Duration::from_secs(1);

pub(crate) struct MapFile {
    path: PathBuf,
    document: Document,
    /// What a drawing shows besides the map; `None` in the other formats.
    seen: Option<MapDrawing>,
    /// When the file was replaced last.
    replaced: Instant,
}

impl MapFile {
    /// Opens the file before the work begins.
    pub(crate) fn create(path: &Path, read: &[PathBuf]) -> anyhow::Result<Self> {
        let document = Document::create(path, read, Keep::ThroughPowerLoss)?;
        let seen = (maps::format_of(path) == "svg").then(MapDrawing::default);
        Ok(Self { path: path.to_owned(), document, seen, replaced: Instant::now() })
    }

    /// Takes the next revolution, which `mapper` and `no_place` took, and replaces the file if that is due. An error here is no
    /// error: the map may still be written at the end.
    pub(crate) fn take(&mut self, frame: &Frame, mapper: &Mapper, no_place: &NoPlace) {
        if let Some(seen) = &mut self.seen {
            seen.add(frame, mapper);
        }
        if self.document.is_file() && self.replaced.elapsed() >= EVERY {
            self.finish(mapper, no_place).ok();
            self.replaced = Instant::now();
        }
    }

    /// Writes the map of the whole flight.
    pub(crate) fn finish(&mut self, mapper: &Mapper, no_place: &NoPlace) -> anyhow::Result<()> {
        let nothing = MapDrawing::default();
        self.document.write(&maps::text(&self.path, mapper, no_place, self.seen.as_ref().unwrap_or(&nothing)))
    }
}
