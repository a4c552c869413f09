//! Where a recording goes: into a file, through a pipe, to viewers; and what happens when one of them fails.

use std::path::Path;
use std::time::Duration;

use crosscut_stage::Frame;
use rerun::external::re_log_types::ApplicationId;
use rerun::log::ChunkBatcherConfig;
use rerun::sink::LogSink;
use rerun::{RecordingStream, RecordingStreamBuilder};

use crate::backlog::{Backlog, Lost, Room};
use crate::file::RrdFile;
use crate::live::{Live, Outlet};
use crate::options::{RecorderError, RecorderOptions, StoreIds};
use crate::piped::PipeSink;
use crate::rows::Rows;
use crate::scope::Share;
use crate::serving::{self, Served};
use crate::viewer;

/// Bytes of waiting rows after which they are sent, which bounds the memory.
pub(crate) const SEND_AFTER_BYTES: usize = 16 << 20;
/// Time between two flushes to a viewer. Half of it would double the file.
const LIVE_TICK: Duration = Duration::from_millis(500);

/// The outputs of a recording.
pub(crate) struct Outputs {
    rec: RecordingStream,
    file: Option<RrdFile>,
    /// Why the file was given up, if viewers are still served.
    file_lost: Option<RecorderError>,
    pipe: Option<PipeSink>,
    live: Vec<Live>,
    served: Option<Served>,
    /// Only of a live flight.
    backlog: Option<Backlog>,
    /// Rows are shown between two flushes.
    pub(crate) at_once: bool,
}

/// Outputs that no option names.
#[derive(Default)]
pub(crate) struct Further {
    pub(crate) pipe: Option<PipeSink>,
    pub(crate) sink: Option<Box<dyn LogSink>>,
}

impl Outputs {
    /// Opens all of them. The viewer comes before the file: if there is no viewer, an older file is kept.
    pub(crate) fn open(options: &RecorderOptions, further: Further) -> Result<Self, RecorderError> {
        let Further { pipe, sink } = further;
        if !rerun::decide_logging_enabled(true) {
            return Err(RecorderError::Disabled);
        }
        let mut live = Vec::new();
        let mut served = None;
        if options.view {
            live.push(Live::start(Outlet::Viewer(viewer::connect("rerun")?))?);
        }
        if let Some(address) = options.serve {
            let server = serving::open(address)?;
            served = Some(server.served.clone());
            live.push(Live::start(Outlet::Server(server))?);
        }
        let file = options.path.as_deref().map(RrdFile::create).transpose()?;
        let at_once = !live.is_empty() || sink.is_some();
        let mut sinks: Vec<Box<dyn LogSink>> = Vec::new();
        sinks.extend(sink);
        sinks.extend(file.clone().map(|file| Box::new(file) as Box<dyn LogSink>));
        sinks.extend(pipe.clone().map(|pipe| Box::new(pipe) as Box<dyn LogSink>));
        sinks.extend(live.iter().map(|live| Box::new(live.sink()) as Box<dyn LogSink>));
        let backlog = options.live.then(Backlog::default);
        sinks.extend(backlog.iter().map(|backlog| Box::new(backlog.sink()) as Box<dyn LogSink>)); // behind the file
        let batches = ChunkBatcherConfig {
            flush_tick: if at_once { LIVE_TICK } else { Duration::MAX },
            flush_num_bytes: SEND_AFTER_BYTES as u64,
            ..ChunkBatcherConfig::DEFAULT
        };
        let rec = builder(options.ids.as_ref())
            .recording_name(options.name.clone())
            .recording_started(0) // until the first revolution says when
            .batcher_config(batches)
            .set_sinks(sinks)?;
        rec.set_log_time_enabled(false); // a recording depends on the flight, not on when it was made
        rec.set_log_tick_enabled(false);
        Ok(Self { rec, file, file_lost: None, pipe, live, served, backlog, at_once })
    }

    /// What is logged there goes to all of them.
    pub(crate) fn stream(&self) -> &RecordingStream {
        &self.rec
    }

    pub(crate) fn served(&self) -> Option<&Served> {
        self.served.as_ref()
    }

    /// How much of a revolution there is room for, and what is to be said about it: a live flight does not wait for its disk.
    pub(crate) fn room_for(&mut self, frame: &Frame, share: Share) -> (Room, Option<String>) {
        self.backlog.as_mut().map_or((Room::All, None), |backlog| backlog.room_for(frame, share))
    }

    /// Whether the disk has taken everything.
    pub(crate) fn is_clear(&self) -> bool {
        self.backlog.as_ref().is_none_or(Backlog::is_clear)
    }

    pub(crate) fn wants_flush(&self) -> bool {
        self.backlog.as_ref().is_some_and(Backlog::wants_flush)
    }

    /// Flushes all rows to the disk. It does not wait for viewers, nor for the disk during a live flight.
    ///
    /// # Errors
    /// When a write has failed.
    pub(crate) fn flush(&mut self, rows: &mut Rows) -> Result<(), RecorderError> {
        let Some(backlog) = &mut self.backlog else { return self.flush_to_the_end(rows) };
        rows.send()?;
        backlog.flush_asked();
        let asked = self.rec.flush_async();
        self.check_file()?;
        asked.map_err(|e| RecorderError::Viewer(e.to_string()))
    }

    /// Flushes all rows, and waits for the disk.
    pub(crate) fn flush_to_the_end(&mut self, rows: &mut Rows) -> Result<(), RecorderError> {
        rows.send()?;
        self.backlog.iter_mut().for_each(Backlog::flush_asked);
        let flushed = self.rec.flush_blocking();
        self.check_file()?;
        flushed.map_err(|e| RecorderError::Viewer(e.to_string()))
    }

    /// Whether the file is still written.
    pub(crate) fn has_file(&self) -> bool {
        self.file.is_some()
    }

    /// Ends the file, whose rows must have been flushed, and continues in another one.
    pub(crate) fn continue_in(&mut self, next: &Path) -> Result<(), RecorderError> {
        match self.file.as_ref().map(|file| file.continue_in(next)) {
            Some(Err(error)) => self.give_up_file(error),
            _ => Ok(()),
        }
    }

    fn check_file(&mut self) -> Result<(), RecorderError> {
        match self.file.as_ref().map(RrdFile::check) {
            Some(Err(error)) => self.give_up_file(error),
            _ => Ok(()),
        }
    }

    /// With viewers the flight continues without the file, whose error is kept for the end.
    fn give_up_file(&mut self, error: RecorderError) -> Result<(), RecorderError> {
        if self.live.is_empty() {
            return Err(error);
        }
        self.file = None;
        self.file_lost = Some(error);
        Ok(())
    }

    /// Ends the file and each viewer, even if others fail. What became of each, and what the disk was too slow for.
    pub(crate) fn end(&mut self) -> Vec<Result<(), RecorderError>> {
        let mut ends: Vec<_> = self.file_lost.take().map(Err).into_iter().collect();
        ends.extend(self.file.as_ref().map(RrdFile::end));
        ends.extend(self.pipe.as_ref().map(PipeSink::end));
        ends.extend(self.live.iter().map(Live::end));
        let lost = self.backlog.as_ref().and_then(Backlog::lost);
        ends.extend(lost.map(|Lost { thinned, left_out }| Err(RecorderError::DiskTooSlow { thinned, left_out })));
        ends
    }
}

/// A recording of its own, or a part of that with these ids.
fn builder(ids: Option<&StoreIds>) -> RecordingStreamBuilder {
    match ids {
        None => RecordingStreamBuilder::new("crosscut"),
        // Given an id, Rerun takes the name and the start of the recording to be known.
        Some(StoreIds { application, recording }) => {
            let application = ApplicationId::new_or_unknown(application.as_str());
            RecordingStreamBuilder::new(application).recording_id(recording.as_str()).send_properties(true)
        }
    }
}
