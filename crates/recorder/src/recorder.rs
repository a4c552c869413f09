//! The observer: it logs each revolution, flushes, and handles failures of both.

use std::io::Write;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use crosscut_explain::Watch;
use crosscut_rrd::parts::part_path;
use crosscut_stage::{Frame, Observer, ObserverError};
use rerun::external::re_log_types::ApplicationId;
use rerun::log::ChunkBatcherConfig;
use rerun::sink::LogSink;
use rerun::{Clear, MediaType, RecordingStream, RecordingStreamBuilder, TextDocument};
use rerun::{TextLog, TextLogLevel};

use crate::as_read::AsRead;
use crate::backlog::{Backlog, Lost, Room};
use crate::beam_order::BeamOrder;
use crate::colors::annotation_context;
use crate::eigenvectors::Bands;
use crate::file::RrdFile;
use crate::flight_map::{self, FlightMap};
use crate::layout::{Extent, Shown};
use crate::live::{Live, Outlet};
use crate::matrices::{Absent, Pictures};
use crate::mission::Mine;
use crate::notes::Notes;
use crate::options::{RecorderError, RecorderOptions, StoreIds};
use crate::parts;
use crate::piped::PipeSink;
use crate::rows::Rows;
use crate::scan::BeamGeometry;
use crate::schema::{
    ABOUT, AFFINITY_DEGREES, AFFINITY_LINKS, AFFINITY_MARKS, COLORS, CONFIG, KMEANS_BLOCKS, LOG, SPECTRAL_EMBEDDING,
    SPECTRAL_U, SPECTRAL_U_BARS,
};
use crate::scope::{Detail, Plan, Share};
use crate::serving::{self, Served};
use crate::timing::Times;
use crate::tracks::Tracks;
use crate::why::Told;
use crate::{
    eigenvectors, exact, gaps, layout, matrices, mounting, partition, profile, report, scan, schema, spectrum, timing,
    truth, viewer, why,
};

/// Sensor time between two flushes: a quarter of the flight so far, within these. Each flush writes the description of all columns
/// once more.
const FLUSH_AFTER_NS: [u64; 2] = [2_500_000_000, 10_000_000_000];
/// Sensor time between two flushes of a live flight, which cannot be repeated.
const FLUSH_LIVE_AFTER_NS: u64 = 1_000_000_000;
/// Most revolutions between two flushes, whatever their stamps.
const FLUSH_AFTER_REVOLUTIONS: u32 = 64;
/// Bytes of waiting rows after which they are sent, which bounds the memory.
const SEND_AFTER_BYTES: usize = 16 << 20;
/// Time between two flushes to a viewer. Half of it would double the file.
const LIVE_TICK: Duration = Duration::from_millis(500);
/// The timeline of revolutions that are shown one after the other ([`Recorder::show`]).
pub(crate) const COMMAND: &str = "command";

/// Records every frame that it sees.
pub struct Recorder {
    rec: RecordingStream,
    rows: Rows,
    file: Option<RrdFile>,
    /// Why the file was given up, if viewers are still served.
    file_lost: Option<RecorderError>,
    pipe: Option<PipeSink>,
    live: Vec<Live>,
    served: Option<Served>,
    /// Only of a live flight.
    backlog: Option<Backlog>,
    options: RecorderOptions,
    /// Of a mission.
    mine: Option<Mine>,
    /// What the views show; set when the layout is sent.
    extent: Option<Extent>,
    /// The part being written, from 1.
    part: u64,
    /// The number in the name of its file. It is greater than `part` if other recordings have the names of parts.
    file_number: u64,
    /// A new part begins as soon as that does not delay a live flight.
    part_is_due: bool,
    plan: Plan,
    /// Number of revolutions within the scope.
    recorded: Arc<AtomicU64>,
    tracks: Tracks,
    watch: Watch,
    doubts: why::Doubts,
    times: Times,
    notes: Notes,
    map: FlightMap,
    beams: BeamGeometry,
    as_read: AsRead,
    pictures: Pictures,
    bands: Bands,
    absent: Absent,
    truth_before: Option<usize>,
    /// The stamp of the first revolution.
    first_ns: Option<u64>,
    flushed_stamp_ns: u64,
    unflushed: u32,
}

/// What is around a recording beside its options.
#[derive(Default)]
struct Around {
    pipe: Option<PipeSink>,
    mine: Option<Mine>,
    sink: Option<Box<dyn LogSink>>,
}

impl Recorder {
    /// Opens the file and the viewer, and writes all that holds for the whole recording.
    ///
    /// # Errors
    /// When the file cannot be created, there is no viewer, or the environment turns recordings off.
    pub fn new(options: RecorderOptions) -> Result<Self, RecorderError> {
        Self::open(options, Around::default())
    }

    /// Writes the recording into `pipe` as well, as it is made.
    ///
    /// # Errors
    /// As [`Recorder::new`].
    pub fn piped(options: RecorderOptions, pipe: impl Write + Send + 'static) -> Result<Self, RecorderError> {
        let pipe = Some(PipeSink::new(Box::new(pipe)));
        Self::open(options, Around { pipe, ..Around::default() })
    }

    /// Records the stages of a mission, which adds its own rows.
    pub(crate) fn of_mission(options: RecorderOptions, mine: Mine) -> Result<Self, RecorderError> {
        Self::open(options, Around { mine: Some(mine), ..Around::default() })
    }

    /// Sends what is shown one revolution after the other ([`Recorder::show`]) to `sink`.
    pub(crate) fn beside(options: RecorderOptions, sink: Box<dyn LogSink>) -> Result<Self, RecorderError> {
        Self::open(options, Around { sink: Some(sink), ..Around::default() })
    }

    fn open(options: RecorderOptions, around: Around) -> Result<Self, RecorderError> {
        let Around { pipe, mine, sink } = around;
        if !rerun::decide_logging_enabled(true) {
            return Err(RecorderError::Disabled);
        }
        let mut live = Vec::new();
        let mut served = None;
        // The viewer comes before the file: if there is no viewer, an older file is kept.
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
        log_static(&rec, &options, mine.as_ref())?;
        Ok(Self {
            rows: Rows::new(rec.clone(), at_once),
            rec,
            file,
            file_lost: None,
            pipe,
            live,
            served,
            backlog,
            mine,
            extent: None,
            part: 1,
            file_number: 1,
            part_is_due: false,
            plan: Plan::new(options.scope.clone()),
            options,
            recorded: Arc::default(),
            tracks: Tracks::default(),
            watch: Watch::default(),
            doubts: why::Doubts::default(),
            times: Times::default(),
            notes: Notes::default(),
            map: FlightMap::default(),
            beams: BeamGeometry::default(),
            as_read: AsRead::default(),
            pictures: Pictures::default(),
            bands: Bands::default(),
            absent: Absent::default(),
            truth_before: None,
            first_ns: None,
            flushed_stamp_ns: 0,
            unflushed: 0,
        })
    }

    /// Where viewers can connect, if the recording is served.
    pub fn served(&self) -> Option<&Served> {
        self.served.as_ref()
    }

    /// Where the rows of a mission go.
    pub(crate) fn rows(&mut self) -> &mut Rows {
        &mut self.rows
    }

    /// Writes a text in Markdown that holds for the whole recording.
    pub(crate) fn log_static_text(&mut self, path: &str, text: &str) -> Result<(), ObserverError> {
        self.rec.log_static(path, &TextDocument::from_markdown(text)).map_err(|e| ObserverError(e.to_string()))
    }

    /// Number of revolutions within the scope. It can still be read when the flight has dropped the recorder.
    pub fn recorded(&self) -> Arc<AtomicU64> {
        Arc::clone(&self.recorded)
    }

    fn record(&mut self, frame: &Frame) -> Result<(), RecorderError> {
        if frame.failure.is_none() {
            self.map.add(frame); // a map needs the whole flight, whatever is recorded of it
        }
        let Some(mut share) = self.plan.share_of(frame) else { return Ok(()) };
        self.recorded.fetch_add(1, Ordering::Relaxed);
        let revolution = &frame.revolution;
        self.part_is_due |= share.new_part;
        let begins_part = self.part_is_due && self.backlog.as_ref().is_none_or(Backlog::is_clear);
        if begins_part {
            self.begin_part()?;
        }
        self.rows.set_time(revolution.seq, revolution.stamp_ns);
        if begins_part || self.extent.is_none() {
            parts::log(&mut self.rows, self.part, false);
            mounting::log(&self.rec, self.options.mounting, &revolution.frame_id)?;
        }
        if self.extent.is_none() {
            let has_truth = self.options.truth.of(revolution.seq).is_some();
            self.send_layout(Extent { has_truth, ..Extent::of(frame) })?;
            self.rec.send_recording_start_time(revolution.stamp_ns.cast_signed())?;
            self.flushed_stamp_ns = revolution.stamp_ns;
        }
        let is_room = self.make_room(frame, &mut share);
        match &frame.failure {
            None if is_room => {
                self.log(frame, share);
                self.map.log(&mut self.rows, frame, begins_part);
            }
            None => {}
            Some(failure) => self.log_failure(&failure.to_string()),
        }
        self.unflushed += 1;
        let unflushed_ns = revolution.stamp_ns.abs_diff(self.flushed_stamp_ns);
        let so_far_ns = self.first_ns.map_or(0, |first_ns| revolution.stamp_ns.abs_diff(first_ns));
        let [least_ns, most_ns] = FLUSH_AFTER_NS;
        let flush_after_ns =
            if self.options.live { FLUSH_LIVE_AFTER_NS } else { (so_far_ns / 4).clamp(least_ns, most_ns) };
        let is_due = unflushed_ns >= flush_after_ns || self.unflushed >= FLUSH_AFTER_REVOLUTIONS;
        if is_due || self.backlog.as_ref().is_some_and(Backlog::wants_flush) {
            self.flush()?;
            self.flushed_stamp_ns = revolution.stamp_ns;
        } else if self.rows.bytes() >= SEND_AFTER_BYTES {
            self.rows.send()?;
        }
        Ok(())
    }

    /// Takes from `share` what the disk of a live flight is too slow for, and logs that. Returns `false` if there is no
    /// room for the revolution at all.
    fn make_room(&mut self, frame: &Frame, share: &mut Share) -> bool {
        let Some(backlog) = &mut self.backlog else { return true };
        let (room, said) = backlog.room_for(frame, *share);
        if let Some(said) = said {
            self.rows.log(&LOG, &TextLog::new(said).with_level(TextLogLevel::WARN));
        }
        if room == Room::NoMatrices {
            (share.matrices, share.exact) = (false, false);
            self.pictures.log_dark(&mut self.rows);
            self.bands.log_dark(&mut self.rows);
            for entity in [
                AFFINITY_MARKS,
                KMEANS_BLOCKS,
                SPECTRAL_U_BARS,
                AFFINITY_DEGREES,
                AFFINITY_LINKS,
                SPECTRAL_U,
                SPECTRAL_EMBEDDING,
            ] {
                self.rows.log(&entity, &Clear::flat()); // no older values stay on the screen
            }
        }
        room != Room::Nothing
    }

    /// Ends the file and continues in another one. It can be opened alone, as all that never changes is written again.
    fn begin_part(&mut self) -> Result<(), RecorderError> {
        self.part_is_due = false;
        let (Some(file), Some(first)) = (self.file.clone(), &self.options.path) else { return Ok(()) };
        self.file_number = parts::next_free(first, self.file_number);
        let next = part_path(first, self.file_number);
        parts::log(&mut self.rows, self.part, true);
        self.flush_to_the_end()?;
        self.part += 1;
        if let Err(error) = file.continue_in(&next) {
            self.give_up_file(error)?;
        }
        log_static(&self.rec, &self.options, self.mine.as_ref())?;
        (self.beams, self.as_read, self.absent) = (BeamGeometry::default(), AsRead::default(), Absent::default());
        self.doubts.repeat();
        if let Some(extent) = self.extent {
            self.send_layout(extent)?;
        }
        Ok(())
    }

    /// Logs one revolution. An empty one writes empty values, so that no older ones stay on the screen.
    fn log(&mut self, frame: &Frame, share: Share) {
        let rows = &mut self.rows;
        let order = BeamOrder::of(&frame.revolution);
        let classes = self.tracks.classes_of(frame);
        let reach_m = self.extent.unwrap_or_default().range_m;
        if let Some(sweep) = frame.revolution.beams()
            && self.beams.log(rows, sweep)
        {
            profile::log_axes(rows, reach_m, sweep);
        }
        scan::log(rows, frame, &classes, reach_m);
        self.as_read.log(rows, frame);
        let scale = spectrum::embedding_scale(&frame.spectrum.u);
        spectrum::log(rows, frame);
        if share.matrices {
            self.pictures.log(rows, frame, &order);
            self.bands.log(rows, frame, &order, &classes);
            spectrum::log_embedding(rows, frame, &classes, scale);
            partition::log_blocks(rows, frame, &order, &classes);
            why::log_graph(rows, frame);
            if self.extent.is_some_and(|extent| extent.by_gaps) || !frame.affinity.verdicts.is_empty() {
                gaps::log(rows, frame);
            }
        }
        if share.exact {
            exact::log(rows, frame);
        }
        partition::log(rows, frame, &order, &classes, scale);
        profile::log(rows, frame, &classes, reach_m);
        report::log(rows, frame, &classes);
        self.absent.log(rows, frame, share.matrices, &order);
        let revolution = &frame.revolution;
        let truth = self.options.truth.of(revolution.seq);
        truth::log(rows, revolution.seq, truth.as_ref(), &mut self.truth_before);
        let truth = truth.map(|(walls, _)| walls);
        let first_ns = *self.first_ns.get_or_insert(revolution.stamp_ns);
        let told = Told { classes: &classes, reach_m, source: &self.options.source, first_ns, truth };
        let explanation = why::log(rows, frame, &told, &mut self.watch);
        self.doubts.log(rows, self.watch.doubt());
        if share.matrices {
            why::log_marks(rows, frame, &order, &explanation);
        }
        self.times.log(rows, frame);
        self.notes.log(rows, frame);
        if share.exact_refused {
            let text = "the count changes often: exact matrices are recorded at fewer of the changes";
            rows.log(&LOG, &TextLog::new(text).with_level(TextLogLevel::WARN));
        }
    }

    /// Logs a failure and clears the screen. The frame is not recorded, as it may hold parts of another revolution.
    fn log_failure(&mut self, failure: &str) {
        for area in ["/scan", "/affinity", "/spectral", "/kmeans", "/report"] {
            self.rows.log_at(area, &Clear::recursive());
        }
        self.pictures.log_dark(&mut self.rows);
        self.bands.log_dark(&mut self.rows);
        self.rows.log(&LOG, &TextLog::new(failure).with_level(TextLogLevel::ERROR));
    }

    /// Shows one revolution, which need not follow upon the one before, as the next moment of the timeline `command`. What was
    /// flushed is on its way when this returns.
    pub(crate) fn show(&mut self, frame: &Frame, options: RecorderOptions, command: i64) -> Result<(), RecorderError> {
        if options.config_toml != self.options.config_toml {
            log_config(&self.rec, &options.config_toml)?;
        }
        self.options = options;
        self.rec.set_time_sequence(COMMAND, command);
        self.rows.set_time(frame.revolution.seq, frame.revolution.stamp_ns);
        let extent = Extent::of(frame);
        let is_alike = |before: &Extent| (before.places, before.by_gaps) == (extent.places, extent.by_gaps);
        if !self.extent.as_ref().is_some_and(is_alike) {
            self.log_extent(Extent { range_m: self.extent.map_or(extent.range_m, |before| before.range_m), ..extent })?;
        }
        self.watch = Watch::default(); // it would compare with the revolution that was shown before
        match &frame.failure {
            None => self.log(frame, Share { matrices: true, ..Share::default() }),
            Some(failure) => {
                self.log_failure(&failure.to_string());
                (self.beams, self.as_read, self.absent) = Default::default(); // they are cleared, too
            }
        }
        self.flush_to_the_end()
    }

    /// With the colours, range and time of the other recorder, so that both can be compared.
    pub(crate) fn seeing_as(mut self, other: &Self) -> Self {
        self.colour_as(other);
        self.first_ns = other.first_ns;
        self.extent = other.extent.map(|extent| Extent { places: 0, ..extent }); // its own are measured
        self
    }

    /// Gives walls the colours that they have by the other recorder.
    pub(crate) fn colour_as(&mut self, other: &Self) {
        self.tracks.clone_from(&other.tracks);
    }

    /// What the views of this recorder show.
    pub(crate) fn extent(&self) -> Extent {
        self.extent.unwrap_or_default()
    }

    pub(crate) fn stream(&self) -> &RecordingStream {
        &self.rec
    }

    fn send_layout(&mut self, extent: Extent) -> Result<(), RecorderError> {
        self.log_extent(extent)?;
        let shown = match &self.mine {
            None => Shown::Flight { first: self.options.layout, extent },
            Some(mine) => Shown::Mission { corners_m: mine.corners_m, extent },
        };
        layout::send(&self.rec, &shown)?;
        Ok(())
    }

    /// Logs what the views are measured by.
    fn log_extent(&mut self, extent: Extent) -> Result<(), RecorderError> {
        scan::log_rings(&self.rec, extent.range_m)?;
        matrices::log_scale(&self.rec, extent.places)?;
        report::log_axis(&mut self.rows);
        extent.log(&self.rec)?;
        self.extent = Some(extent);
        Ok(())
    }

    /// Flushes all rows to the disk. It does not wait for viewers, nor for the disk during a live flight.
    ///
    /// # Errors
    /// When a write has failed.
    fn flush(&mut self) -> Result<(), RecorderError> {
        let Some(backlog) = &mut self.backlog else { return self.flush_to_the_end() };
        self.unflushed = 0;
        self.rows.send()?;
        backlog.flush_asked();
        let asked = self.rec.flush_async();
        self.check_file()?;
        asked.map_err(|e| RecorderError::Viewer(e.to_string()))
    }

    fn flush_to_the_end(&mut self) -> Result<(), RecorderError> {
        self.unflushed = 0;
        self.rows.send()?;
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

    /// With viewers the flight continues without the file, whose error is kept for the end.
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

    /// Ends the file and each viewer, even if others fail, and reports all errors.
    fn finish(&mut self) -> Result<(), ObserverError> {
        let layout = if self.extent.is_none() { self.send_layout(Extent::default()) } else { Ok(()) };
        let mut ends = vec![layout, self.flush_to_the_end()];
        ends.extend(self.file_lost.take().map(Err));
        ends.extend(self.file.as_ref().map(RrdFile::end));
        ends.extend(self.pipe.as_ref().map(PipeSink::end));
        ends.extend(self.live.iter().map(Live::end));
        let lost = self.backlog.as_ref().and_then(Backlog::lost);
        ends.extend(lost.map(|Lost { thinned, left_out }| Err(RecorderError::DiskTooSlow { thinned, left_out })));
        let mut errors: Vec<String> = ends.into_iter().filter_map(Result::err).map(|e| e.to_string()).collect();
        errors.dedup(); // a full disk shows at the flush and at the end
        if errors.is_empty() { Ok(()) } else { Err(ObserverError(errors.join("; "))) }
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

/// Logs what holds for the whole recording: colours, look, configuration, the text of `/about`, and the mine of a mission.
fn log_static(rec: &RecordingStream, options: &RecorderOptions, mine: Option<&Mine>) -> Result<(), RecorderError> {
    mine.map_or(Ok(()), |mine| mine.log_static(rec))?;
    rec.log_static(COLORS.path, &annotation_context())?;
    log_config(rec, &options.config_toml)?;
    rec.log_static(ABOUT.path, &TextDocument::from_markdown(about()))?;
    scan::log_static(rec)?;
    if options.scope.detail != Detail::Light {
        matrices::log_static(rec)?;
        eigenvectors::log_static(rec)?;
    }
    spectrum::log_static(rec)?;
    partition::log_static(rec)?;
    profile::log_static(rec)?;
    flight_map::log_static(rec)?;
    report::log_static(rec)?;
    timing::log_static(rec)?;
    truth::log_static(rec)?;
    gaps::log_static(rec)?;
    why::log_static(rec)?;
    Ok(())
}

fn log_config(rec: &RecordingStream, toml: &str) -> rerun::RecordingStreamResult<()> {
    rec.log_static(CONFIG.path, &TextDocument::new(toml).with_media_type(MediaType::TEXT))
}

/// The text of `/about`, with a row for each entity.
fn about() -> String {
    format!("{}\n{}", include_str!("about.md"), schema::markdown_table())
}
