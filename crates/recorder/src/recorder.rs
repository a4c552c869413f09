//! The observer: what is logged of each revolution, when it is flushed, and what happens when that fails.

use std::net::SocketAddr;
use std::path::PathBuf;
use std::time::Duration;

use crosscut_stage::{Frame, Observer, ObserverError};
use rerun::log::ChunkBatcherConfig;
use rerun::sink::LogSink;
use rerun::{Clear, MediaType, RecordingStream, RecordingStreamBuilder, RecordingStreamError, TextDocument};
use rerun::{TextLog, TextLogLevel};

use crate::beam_order::BeamOrder;
use crate::colors::annotation_context;
use crate::file::RrdFile;
use crate::layout::Extent;
use crate::live::{Live, Outlet};
use crate::matrices::Pictures;
use crate::scan::BeamGeometry;
use crate::serving::{self, Served};
use crate::{layout, partition, report, scan, spectrum, viewer};

/// What is on the disk never lags behind by more than this much sensor time...
const FLUSH_AFTER_NS: u64 = 1_500_000_000;
/// ...nor by more revolutions than this, whatever the stamps say.
const FLUSH_AFTER_REVOLUTIONS: u32 = 64;
/// Chunks are made by these rules alone, so that equal flights make equal chunks; memory stays bounded all the same.
const FLUSH_AFTER_BYTES: u64 = 16 << 20;
/// A viewer wants to see things soon; sooner still would double the file.
const LIVE_TICK: Duration = Duration::from_millis(500);

/// Where and how to record.
#[derive(Clone, Debug, Default)]
pub struct RecorderOptions {
    /// The .rrd file to write; an existing one is replaced.
    pub path: Option<PathBuf>,
    /// Shows the recording in the native viewer while it is made.
    pub view: bool,
    /// Serves the recording at this address while it is made, and until the recorder is dropped; port 0 takes a free one.
    pub serve: Option<SocketAddr>,
    /// Name of the recording, as the viewer lists it.
    pub name: String,
    /// The resolved configuration, as TOML.
    pub config_toml: String,
}

/// Why nothing can be recorded, or no more.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RecorderError {
    /// The file could not be made.
    #[error("cannot create the recording: {cause}: {}", path.display())]
    Create {
        /// Which file.
        path: PathBuf,
        /// What the system said.
        cause: String,
    },
    /// The file could not be written to the end.
    #[error("the recording ends early, with what was written so far: {cause}: {}", path.display())]
    Write {
        /// Which file.
        path: PathBuf,
        /// What the system said.
        cause: String,
    },
    /// The environment tells Rerun to drop everything in silence.
    #[error("RERUN=0 in the environment turns every recording off; unset it")]
    Disabled,
    /// There is no native viewer on this machine.
    #[error("no Rerun viewer found; `pip install rerun-sdk==0.36.3` brings it")]
    NoViewer,
    /// The viewer could not be started, or went away.
    #[error("the viewer is not to be reached: {0}")]
    Viewer(String),
    /// The viewer reads more slowly than the flight goes.
    #[error("the viewer was too slow: {0} messages were left out of what it shows")]
    ViewerTooSlow(u64),
    /// The address cannot be listened at.
    #[error("cannot serve at {address}: {cause}")]
    Serve {
        /// Which address.
        address: SocketAddr,
        /// What the system said.
        cause: String,
    },
    /// Rerun refused.
    #[error("cannot record: {0}")]
    Rerun(#[from] RecordingStreamError),
}

/// Records every frame that it sees.
pub struct Recorder {
    rec: RecordingStream,
    file: Option<RrdFile>,
    live: Vec<Live>,
    served: Option<Served>,
    layout_sent: bool,
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
            live.push(Live::start(Outlet::Server(server.sink))?);
            served = Some(server.served);
        }
        let file = options.path.as_deref().map(RrdFile::create).transpose()?;
        let mut sinks: Vec<Box<dyn LogSink>> = Vec::new();
        sinks.extend(file.clone().map(|file| Box::new(file) as Box<dyn LogSink>));
        sinks.extend(live.iter().map(|live| Box::new(live.sink()) as Box<dyn LogSink>));
        let batches = ChunkBatcherConfig {
            flush_tick: if live.is_empty() { Duration::MAX } else { LIVE_TICK },
            flush_num_bytes: FLUSH_AFTER_BYTES,
            ..ChunkBatcherConfig::DEFAULT
        };
        let rec = RecordingStreamBuilder::new("crosscut")
            .recording_name(options.name)
            .recording_started(0) // until the first revolution says when
            .batcher_config(batches)
            .set_sinks(sinks)?;
        rec.set_log_time_enabled(false); // a recording depends on the flight, not on when it was made
        rec.set_log_tick_enabled(false);
        log_static(&rec, &options.config_toml)?;
        Ok(Self {
            rec,
            file,
            live,
            served,
            layout_sent: false,
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

    fn record(&mut self, frame: &Frame) -> Result<(), RecorderError> {
        let revolution = &frame.revolution;
        self.rec.set_time_sequence("revolution", revolution.seq.cast_signed());
        self.rec.set_timestamp_nanos_since_epoch("stamp", revolution.stamp_ns.cast_signed());
        if !self.layout_sent {
            self.send_layout(Extent::of(frame))?;
            self.rec.send_recording_start_time(revolution.stamp_ns.cast_signed())?;
            self.flushed_stamp_ns = revolution.stamp_ns;
        }
        match &frame.failure {
            None => self.log(frame)?,
            Some(failure) => self.log_failure(&failure.to_string())?,
        }
        self.unflushed += 1;
        let unflushed_ns = revolution.stamp_ns.abs_diff(self.flushed_stamp_ns);
        if unflushed_ns >= FLUSH_AFTER_NS || self.unflushed >= FLUSH_AFTER_REVOLUTIONS {
            self.flush()?;
            self.flushed_stamp_ns = revolution.stamp_ns;
        }
        Ok(())
    }

    /// Everything of one revolution. An empty one writes empty values, so that nothing stale stays on the screen.
    fn log(&mut self, frame: &Frame) -> Result<(), RecorderError> {
        let order = BeamOrder::of(&frame.revolution);
        if let Some(sweep) = &frame.revolution.sweep {
            self.beams.log(&self.rec, sweep)?;
        }
        scan::log(&self.rec, frame)?;
        self.pictures.log(&self.rec, frame, &order)?;
        let scale = spectrum::embedding_scale(&frame.spectrum.u);
        spectrum::log(&self.rec, frame, scale)?;
        partition::log(&self.rec, frame, &order, scale)?;
        report::log(&self.rec, frame)?;
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
        layout::send(&self.rec, &extent)?;
        self.layout_sent = true;
        Ok(())
    }

    /// Brings everything to the disk, and says whether that worked. Viewers are never waited for.
    fn flush(&mut self) -> Result<(), RecorderError> {
        self.unflushed = 0;
        let flushed = self.rec.flush_blocking();
        self.file.as_ref().map_or(Ok(()), RrdFile::check)?;
        flushed.map_err(|e| RecorderError::Viewer(e.to_string()))
    }
}

impl Observer for Recorder {
    fn observe(&mut self, frame: &Frame) -> Result<(), ObserverError> {
        self.record(frame).map_err(|e| ObserverError(e.to_string()))
    }

    fn finish(&mut self) -> Result<(), ObserverError> {
        let mut end = || -> Result<(), RecorderError> {
            if !self.layout_sent {
                self.send_layout(Extent::default())?;
            }
            self.flush()?;
            self.file.as_ref().map_or(Ok(()), RrdFile::end)?;
            self.live.iter().try_for_each(Live::end)
        };
        end().map_err(|e| ObserverError(e.to_string()))
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
    report::log_static(rec)?;
    Ok(())
}
