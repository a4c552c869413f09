//! One flight, from one file or several, revolution by revolution.

use std::collections::VecDeque;
use std::mem;
use std::num::NonZero;
use std::path::PathBuf;

use crosscut_messages::{NS_PER_S, ScanDecoder, ScanType};
use crosscut_sensor::{Before, Motion, Sensor, Turning, times_s};
use crosscut_stage::NoteCode::{N044, N045};
use crosscut_stage::{Notes, Revolution, Source, SourceError, counted};

use crate::container::{self, Container, Wait};
use crate::messages::Messages;
use crate::odometry_reader::OdometryReader;
use crate::parts::OpenParts;
use crate::scanners::{Mount, Scanners, Scans};
use crate::topics::{scan_topic, topics_of};
use crate::turns::{Turn, Turns};
use crate::{CsvGeometry, IngestError, Loss, TopicInfo, limits};

/// Which scans of a recording are wanted.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadOptions {
    /// The scan topic; `None` takes the only one there is.
    pub topic: Option<String>,
    /// Topics of other scanners of the vehicle, which are joined to the first by the transforms of the recording.
    pub beside: Vec<String>,
    /// What its messages are, whatever the recording calls them; `None` believes the recording.
    pub read_as: Option<ScanType>,
    /// From this many seconds after the first scan was recorded.
    pub from_s: Option<f64>,
    /// Up to and with this many seconds after the first scan was recorded.
    pub to_s: Option<f64>,
    /// Only messages whose index in the topic is a multiple of this.
    pub every: NonZero<u64>,
    /// Where the beams of a table of ranges look.
    pub csv: CsvGeometry,
    /// Messages and scans that wait for others may take this much memory.
    pub waiting_bytes: u64,
}

impl Default for ReadOptions {
    fn default() -> Self {
        Self {
            topic: None,
            beside: Vec::new(),
            read_as: None,
            from_s: None,
            to_s: None,
            every: NonZero::<u64>::MIN,
            csv: CsvGeometry::default(),
            waiting_bytes: limits::WAITING_BYTES,
        }
    }
}

/// A recorded flight. It gives one revolution for each turn of the lidar that is selected, empty ones too, with the pose of
/// the vehicle by the odometry beside the scans, if there is any.
pub struct Recording {
    messages: Messages,
    odometry: Option<OdometryReader>,
    turns: Turns,
    options: ReadOptions,
    sensor: Sensor,
    topic: TopicInfo,
    /// Whether all messages were read.
    has_ended: bool,
    /// Whether they come as they come.
    is_stream: bool,
    /// Selected turns. Those before the first one that can be decoded wait here: if there is none, nothing is given.
    selected: VecDeque<Turn>,
    any_decoded: bool,
    /// When the first scan was recorded.
    first_ns: Option<u64>,
    /// When the last turn was recorded that was looked at, seconds after the first.
    since_first_s: f64,
    /// When the first revolution was recorded that was given, seconds after the first scan.
    starts_at_s: Option<f64>,
    /// Whether any turn lay in the time asked for.
    any_selected: bool,
    before: Before,
    turning: Turning,
    /// The other scanners of the vehicle.
    scanners: Option<Scanners<Self>>,
    /// How the recording mounts its sensor, until the first scan.
    mount: Option<Mount>,
    /// How long it waits for messages of a stream once it is known what they are.
    wait: Wait,
    /// Whether that was learned from fewer messages than usual, because no more came in time.
    is_hurried: bool,
    last_log_time_ns: u64,
    reordered: u64,
    of_other_frames: u64,
    last_other_frame: String,
    left_out: Vec<PathBuf>,
}

impl Recording {
    /// Opens the recordings in `inputs` (see [`parts_in`](crate::parts_in)) as the parts of one flight, in that order, and finds
    /// the scan topic.
    ///
    /// # Errors
    /// When there is nothing that can be read: what was found instead. A part that is missing, empty or, in a folder, no
    /// recording, is a loss if others are not.
    pub fn open(inputs: &[PathBuf], options: &ReadOptions, sensor: Sensor) -> Result<Self, IngestError> {
        let OpenParts { containers, losses, left_out } = OpenParts::open(inputs, &options.csv)?;
        let scanners = Self::beside(&containers, &losses, options, &sensor)?;
        let is_single = scanners.is_none();
        let mount = is_single.then(|| Mount::read(&containers, &options.csv, &sensor)).flatten();
        Ok(Self { scanners, mount, left_out, ..Self::of(containers, losses, options, sensor)? })
    }

    /// Of a stream: how many messages there will be is not known.
    pub(crate) fn streamed(self, scanners: Option<Scanners<Self>>, mount: Option<Mount>) -> Self {
        let topic = TopicInfo { messages: None, ..self.topic };
        Self { scanners, mount, topic, is_stream: true, ..self }
    }

    /// Whether its messages are read as they come.
    pub fn is_stream(&self) -> bool {
        self.is_stream
    }

    /// The scanners of the topics beside the first one in the files of `containers`, which lack `losses`; `None` if there are none.
    ///
    /// # Errors
    /// When one of them carries no scans.
    pub(crate) fn beside(
        containers: &[Box<dyn Container>],
        losses: &[Loss],
        options: &ReadOptions,
        sensor: &Sensor,
    ) -> Result<Option<Scanners<Self>>, IngestError> {
        if options.beside.is_empty() {
            return Ok(None);
        }
        let (csv, read_as) = (&options.csv, options.read_as);
        let is_stream = containers.iter().any(|container| container.again().is_some());
        let reopened = || -> Result<Vec<_>, IngestError> {
            containers.iter().map(|container| container::reopen(&**container, csv)).collect()
        };
        let open = |topic: &String| {
            let options =
                ReadOptions { topic: Some(topic.clone()), read_as, csv: csv.clone(), ..ReadOptions::default() };
            Self::of(reopened()?, losses.to_vec(), &options, sensor.clone())
        };
        let others = options.beside.iter().map(open).collect::<Result<_, IngestError>>()?;
        Ok(Some(Scanners::new(others, reopened()?, is_stream)))
    }

    /// One scanner of the vehicle.
    pub(crate) fn of(
        mut containers: Vec<Box<dyn Container>>,
        losses: Vec<Loss>,
        options: &ReadOptions,
        sensor: Sensor,
    ) -> Result<Self, IngestError> {
        containers.iter_mut().for_each(|container| container.limit_waiting(options.waiting_bytes));
        let contents = || containers.iter().map(|container| container.contents());
        let topics = topics_of(contents());
        let damage = || {
            let of_parts = contents().flat_map(|contents| contents.losses.clone());
            losses.iter().cloned().chain(of_parts).collect()
        };
        if topics.is_empty() {
            return Err(IngestError::NothingReadable { losses: damage() });
        }
        let (topic, mut decoder) = scan_topic(topics, options.topic.as_deref(), options.read_as)?;
        decoder.echo = sensor.echo();
        if topic.messages == Some(0) {
            return Err(IngestError::NoScans { topic: topic.name, losses: damage() });
        }
        let odometry = OdometryReader::new(&containers, &options.csv, sensor.odometry_topic());
        let turns = Turns::new(!decoder.gives_clouds(), sensor.finds_blind_sectors()).limited(options.waiting_bytes);
        Ok(Self {
            messages: Messages::new(containers, &topic, decoder, losses, options.waiting_bytes),
            odometry,
            turns,
            options: options.clone(),
            sensor,
            topic,
            has_ended: false,
            is_stream: false,
            selected: VecDeque::new(),
            any_decoded: false,
            first_ns: None,
            since_first_s: 0.0,
            starts_at_s: None,
            any_selected: false,
            before: Before::default(),
            turning: Turning::default(),
            scanners: None,
            mount: None,
            wait: Wait::Always,
            is_hurried: false,
            last_log_time_ns: 0,
            reordered: 0,
            of_other_frames: 0,
            last_other_frame: String::new(),
            left_out: Vec::new(),
        })
    }

    /// Recordings of other kinds in the folders that it is opened from (see [`Parts`](crate::Parts)).
    pub fn left_out(&self) -> &[PathBuf] {
        &self.left_out
    }

    /// The topic that the scans are of.
    pub fn topic(&self) -> &str {
        &self.topic.name
    }

    /// Whether its scans are clouds of points, not the ranges of beams.
    pub fn gives_clouds(&self) -> bool {
        self.topic.decoder(self.options.read_as).is_some_and(ScanDecoder::gives_clouds)
    }

    /// How many revolutions there will be if none is lost, as far as that is known before they are read. The first
    /// messages are read ahead, to see whether they are parts of turns.
    pub fn total_revolutions(&mut self) -> Option<u64> {
        let ReadOptions { from_s, to_s, every, .. } = self.options;
        let total = self.topic.messages?;
        if from_s.is_some() || to_s.is_some() || self.sensor.frame_id().is_some() {
            return None;
        }
        while !self.turns.is_settled() && self.read_message() {}
        Some(total.div_ceil(self.turns.messages_in_turn()).div_ceil(every.get()))
    }

    /// When the last revolution was recorded, nanoseconds since the epoch; 0 before the first.
    pub fn last_log_time_ns(&self) -> u64 {
        self.last_log_time_ns
    }

    /// When the first revolution that was given was recorded, seconds after the first scan of the flight.
    pub fn starts_at_s(&self) -> Option<f64> {
        self.starts_at_s
    }

    /// How many scans were recorded later than the scan that came after them in the file; without an index they come
    /// in file order.
    pub fn reordered(&self) -> u64 {
        self.reordered
    }

    /// How many scans were not selected because of their `frame_id`.
    pub fn of_other_frames(&self) -> u64 {
        self.of_other_frames
    }

    /// The parts without scans on that topic.
    pub fn without_topic(&self) -> &[PathBuf] {
        self.messages.without_topic()
    }

    /// What was lost up to now. All of it is known once there are no more revolutions.
    pub fn losses(&self) -> &[Loss] {
        self.messages.losses()
    }

    /// Reads a message and adds it to the turns, unless it is of another frame than the one asked for; `false` at the
    /// end.
    fn read_message(&mut self) -> bool {
        let place = self.turns.place();
        let Some(message) = self.messages.next(place) else { return false };
        match (&message.scan, self.sensor.frame_id()) {
            (Ok(scan), Some(wanted)) if scan.header().frame_id != wanted => {
                self.of_other_frames += 1;
                self.last_other_frame.clone_from(&scan.header().frame_id);
                self.start(&message);
            }
            (scan, _) => {
                if let Ok(scan) = scan
                    && let Some((yaw_rad, upside_down, tilt)) =
                        self.mount.take().and_then(|mut mount| mount.of(&scan.header().frame_id))
                {
                    self.sensor = self.sensor.clone().mounted(yaw_rad, upside_down, tilt);
                }
                self.turns.push(message, &self.sensor);
            }
        }
        true
    }

    /// The next turn, whether it is asked for or not.
    fn next_turn(&mut self) -> Option<Turn> {
        loop {
            if let Some(mut turn) = self.turns.pop(&self.sensor) {
                if self.sensor.deskews()
                    && let Some(scan) = turn.laser_scan()
                {
                    (turn.rad_per_beam, turn.beam_s) = self.turning.per_beam(scan);
                }
                return Some(turn);
            }
            if self.has_ended {
                return None;
            }
            let is_learning = !self.turns.is_settled() && self.wait == Wait::Always && !self.is_hurried;
            self.messages.wait(if is_learning { Wait::Learning } else { self.wait });
            if self.read_message() {
                continue;
            }
            if !self.messages.is_waiting() {
                self.turns.finish(&self.sensor);
                self.has_ended = true;
            } else if mem::replace(&mut self.is_hurried, true) {
                return None;
            } else {
                self.turns.hurry();
            }
        }
    }

    /// When the flight starts, by its first scan.
    fn start(&mut self, first: &Turn) -> u64 {
        match self.first_ns {
            Some(first_ns) => first_ns,
            None => {
                let first_ns =
                    if first.odd_time.is_none() { first.recorded_ns } else { self.messages.clock().start_ns() };
                *self.first_ns.insert(first_ns)
            }
        }
    }

    /// Whether the turn is asked for. Past the end, a part in order of log time is left as a whole.
    fn select(&mut self, turn: &Turn) -> bool {
        let first_ns = self.start(turn);
        let since_first_s = (i128::from(turn.recorded_ns) - i128::from(first_ns)) as f64 / NS_PER_S;
        if self.options.to_s.is_some_and(|to_s| since_first_s > to_s) {
            self.has_ended |= self.is_stream;
            if turn.odd_time.is_none() {
                self.messages.leave_part(turn.part);
            }
            return false;
        }
        self.since_first_s = since_first_s;
        let is_selected = turn.seq.is_multiple_of(self.options.every.get())
            && self.options.from_s.is_none_or(|from_s| since_first_s >= from_s);
        self.any_selected |= is_selected;
        is_selected
    }

    /// Why there was nothing to give although there are scans, if that is so: nobody asks for nothing.
    fn nothing_selected(&self) -> Option<SourceError> {
        let topic = &self.topic.name;
        if let Some(wanted) = self.sensor.frame_id()
            && !self.any_decoded
            && self.of_other_frames > 0
        {
            return Some(SourceError(format!(
                "ingest.frame_id is {wanted:?}, but none of the {} scans of {topic} is of that frame; the last one is of {:?}",
                self.of_other_frames, self.last_other_frame
            )));
        }
        if self.any_selected || self.first_ns.is_none() {
            return None;
        }
        let ReadOptions { from_s, to_s, every, .. } = self.options;
        let from_s = from_s.unwrap_or(0.0);
        let to = to_s.map_or_else(|| "on".to_owned(), |to_s| format!("to {to_s} s"));
        let nth = if every.get() > 1 { format!("whose number is a multiple of {every} ") } else { String::new() };
        Some(SourceError(format!(
            "no scan of {topic} {nth}was recorded from {from_s} s {to}; the last one before that is at {:.1} s",
            self.since_first_s
        )))
    }

    /// Writes what `turn` shows into `out`.
    fn give(&mut self, turn: &Turn, out: &mut Revolution, notes: &mut Notes) {
        self.note_order(turn.log_time_ns, notes);
        let motion;
        match &turn.scan {
            Ok(scan) => {
                notes.extend(turn.odd_time);
                let sent_ns = scan.header().stamp.to_ns().unwrap_or(0);
                let (stamp_ns, note) = self.messages.clock().stamp_ns(sent_ns, turn.recorded_ns);
                motion = self.motion(turn, stamp_ns);
                self.turns.show(turn, scan, motion.as_ref(), &self.sensor, out, notes);
                out.stamp_ns = stamp_ns;
                notes.extend(note);
                self.before.compare(out, notes);
            }
            Err(cause) => {
                out.clear();
                out.stamp_ns = turn.recorded_ns;
                motion = self.motion(turn, out.stamp_ns);
                out.sweep.get_or_insert_default();
                notes.add(N045, format!("the message cannot be decoded: {cause}"));
            }
        }
        out.seq = turn.seq;
        out.odometry = motion.map(|motion| motion.middle());
    }

    /// How the vehicle moves during a turn with this stamp, by odometry.
    fn motion(&mut self, turn: &Turn, stamp_ns: u64) -> Option<Motion> {
        let odometry = self.odometry.as_mut()?;
        let times_s = match &turn.scan {
            Ok(scan) if self.sensor.deskews() => times_s(scan, turn.beam_s),
            _ => [0.0; 2],
        };
        let mut motion = Motion::during(stamp_ns, times_s, |stamps_ns| odometry.at(stamps_ns, turn.recorded_ns))?;
        motion.is_of_sensor = turn.scan.as_ref().is_ok_and(|scan| odometry.is_of(&scan.header().frame_id));
        Some(motion)
    }

    /// Notes a turn that was recorded before the one that was given last.
    fn note_order(&mut self, log_time_ns: u64, notes: &mut Notes) {
        let clock = self.messages.clock();
        if log_time_ns < self.last_log_time_ns && clock.believes(log_time_ns) && clock.believes(self.last_log_time_ns) {
            self.reordered += 1;
            let back_s = (self.last_log_time_ns - log_time_ns) as f64 / NS_PER_S;
            notes.add(N044, format!("recorded {back_s:.3} s before the scan before it"));
        }
        self.last_log_time_ns = log_time_ns;
        self.starts_at_s.get_or_insert(self.since_first_s);
    }
}

impl Scans for Recording {
    fn topic(&self) -> &str {
        &self.topic.name
    }

    fn losses(&self) -> &[Loss] {
        self.messages.losses()
    }

    fn wait(&mut self, wait: Wait) {
        self.wait = wait;
    }

    fn is_waiting(&self) -> bool {
        !self.has_ended && self.messages.is_waiting()
    }
}

impl Source for Recording {
    fn next(&mut self, out: &mut Revolution, notes: &mut Notes) -> Result<bool, SourceError> {
        loop {
            if self.any_decoded
                && let Some(turn) = self.selected.pop_front()
            {
                self.give(&turn, out, notes);
                if let Some(scanners) = &mut self.scanners {
                    scanners.join(out, turn.recorded_ns, notes);
                    self.messages.add_losses(scanners.losses());
                }
                self.turns.recycle(turn);
                return Ok(true);
            }
            let Some(mut turn) = self.next_turn() else { break };
            if !self.select(&turn) {
                self.turns.recycle(turn);
                continue;
            }
            let undecodable = turn.scan.as_ref().err().map(|cause| (turn.seq, cause.clone()));
            for (seq, cause) in std::mem::take(&mut turn.undecodable).into_iter().chain(undecodable) {
                self.messages.lose(turn.part, seq, cause);
            }
            self.any_decoded |= turn.scan.is_ok();
            self.selected.push_back(turn);
        }
        // Of files, odometry is read a second time, and not to its end: a message that is lost there may be missing
        // anyway.
        let lost = if self.is_stream { OdometryReader::unreadable } else { OdometryReader::unusable };
        if !self.is_waiting()
            && let Some(kind) = self.odometry.as_mut().and_then(lost)
        {
            self.messages.lose_in_first(kind);
        }
        if let Some(why) = self.messages.failure() {
            return Err(SourceError(why));
        }
        if self.is_waiting() {
            return Ok(false);
        }
        match self.selected.front().and_then(|turn| turn.scan.as_ref().err()) {
            Some(cause) => Err(SourceError(format!(
                "none of the {} of {} can be decoded: {cause}",
                counted(self.selected.len() as u64, "message"),
                self.topic.name,
            ))),
            None => self.nothing_selected().map_or(Ok(false), Err),
        }
    }
}
