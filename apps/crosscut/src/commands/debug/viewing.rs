//! The viewer beside the prompt.

use crosscut_debugger::Session;
use crosscut_detector::Config;
use crosscut_messages::Truth;
use crosscut_recorder::{Answered, Beside, DebugView, RecorderError, RecorderOptions, TrueWalls};
use crosscut_stage::Frame;

use crate::output::observers::recorder_options;

/// A viewer that shows what a session stands at.
pub(super) struct Viewing {
    view: DebugView,
    name: String,
    /// The flight and its preset.
    source: String,
    /// What is shown.
    version: Option<u64>,
    /// What is shown beside it: which revolution of what was held.
    held: Option<[u64; 2]>,
}

impl Viewing {
    /// Starts a viewer for the flight of this name.
    pub(super) fn open(name: &str, preset: &str) -> Result<Self, RecorderError> {
        let source = format!("{name}, {preset}");
        Ok(Self { view: DebugView::open()?, name: name.to_owned(), source, version: None, held: None })
    }

    /// Shows what the session stands at, unless that is shown.
    ///
    /// # Errors
    /// When the viewer was closed.
    pub(super) fn follow(&mut self, session: &Session) -> Result<(), RecorderError> {
        let version = Some(session.version());
        if self.version == version {
            return Ok(());
        }
        let now = self.answered(session, session.frame(), session.config());
        let held = session.held_frame().map(|frame| [frame.revolution.seq, session.holds()]);
        let beside = match session.held_frame().zip(session.held_config()) {
            None => Beside::Nothing,
            Some(_) if held == self.held => Beside::Same,
            Some((frame, config)) => Beside::Other(Box::new(self.answered(session, frame, config))),
        };
        self.view.show(now, beside)?;
        (self.version, self.held) = (version, held);
        Ok(())
    }

    /// Waits until everything is shown.
    ///
    /// # Errors
    /// When the viewer was closed.
    pub(super) fn end(self) -> Result<(), RecorderError> {
        self.view.end()
    }

    fn answered<'a>(&self, session: &Session, frame: &'a Frame, config: &Config) -> Answered<'a> {
        let truth = TrueWalls::default();
        if let Some(of) = session.truth() {
            tell(&truth, frame.revolution.seq, of);
        }
        let changed: String =
            session.differing(config).iter().map(|[key, _, value]| format!(", {key}={value}")).collect();
        let source = format!("{}{changed}", self.source);
        (frame, RecorderOptions { source, truth, ..recorder_options(self.name.clone(), config) })
    }
}

/// Tells a recorder the truth of a revolution.
pub(super) fn tell(truths: &TrueWalls, seq: u64, truth: &Truth) {
    truths.tell(seq, truth.walls as usize, String::from_utf8(truth.to_json()).unwrap_or_default());
}
