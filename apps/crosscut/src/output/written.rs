//! What a run writes beside a recording: results and the map.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crosscut_detector::Config;
use crosscut_flight::{Mapper, NoPlace};
use crosscut_report::ResultsLine;
use crosscut_stage::Frame;

use crate::diagnostics::Diagnostics;
use crate::fly::Flown;
use crate::output::answers::AnswersFile;
use crate::output::files;
use crate::output::map_file::MapFile;

/// The files that the report thread writes.
pub(crate) struct Written {
    /// `None` as well once they cannot be written.
    results: Option<Results>,
    mapper: Mapper,
    no_place: NoPlace,
    map: Option<MapFile>,
}

impl Written {
    /// Opens the files. Without the map the run continues; without results it fails. `is_paced`: the flight comes at its own pace.
    pub(crate) fn open(
        results: Option<&Path>,
        map: Option<&Path>,
        config: &Config,
        read: &[PathBuf],
        is_paced: bool,
        diagnostics: &mut Diagnostics,
    ) -> anyhow::Result<Self> {
        let results = results.map(|path| Results::create(path, config, read)).transpose()?;
        let map = map.map(|path| MapFile::create(path, read, is_paced)).transpose();
        diagnostics.lost_all(map.as_ref().err().map(|error| format!("{error:#}")));
        Ok(Self { results, mapper: Mapper::default(), no_place: NoPlace::default(), map: map.unwrap_or_default() })
    }

    /// The map so far in a line; of one without places, why it has none.
    pub(crate) fn map_summary(&self) -> String {
        let map = self.mapper.map();
        self.no_place.reason(&map).unwrap_or_else(|| map.summary())
    }

    /// The map so far.
    pub(crate) fn mapper(&self) -> &Mapper {
        &self.mapper
    }

    pub(crate) fn is_nothing(&self) -> bool {
        self.results.is_none() && self.map.is_none()
    }

    pub(crate) fn take(&mut self, frame: &Frame) -> io::Result<()> {
        self.mapper.add(frame);
        self.no_place.add(frame);
        if let Some(map) = &mut self.map {
            map.take(frame, &self.mapper, &self.no_place);
        }
        if let Some(results) = &mut self.results
            && let Err(error) = results.take(frame)
        {
            self.results = None;
            return Err(error);
        }
        Ok(())
    }

    /// Writes what is left of each file, whatever becomes of the others; nothing if there was no revolution. A map that cannot be
    /// written is a loss, and a failure if nothing else was asked for.
    ///
    /// # Errors
    /// When the results cannot be written.
    pub(crate) fn finish(
        &mut self,
        flown: &Flown,
        is_map_alone: bool,
        diagnostics: &mut Diagnostics,
    ) -> io::Result<()> {
        if flown.is_empty() {
            return Ok(());
        }
        let map = self.map.as_mut().and_then(|map| map.finish(&self.mapper, &self.no_place).err());
        match map {
            Some(error) if is_map_alone => diagnostics.error(format!("{error:#}")),
            Some(error) => diagnostics.lost(format!("{error:#}")),
            None => {}
        }
        self.results.as_mut().map_or(Ok(()), Results::finish)
    }
}

/// The file of results.
enum Results {
    Lines(Box<dyn Write + Send>),
    Mcap(Box<AnswersFile<Box<dyn Write + Send>>>),
}

impl Results {
    fn create(path: &Path, config: &Config, read: &[PathBuf]) -> anyhow::Result<Self> {
        let out = files::grow(path, read)?;
        if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("mcap")) {
            return Ok(Self::Mcap(Box::new(AnswersFile::new(out, config.sensor()))));
        }
        Ok(Self::Lines(out))
    }

    fn take(&mut self, frame: &Frame) -> io::Result<()> {
        match self {
            Self::Lines(out) => {
                let mut line = Vec::new();
                ResultsLine::of(frame).write(&mut line)?;
                out.write_all(&line)?;
                out.flush()
            }
            Self::Mcap(answers) => answers.take(frame),
        }
    }

    fn finish(&mut self) -> io::Result<()> {
        match self {
            Self::Lines(_) => Ok(()),
            Self::Mcap(answers) => answers.finish(),
        }
    }
}
