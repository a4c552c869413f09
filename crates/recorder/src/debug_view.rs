//! The native viewer beside a debugger: the stages of one revolution, of the one that was shown last, and beside them those
//! of the same revolution by other settings.
//!
//! Each revolution that is shown is the next moment of the timeline `command`, which the viewer follows; so the earlier
//! ones can be looked at again.

use crosscut_stage::Frame;

use crate::RecorderError;
use crate::below::Below;
use crate::layout::{self, Extent, Shown, Side};
use crate::live::{Live, Outlet};
use crate::options::{RecorderOptions, StoreIds};
use crate::recorder::Recorder;
use crate::{Scope, viewer};

/// Where the present answer stands, and what is held beside it.
const NOW: &str = "now";
const HELD: &str = "A";

/// A revolution with what the stages made of it. Of the options, all that concern files and viewers is passed over.
pub type Answered<'a> = (&'a Frame, RecorderOptions);

/// What is shown beside a revolution.
pub enum Beside<'a> {
    /// Nothing.
    Nothing,
    /// What was shown beside the one before.
    Same,
    /// That revolution, answered with other settings.
    Other(Box<Answered<'a>>),
}

/// The native viewer beside a debugger.
pub struct DebugView {
    live: Live,
    ids: StoreIds,
    now: Option<Recorder>,
    held: Option<Recorder>,
    /// What the layout was made for.
    laid_out: Option<LaidOut>,
    /// Revolutions shown so far.
    shown: i64,
}

/// The layout changes with this: whether there are two sides, and of each whether gaps decide and the number of beams.
type LaidOut = [Option<(usize, [bool; 2])>; 2];

impl DebugView {
    /// Connects to the native viewer; starts one unless one is open. Ctrl-C does not reach it.
    ///
    /// # Errors
    /// When there is none.
    pub fn open() -> Result<Self, RecorderError> {
        let live = Live::start(Outlet::Viewer(viewer::connect("rerun")?))?;
        // Layouts belong to an application: that of flights stays as it is.
        let application = "crosscut-debug".to_owned();
        let ids = StoreIds { application, recording: format!("debug-{}", std::process::id()) };
        Ok(Self { live, ids, now: None, held: None, laid_out: None, shown: 0 })
    }

    /// Shows a revolution.
    ///
    /// # Errors
    /// When the viewer was closed.
    pub fn show(&mut self, now: Answered, beside: Beside) -> Result<(), RecorderError> {
        if !self.live.is_open() {
            return Err(RecorderError::Viewer("it was closed".to_owned()));
        }
        self.shown += 1;
        let mut of_now = match self.now.take() {
            Some(recorder) => recorder,
            None => self.recorder(NOW, now.1.clone())?,
        };
        match beside {
            Beside::Nothing => self.held = None,
            Beside::Same => {}
            Beside::Other(answered) => {
                let (frame, options) = *answered;
                let mut of_held = match self.held.take() {
                    Some(recorder) => recorder,
                    None => self.recorder(HELD, options.clone())?.seeing_as(&of_now),
                };
                of_held.show(frame, options, self.shown)?;
                self.held = Some(of_held);
            }
        }
        if let Some(of_held) = &self.held {
            of_now.colour_as(of_held);
        }
        of_now.show(now.0, now.1, self.shown)?;
        self.lay_out(&of_now)?;
        self.now = Some(of_now);
        Ok(())
    }

    /// Waits until the viewer has everything. It stays open.
    ///
    /// # Errors
    /// When it was closed, or reads no more.
    pub fn end(self) -> Result<(), RecorderError> {
        self.live.end()
    }

    fn recorder(&self, below: &str, options: RecorderOptions) -> Result<Recorder, RecorderError> {
        let sink = Below { path: below.into(), sink: Box::new(self.live.sink()) };
        let options = RecorderOptions { ids: Some(self.ids.clone()), scope: Scope::default(), ..options };
        Recorder::beside(options, Box::new(sink))
    }

    fn lay_out(&mut self, now: &Recorder) -> Result<(), RecorderError> {
        let extents = [self.held.as_ref().map(Recorder::extent), Some(now.extent())];
        let asks = extents.map(|extent| extent.map(Extent::asks));
        if self.laid_out.replace(asks) == Some(asks) {
            return Ok(());
        }
        let side = |below, name, extent| Side { below, name, extent };
        let held = extents[0].map(|extent| side(HELD, HELD, extent));
        let now_is = if held.is_some() { NOW } else { "" };
        layout::send(now.stream(), &Shown::Debug { held, now: side(NOW, now_is, now.extent()) })?;
        Ok(())
    }
}
