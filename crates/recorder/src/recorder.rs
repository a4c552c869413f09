//! The observer: what is logged of each revolution, when it is flushed, and what happens when that fails.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use crosscut_explain::Watch;
use crosscut_rrd::parts::part_path;
use crosscut_stage::{Frame, Observer, ObserverError};
use rerun::log::ChunkBatcherConfig;
use rerun::sink::LogSink;
use rerun::{Clear, MediaType, RecordingStream, RecordingStreamBuilder, TextDocument};
use rerun::{TextLog, TextLogLevel};

use crate::backlog::{Backlog, Lost, Room};
use crate::beam_order::BeamOrder;
use crate::colors::annotation_context;
use crate::file::RrdFile;
use crate::layout::{Extent, Shown};
use crate::live::{Live, Outlet};
use crate::matrices::Pictures;
use crate::notes::Notes;
use crate::options::{RecorderError, RecorderOptions};
use crate::parts;
use crate::scan::BeamGeometry;
use crate::scope::{Plan, Share};
use crate::serving::{self, Served};
use crate::timing::Times;
use crate::tracks::Tracks;
use crate::{exact, layout, matrices, mounting, partition, profile, report, scan, spectrum, timing, viewer, why};

/// What is on the disk never lags behind by more than this much sensor time: each flush costs the description of every
/// entity's columns...
const FLUSH_AFTER_NS: u64 = 2_500_000_000;
/// ...and less in a live flight, which cannot be flown again...
const FLUSH_LIVE_AFTER_NS: u64 = 1_000_000_000;
/// ...nor by more revolutions than this, whatever the stamps say.
const FLUSH_AFTER_REVOLUTIONS: u32 = 64;
/// Chunks are made by these rules alone, so that equal flights make equal chunks; memory stays bounded all the same.
const FLUSH_AFTER_BYTES: u64 = 16 << 20;
/// A viewer wants to see things soon; sooner still would double the file.
const LIVE_TICK: Duration = Duration::from_millis(500);

/// Records every frame that it sees.
pub struct Recorder {
    rec: RecordingStream,
    file: Option<RrdFile>,
    /// Why there is no file any more, while viewers go on.
    file_lost: Option<RecorderError>,
    live: Vec<Live>,
    served: Option<Served>,
    /// Of a live flight.
    backlog: Option<Backlog>,
    options: RecorderOptions,
    /// What the views have to reach; set when the layout was sent.
    extent: Option<Extent>,
    /// The part being written, from 1.
    part: u64,
    /// The number in the name of its file: greater where a recording of its own is called like a part.
    file_number: u64,
    /// A new part is begun as soon as that does not hold up a live flight.
    part_is_due: bool,
    plan: Plan,
    /// Revolutions that the plan has a share of.
    recorded: Arc<AtomicU64>,
    tracks: Tracks,
    watch: Watch,
    times: Times,
    notes: Notes,
    beams: BeamGeometry,
    pictures: Pictures,
    flushed_stamp_ns: u64,
    unflushed: u32,
}

impl Recorder {
    /// Opens the file and the viewer, and writes what holds for the whole recording.
    ///
    /// # Errors
    /// When the file cannot be created, there is no viewer to show it, or the environment turns recordings off.
    pub fn new(options: RecorderOptions) -> Result<Self, RecorderError> {
        if !rerun::decide_logging_enabled(true) {
            return Err(RecorderError::Disabled);
        }
        let mut live = Vec::new();
        let mut served = None;
        // First of all: without a viewer, no older file is lost.
        if options.view {
            live.push(Live::start(Outlet::Viewer(viewer::connect("rerun")?))?);
        }
        if let Some(address) = options.serve {
            let server = serving::open(address)?;
            served = Some(server.served.clone());
            live.push(Live::start(Outlet::Server(server))?);
        }
        let file = options.path.as_deref().map(RrdFile::create).transpose()?;
        let mut sinks: Vec<Box<dyn LogSink>> = Vec::new();
        sinks.extend(file.clone().map(|file| Box::new(file) as Box<dyn LogSink>));
        sinks.extend(live.iter().map(|live| Box::new(live.sink()) as Box<dyn LogSink>));
        let backlog = options.live.then(Backlog::default);
        sinks.extend(backlog.iter().map(|backlog| Box::new(backlog.sink()) as Box<dyn LogSink>)); // behind the file
        let batches = ChunkBatcherConfig {
            flush_tick: if live.is_empty() { Duration::MAX } else { LIVE_TICK },
            flush_num_bytes: FLUSH_AFTER_BYTES,
            ..ChunkBatcherConfig::DEFAULT
        };
        let rec = RecordingStreamBuilder::new("crosscut")
            .recording_name(options.name.clone())
            .recording_started(0) // until the first revolution says when
            .batcher_config(batches)
            .set_sinks(sinks)?;
        rec.set_log_time_enabled(false); // a recording depends on the flight, not on when it was made
        rec.set_log_tick_enabled(false);
        log_static(&rec, &options.config_toml)?;
        Ok(Self {
            rec,
            file,
            file_lost: None,
            live,
            served,
            backlog,
            extent: None,
            part: 1,
            file_number: 1,
            part_is_due: false,
            plan: Plan::new(options.scope.clone()),
            options,
            recorded: Arc::default(),
            tracks: Tracks::default(),
            watch: Watch::default(),
            times: Times::default(),
            notes: Notes::default(),
            beams: BeamGeometry::default(),
            pictures: Pictures::default(),
            flushed_stamp_ns: 0,
            unflushed: 0,
        })
    }

    /// Where viewers can connect, if the recording is served.
    pub fn served(&self) -> Option<&Served> {
        self.served.as_ref()
    }

    /// How many revolutions lay within what is to be recorded; to be read when the flight is over and has taken the
    /// recorder with it.
    pub fn recorded(&self) -> Arc<AtomicU64> {
        Arc::clone(&self.recorded)
    }

    fn record(&mut self, frame: &Frame) -> Result<(), RecorderError> {
        let Some(mut share) = self.plan.share_of(frame) else { return Ok(()) };
        self.recorded.fetch_add(1, Ordering::Relaxed);
        let revolution = &frame.revolution;
        self.part_is_due |= share.new_part;
        let begins_part = self.part_is_due && self.backlog.as_ref().is_none_or(Backlog::is_clear);
        if begins_part {
            self.begin_part()?;
        }
        self.rec.set_time_sequence("revolution", revolution.seq.cast_signed());
        self.rec.set_timestamp_nanos_since_epoch("stamp", revolution.stamp_ns.cast_signed());
        if begins_part || self.extent.is_none() {
            parts::log(&self.rec, self.part, false)?;
            mounting::log(&self.rec, self.options.mounting, &revolution.frame_id)?;
        }
        if self.extent.is_none() {
            self.send_layout(Extent::of(frame))?;
            self.rec.send_recording_start_time(revolution.stamp_ns.cast_signed())?;
            self.flushed_stamp_ns = revolution.stamp_ns;
        }
        let is_room = self.make_room(frame, &mut share)?;
        match &frame.failure {
            None if is_room => self.log(frame, share)?,
            None => {}
            Some(failure) => self.log_failure(&failure.to_string())?,
        }
        self.unflushed += 1;
        let unflushed_ns = revolution.stamp_ns.abs_diff(self.flushed_stamp_ns);
        let flush_after_ns = if self.options.live { FLUSH_LIVE_AFTER_NS } else { FLUSH_AFTER_NS };
        let is_due = unflushed_ns >= flush_after_ns || self.unflushed >= FLUSH_AFTER_REVOLUTIONS;
        if is_due || self.backlog.as_ref().is_some_and(Backlog::wants_flush) {
            self.flush()?;
            self.flushed_stamp_ns = revolution.stamp_ns;
        }
        Ok(())
    }

    /// Takes from `share` what a live flight's disk is too slow for, and says so; `false` if there is no room at all.
    fn make_room(&mut self, frame: &Frame, share: &mut Share) -> Result<bool, RecorderError> {
        let Some(backlog) = &mut self.backlog else { return Ok(true) };
        let (room, said) = backlog.room_for(frame, *share);
        if let Some(said) = said {
            self.rec.log("log", &TextLog::new(said).with_level(TextLogLevel::WARN))?;
        }
        if room == Room::NoMatrices {
            (share.matrices, share.exact) = (false, false);
            self.pictures.log_dark(&self.rec)?;
            for entity in ["affinity/degrees", "affinity/links", "spectral/U", "spectral/embedding"] {
                self.rec.log(entity, &Clear::flat())?; // nothing stale stays on the screen
            }
        }
        Ok(room != Room::Nothing)
    }

    /// Ends the file and goes on in another one, which can be opened alone: what never changes is written again.
    fn begin_part(&mut self) -> Result<(), RecorderError> {
        self.part_is_due = false;
        let (Some(file), Some(first)) = (self.file.clone(), &self.options.path) else { return Ok(()) };
        self.file_number = parts::next_free(first, self.file_number);
        let next = part_path(first, self.file_number);
        parts::log(&self.rec, self.part, true)?;
        self.flush_to_the_end()?;
        self.part += 1;
        if let Err(error) = file.go_on_in(&next) {
            self.give_up_file(error)?;
        }
        log_static(&self.rec, &self.options.config_toml)?;
        self.beams = BeamGeometry::default();
        if let Some(extent) = self.extent {
            self.send_layout(extent)?;
        }
        Ok(())
    }

    /// Everything of one revolution. An empty one writes empty values, so that nothing stale stays on the screen.
    fn log(&mut self, frame: &Frame, share: Share) -> Result<(), RecorderError> {
        let rec = &self.rec;
        let order = BeamOrder::of(&frame.revolution);
        let classes = self.tracks.classes_of(frame);
        let reach_m = self.extent.unwrap_or_default().range_m;
        if let Some(sweep) = frame.revolution.beams()
            && self.beams.log(rec, sweep)?
        {
            profile::log_axes(rec, reach_m, sweep)?;
        }
        scan::log(rec, frame, &classes, reach_m)?;
        let scale = spectrum::embedding_scale(&frame.spectrum.u);
        spectrum::log(rec, frame)?;
        if share.matrices {
            self.pictures.log(rec, frame, &order)?;
            spectrum::log_embedding(rec, frame, &classes, scale)?;
            why::log_graph(rec, frame)?;
        }
        if share.exact {
            exact::log(rec, frame)?;
        }
        partition::log(rec, frame, &order, &classes, scale)?;
        profile::log(rec, frame, &classes, reach_m)?;
        report::log(rec, frame, &classes)?;
        why::log(rec, frame, &classes, reach_m, &mut self.watch)?;
        self.times.log(rec, frame)?;
        self.notes.log(rec, frame)?;
        if share.exact_refused {
            let text = "the count changes often: no more exact matrices because of that for a while";
            rec.log("log", &TextLog::new(text).with_level(TextLogLevel::WARN))?;
        }
        Ok(())
    }

    /// A failed frame holds parts of another revolution: they are not recorded, and the screen is cleared.
    fn log_failure(&mut self, failure: &str) -> Result<(), RecorderError> {
        for part in ["scan", "affinity", "spectral", "kmeans", "report"] {
            self.rec.log(part, &Clear::recursive())?;
        }
        self.pictures.log_dark(&self.rec)?;
        self.rec.log("log", &TextLog::new(failure).with_level(TextLogLevel::ERROR))?;
        Ok(())
    }

    fn send_layout(&mut self, extent: Extent) -> Result<(), RecorderError> {
        scan::log_rings(&self.rec, extent.range_m)?;
        matrices::log_scale(&self.rec, extent.places)?;
        report::log_axis(&self.rec)?;
        layout::send(&self.rec, &Shown::Flight { first: self.options.layout, extent })?;
        extent.log(&self.rec)?;
        self.extent = Some(extent);
        Ok(())
    }

    /// Brings everything to the disk, and says whether that worked. Viewers are never waited for, nor is the disk
    /// during a live flight.
    fn flush(&mut self) -> Result<(), RecorderError> {
        let Some(backlog) = &mut self.backlog else { return self.flush_to_the_end() };
        self.unflushed = 0;
        backlog.flush_asked();
        let asked = self.rec.flush_async();
        self.check_file()?;
        asked.map_err(|e| RecorderError::Viewer(e.to_string()))
    }

    fn flush_to_the_end(&mut self) -> Result<(), RecorderError> {
        self.unflushed = 0;
        self.backlog.iter_mut().for_each(Backlog::flush_asked);
        let flushed = self.rec.flush_blocking();
        self.check_file()?;
        flushed.map_err(|e| RecorderError::Viewer(e.to_string()))
    }

    fn check_file(&mut self) -> Result<(), RecorderError> {
        match self.file.as_ref().map(RrdFile::check) {
            Some(Err(error)) => self.give_up_file(error),
            _ => Ok(()),
        }
    }

    /// Where viewers can go on without the file, its error is kept for the end.
    fn give_up_file(&mut self, error: RecorderError) -> Result<(), RecorderError> {
        if self.live.is_empty() {
            return Err(error);
        }
        self.file = None;
        self.file_lost = Some(error);
        Ok(())
    }
}

impl Observer for Recorder {
    fn observe(&mut self, frame: &Frame) -> Result<(), ObserverError> {
        self.record(frame).map_err(|e| ObserverError(e.to_string()))
    }

    /// Ends the file and each viewer, whatever became of the others, and tells all that went wrong.
    fn finish(&mut self) -> Result<(), ObserverError> {
        let layout = if self.extent.is_none() { self.send_layout(Extent::default()) } else { Ok(()) };
        let mut ends = vec![layout, self.flush_to_the_end()];
        ends.extend(self.file_lost.take().map(Err));
        ends.extend(self.file.as_ref().map(RrdFile::end));
        ends.extend(self.live.iter().map(Live::end));
        let lost = self.backlog.as_ref().and_then(Backlog::lost);
        ends.extend(lost.map(|Lost { thinned, left_out }| Err(RecorderError::DiskTooSlow { thinned, left_out })));
        let mut errors: Vec<String> = ends.into_iter().filter_map(Result::err).map(|e| e.to_string()).collect();
        errors.dedup(); // a full disk shows at the flush and at the end
        if errors.is_empty() { Ok(()) } else { Err(ObserverError(errors.join("; "))) }
    }
}

/// What holds for the whole recording: colours, look, configuration, and what the numbers mean.
fn log_static(rec: &RecordingStream, config_toml: &str) -> Result<(), RecorderError> {
    rec.log_static("/", &annotation_context())?;
    rec.log_static("config", &TextDocument::new(config_toml).with_media_type(MediaType::TEXT))?;
    rec.log_static("about", &TextDocument::from_markdown(include_str!("about.md")))?;
    scan::log_static(rec)?;
    spectrum::log_static(rec)?;
    partition::log_static(rec)?;
    profile::log_static(rec)?;
    report::log_static(rec)?;
    timing::log_static(rec)?;
    why::log_static(rec)?;
    Ok(())
}
