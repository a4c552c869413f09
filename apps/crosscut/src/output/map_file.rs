//! The file of a map. Of a flight that comes at its own pace the file is replaced along the way: a run that is killed leaves
//! the map up to a second before. Of a file that is read there is the map of all of it, or what was there before.

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
    /// When the file was replaced last; `None` if it is not before the end.
    replaced: Option<Instant>,
}

impl MapFile {
    /// Opens the file before the work begins.
    pub(crate) fn create(path: &Path, read: &[PathBuf], is_paced: bool) -> anyhow::Result<Self> {
        let document = Document::create(path, read, Keep::ThroughPowerLoss)?;
        let seen = (maps::format_of(path) == "svg").then(MapDrawing::default);
        let replaced = (is_paced && document.is_file()).then(Instant::now);
        Ok(Self { path: path.to_owned(), document, seen, replaced })
    }

    /// Takes the next revolution, which `mapper` and `no_place` took, and replaces the file if that is due. An error here is no
    /// error: the map may still be written at the end.
    pub(crate) fn take(&mut self, frame: &Frame, mapper: &Mapper, no_place: &NoPlace) {
        if let Some(seen) = &mut self.seen {
            seen.add(frame, mapper);
        }
        if self.replaced.is_some_and(|replaced| replaced.elapsed() >= EVERY) {
            self.finish(mapper, no_place).ok();
            self.replaced = Some(Instant::now());
        }
    }

    /// Writes the map of the whole flight.
    pub(crate) fn finish(&mut self, mapper: &Mapper, no_place: &NoPlace) -> anyhow::Result<()> {
        let nothing = MapDrawing::default();
        self.document.write(&maps::text(&self.path, mapper, no_place, self.seen.as_ref().unwrap_or(&nothing)))
    }
}
