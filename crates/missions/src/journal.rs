//! What the vehicle of a mission sensed, kept so that a mission that is killed can be resumed.

use std::path::Path;

use crosscut_detector::Config;
use crosscut_ingest::Stored;
use crosscut_navigate::PlannerKind;
use crosscut_simulator::{DESCRIPTION, RecordingError, Scene, SceneRecorder, World};

use crate::{Moment, ResumeError, read_journal};

/// At most this many revolutions are lost if the program is killed.
const FLUSH_EVERY: u64 = 10;

/// A recording of the flight that grows with the mission.
pub struct Journal {
    recorder: SceneRecorder,
    failed: Option<RecordingError>,
}

impl Journal {
    /// Begins a journal in a new file.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn create(path: &Path, about: &About) -> Result<Self, RecordingError> {
        let recorder = SceneRecorder::described(path, about.values.iter().cloned().collect())?;
        Ok(Self { recorder, failed: None })
    }

    /// Keeps a revolution. After a failure it does nothing.
    pub fn add(&mut self, moment: &Moment) {
        if self.failed.is_some() {
            return;
        }
        let is_to_flush = moment.frame.revolution.seq % FLUSH_EVERY == FLUSH_EVERY - 1;
        let added = self.recorder.add(&(moment.scene)());
        self.failed = added.and_then(|()| if is_to_flush { self.recorder.flush() } else { Ok(()) }).err();
    }

    /// Ends the file.
    ///
    /// # Errors
    /// The first that occurred while writing.
    pub fn finish(self) -> Result<(), RecordingError> {
        match self.failed {
            Some(error) => Err(error),
            None => self.recorder.finish().map(|_| ()),
        }
    }
}

/// All that decides how a mission is flown, by name.
pub struct About {
    values: Vec<(String, String)>,
}

impl About {
    /// The mission that is flown in a world of this name and seed, with a planner and a configuration.
    pub fn new(name: &str, seed: u64, world: &World, planner: &PlannerKind, config: &Config) -> Self {
        let (tunnels, walls) = (&world.mine.network().tunnels, world.mine.surface().segments());
        let wall_m: f64 = walls.iter().map(|wall| (wall.to_m - wall.from_m).norm()).sum();
        let start_m = world.start.position_m;
        let of_mission = [
            ("mission", name.to_owned()),
            ("seed", seed.to_string()),
            ("planner", planner.name.to_owned()),
            // Another plan may have the same name.
            ("mine", format!("{} tunnels with {wall_m:.3} m of wall", tunnels.len())),
            (
                "start",
                format!("x {:.3} m, y {:.3} m, heading {:.3} rad", start_m.x, start_m.y, world.start.heading_rad),
            ),
        ];
        let of_mission = of_mission.map(|(name, value)| (name.to_owned(), value));
        // The pipeline's threads and memory change no result.
        let settings = config.settings().filter(|(name, _)| !name.starts_with("pipeline."));
        Self { values: of_mission.into_iter().chain(settings).collect() }
    }

    /// What was sensed in the mission of a journal.
    ///
    /// # Errors
    /// When the journal cannot be read, or is that of another mission.
    pub fn past(&self, journal: &Path) -> Result<Vec<Scene>, ResumeError> {
        let known = Stored::metadata(journal, DESCRIPTION)?;
        let refuse = |why: String| Err(ResumeError::OtherMission { journal: journal.to_owned(), why });
        if let Some((name, _)) = self.values.iter().find(|(name, _)| !known.contains_key(name)) {
            return refuse(format!("it does not state its {name}; only a journal (--journal) is resumed"));
        }
        let is_other = self.values.iter().filter(|(name, value)| known[name] != *value);
        let others: Vec<String> =
            is_other.map(|(name, value)| format!("its {name} is {}, not {value}", known[name])).collect();
        if others.is_empty() { Ok(read_journal(journal)?) } else { refuse(others.join(", ")) }
    }
}
