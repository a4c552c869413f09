//! The observer: it logs each revolution, flushes, begins parts, and handles failures.

use std::io::Write;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use crosscut_rrd::parts::part_path;
use crosscut_stage::{Frame, Observer, ObserverError};
use rerun::sink::LogSink;
use rerun::{RecordingStream, TextDocument, TextLog, TextLogLevel};

use crate::backlog::Room;
use crate::flight_map::FlightMap;
use crate::layout::{self, COMMAND, Extent, Layout, Shown};
use crate::mine::Mine;
use crate::options::{RecorderError, RecorderOptions};
use crate::outputs::{Further, Outputs, SEND_AFTER_BYTES};
use crate::piped::PipeSink;
use crate::revolution::RevolutionLog;
use crate::rows::Rows;
use crate::schema::LOG;
use crate::scope::{Plan, Share};
use crate::serving::Served;
use crate::{matrices, mounting, parts, report, scan, whole};

/// Sensor time between two flushes: a quarter of the flight so far, within these. Each flush writes the description of all columns
/// once more.
const FLUSH_AFTER_NS: [u64; 2] = [2_500_000_000, 10_000_000_000];
/// Sensor time between two flushes of a live flight, which cannot be repeated.
const FLUSH_LIVE_AFTER_NS: u64 = 1_000_000_000;
/// Most revolutions between two flushes, whatever their stamps.
const FLUSH_AFTER_REVOLUTIONS: u32 = 64;

/// Records every frame that it sees.
pub struct Recorder {
    outputs: Outputs,
    rows: Rows,
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
    revolutions: RevolutionLog,
    map: FlightMap,
    flushed_stamp_ns: u64,
    unflushed: u32,
}

impl Recorder {
    /// Opens the file and the viewer, and writes all that holds for the whole recording.
    ///
    /// # Errors
    /// When the file cannot be created, there is no viewer, or the environment turns recordings off.
    pub fn new(options: RecorderOptions) -> Result<Self, RecorderError> {
        Self::open(options, None, Further::default())
    }

    /// Writes the recording into `pipe` as well, as it is made.
    ///
    /// # Errors
    /// As [`Recorder::new`].
    pub fn piped(options: RecorderOptions, pipe: impl Write + Send + 'static) -> Result<Self, RecorderError> {
        let pipe = Some(PipeSink::new(Box::new(pipe)));
        Self::open(options, None, Further { pipe, ..Further::default() })
    }

    /// Records the stages of a mission, which adds its own rows.
    pub(crate) fn of_mission(options: RecorderOptions, mine: Mine) -> Result<Self, RecorderError> {
        Self::open(options, Some(mine), Further::default())
    }

    /// Sends what is shown one revolution after the other ([`Recorder::show`]) to `sink`.
    pub(crate) fn beside(options: RecorderOptions, sink: Box<dyn LogSink>) -> Result<Self, RecorderError> {
        Self::open(options, None, Further { sink: Some(sink), ..Further::default() })
    }

    fn open(options: RecorderOptions, mine: Option<Mine>, further: Further) -> Result<Self, RecorderError> {
        let outputs = Outputs::open(&options, further)?;
        whole::log(outputs.stream(), &options, mine.as_ref())?;
        Ok(Self {
            rows: Rows::new(outputs.stream().clone(), outputs.at_once),
            outputs,
            mine,
            extent: None,
            part: 1,
            file_number: 1,
            part_is_due: false,
            plan: Plan::new(options.scope.clone()),
            options,
            recorded: Arc::default(),
            revolutions: RevolutionLog::default(),
            map: FlightMap::default(),
            flushed_stamp_ns: 0,
            unflushed: 0,
        })
    }

    /// Where viewers can connect, if the recording is served.
    pub fn served(&self) -> Option<&Served> {
        self.outputs.served()
    }

    /// Where the rows of a mission go.
    pub(crate) fn rows(&mut self) -> &mut Rows {
        &mut self.rows
    }

    /// Writes a text in Markdown that holds for the whole recording.
    pub(crate) fn log_static_text(&mut self, path: &str, text: &str) -> Result<(), ObserverError> {
        self.outputs
            .stream()
            .log_static(path, &TextDocument::from_markdown(text))
            .map_err(|e| ObserverError(e.to_string()))
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
        let begins_part = self.part_is_due && self.outputs.is_clear();
        if begins_part {
            self.begin_part()?;
        }
        self.rows.set_time(revolution.seq, revolution.stamp_ns);
        if begins_part || self.extent.is_none() {
            parts::log(&mut self.rows, self.part, false);
            mounting::log(self.outputs.stream(), self.options.mounting, &revolution.frame_id)?;
        }
        if self.extent.is_none() {
            let has_truth = self.options.truth.of(revolution.seq).is_some();
            self.send_layout(Extent { has_truth, ..Extent::of(frame) })?;
            self.outputs.stream().send_recording_start_time(revolution.stamp_ns.cast_signed())?;
            self.flushed_stamp_ns = revolution.stamp_ns;
        }
        let is_room = self.make_room(frame, &mut share);
        match &frame.failure {
            None if is_room => {
                let extent = self.extent.unwrap_or_default();
                self.revolutions.log(&mut self.rows, frame, share, extent, &self.options);
                self.map.log(&mut self.rows, frame, begins_part);
            }
            None => {}
            Some(failure) => self.revolutions.log_failure(&mut self.rows, &failure.to_string()),
        }
        self.unflushed += 1;
        let unflushed_ns = revolution.stamp_ns.abs_diff(self.flushed_stamp_ns);
        let so_far_ns = self.revolutions.since_first_ns(revolution.stamp_ns);
        let [least_ns, most_ns] = FLUSH_AFTER_NS;
        let flush_after_ns =
            if self.options.live { FLUSH_LIVE_AFTER_NS } else { (so_far_ns / 4).clamp(least_ns, most_ns) };
        let is_due = unflushed_ns >= flush_after_ns || self.unflushed >= FLUSH_AFTER_REVOLUTIONS;
        if is_due || self.outputs.wants_flush() {
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
        let (room, said) = self.outputs.room_for(frame, *share);
        if let Some(said) = said {
            self.rows.log(&LOG, &TextLog::new(said).with_level(TextLogLevel::WARN));
        }
        if room == Room::NoMatrices {
            (share.matrices, share.exact) = (false, false);
            self.revolutions.log_no_matrices(&mut self.rows);
        }
        room != Room::Nothing
    }

    /// Ends the file and continues in another one. It can be opened alone, as all that never changes is written again.
    fn begin_part(&mut self) -> Result<(), RecorderError> {
        self.part_is_due = false;
        let Some(first) = self.options.path.clone().filter(|_| self.outputs.has_file()) else { return Ok(()) };
        self.file_number = parts::next_free(&first, self.file_number);
        parts::log(&mut self.rows, self.part, true);
        self.flush_to_the_end()?;
        self.part += 1;
        self.outputs.continue_in(&part_path(&first, self.file_number))?;
        whole::log(self.outputs.stream(), &self.options, self.mine.as_ref())?;
        self.revolutions.repeat();
        if let Some(extent) = self.extent {
            self.send_layout(extent)?;
        }
        Ok(())
    }

    /// Shows one revolution, which need not follow upon the one before, as the next moment of the timeline `command`. What was
    /// flushed is on its way when this returns.
    pub(crate) fn show(&mut self, frame: &Frame, options: RecorderOptions, command: i64) -> Result<(), RecorderError> {
        if options.config_toml != self.options.config_toml {
            whole::log_config(self.outputs.stream(), &options.config_toml)?;
        }
        self.options = options;
        self.outputs.stream().set_time_sequence(COMMAND, command);
        self.rows.set_time(frame.revolution.seq, frame.revolution.stamp_ns);
        let extent = Extent::of(frame);
        let is_alike = |before: &Extent| before.asks() == extent.asks();
        if !self.extent.as_ref().is_some_and(is_alike) {
            self.log_extent(Extent { range_m: self.extent.map_or(extent.range_m, |before| before.range_m), ..extent })?;
        }
        self.revolutions.jump();
        match &frame.failure {
            None => {
                let (share, extent) = (Share { matrices: true, ..Share::default() }, self.extent());
                self.revolutions.log(&mut self.rows, frame, share, extent, &self.options);
            }
            Some(failure) => {
                self.revolutions.log_failure(&mut self.rows, &failure.to_string());
                self.revolutions.repeat(); // what it cleared
            }
        }
        self.flush_to_the_end()
    }

    /// With the colours, range and time of the other recorder, so that both can be compared.
    pub(crate) fn seeing_as(mut self, other: &Self) -> Self {
        self.revolutions.begin_as(&other.revolutions);
        self.extent = other.extent.map(|extent| Extent { places: 0, ..extent }); // its own are measured
        self
    }

    /// Gives walls the colours that they have by the other recorder.
    pub(crate) fn colour_as(&mut self, other: &Self) {
        self.revolutions.colour_as(&other.revolutions);
    }

    /// What the views of this recorder show.
    pub(crate) fn extent(&self) -> Extent {
        self.extent.unwrap_or_default()
    }

    pub(crate) fn stream(&self) -> &RecordingStream {
        self.outputs.stream()
    }

    fn send_layout(&mut self, extent: Extent) -> Result<(), RecorderError> {
        self.log_extent(extent)?;
        let shown = match &self.mine {
            None => Shown::Flight { first: Layout::default(), extent },
            Some(mine) => Shown::Mission { corners_m: mine.corners_m, extent },
        };
        layout::send(self.outputs.stream(), &shown)?;
        Ok(())
    }

    /// Logs what the views are measured by.
    fn log_extent(&mut self, extent: Extent) -> Result<(), RecorderError> {
        scan::log_rings(self.outputs.stream(), extent.range_m)?;
        matrices::log_scale(self.outputs.stream(), extent.places)?;
        report::log_axis(&mut self.rows);
        extent.log(self.outputs.stream())?;
        self.extent = Some(extent);
        Ok(())
    }

    fn flush(&mut self) -> Result<(), RecorderError> {
        self.unflushed = 0;
        self.outputs.flush(&mut self.rows)
    }

    fn flush_to_the_end(&mut self) -> Result<(), RecorderError> {
        self.unflushed = 0;
        self.outputs.flush_to_the_end(&mut self.rows)
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
        ends.extend(self.outputs.end());
        let mut errors: Vec<String> = ends.into_iter().filter_map(Result::err).map(|e| e.to_string()).collect();
        errors.dedup(); // a full disk shows at the flush and at the end
        if errors.is_empty() { Ok(()) } else { Err(ObserverError(errors.join("; "))) }
    }
}
