//! What the vehicle of a mission sensed, kept so that a mission that is killed can be resumed.

use std::path::Path;

use crosscut_explore::Moment;
use crosscut_simulator::{RecordingError, SceneRecorder};

/// At most this many revolutions are lost if the program is killed.
const FLUSH_EVERY: u64 = 10;

/// A recording of the flight that grows with the mission.
pub(super) struct Journal {
    recorder: SceneRecorder,
    failed: Option<RecordingError>,
}

impl Journal {
    pub(super) fn create(path: &Path) -> Result<Self, RecordingError> {
        Ok(Self { recorder: SceneRecorder::create(path)?, failed: None })
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
