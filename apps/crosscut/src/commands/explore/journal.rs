//! What the vehicle of a mission sensed, kept so that a mission that is killed can be resumed.

use std::path::Path;

use crosscut_explore::{Moment, PlannerKind, read_journal};
use crosscut_ingest::Stored;
use crosscut_pipeline::Config;
use crosscut_simulator::{DESCRIPTION, RecordingError, Scene, SceneRecorder, World};

use super::Job;
use crate::exit::UsageError;

/// At most this many revolutions are lost if the program is killed.
const FLUSH_EVERY: u64 = 10;

/// A recording of the flight that grows with the mission.
pub(super) struct Journal {
    recorder: SceneRecorder,
    failed: Option<RecordingError>,
}

impl Journal {
    pub(super) fn create(path: &Path, about: &About) -> Result<Self, RecordingError> {
        let recorder = SceneRecorder::described(path, about.values.iter().cloned().collect())?;
        Ok(Self { recorder, failed: None })
    }

    pub(super) fn add(&mut self, moment: &Moment) {
        if self.failed.is_some() {
            return;
        }
        let is_to_flush = moment.frame.revolution.seq % FLUSH_EVERY == FLUSH_EVERY - 1;
        let added = self.recorder.add(&(moment.scene)());
        self.failed = added.and_then(|()| if is_to_flush { self.recorder.flush() } else { Ok(()) }).err();
    }

    /// Ends the file, and returns the first error.
    pub(super) fn finish(self) -> Result<(), RecordingError> {
        match self.failed {
            Some(error) => Err(error),
            None => self.recorder.finish().map(|_| ()),
        }
    }
}

/// All that decides how a mission is flown, by name.
pub(super) struct About {
    values: Vec<(String, String)>,
}

impl About {
    pub(super) fn new(job: &Job, world: &World, planner: &PlannerKind, config: &Config) -> Self {
        let (tunnels, walls) = (&world.mine.network().tunnels, world.mine.surface().segments());
        let wall_m: f64 = walls.iter().map(|wall| (wall.to_m - wall.from_m).norm()).sum();
        let of_mission = [
            ("mission", job.name.clone()),
            ("seed", job.seed.to_string()),
            ("planner", planner.name.to_owned()),
            // Another plan may have the same name.
            ("mine", format!("{} tunnels with {wall_m:.3} m of wall", tunnels.len())),
        ];
        let of_mission = of_mission.map(|(name, value)| (name.to_owned(), value));
        // The pipeline's threads and memory change no result.
        let settings = config.settings().filter(|(name, _)| !name.starts_with("pipeline."));
        Self { values: of_mission.into_iter().chain(settings).collect() }
    }

    /// What was sensed in the mission of a journal, which must be this one.
    pub(super) fn past(&self, journal: &Path) -> anyhow::Result<Vec<Scene>> {
        let known = Stored::metadata(journal, DESCRIPTION)?;
        let refuse = |why: String| Err(UsageError(format!("cannot resume {}: {why}", journal.display())).into());
        if let Some((name, _)) = self.values.iter().find(|(name, _)| !known.contains_key(name)) {
            return refuse(format!("it does not state its {name}; only a journal (--journal) is resumed"));
        }
        let is_other = self.values.iter().filter(|(name, value)| known[name] != *value);
        let others: Vec<String> =
            is_other.map(|(name, value)| format!("its {name} is {}, not {value}", known[name])).collect();
        if others.is_empty() { Ok(read_journal(journal)?) } else { refuse(others.join(", ")) }
    }
}
