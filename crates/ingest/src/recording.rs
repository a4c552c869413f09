//! One flight, from one file or several, revolution by revolution.

use std::collections::VecDeque;
use std::num::NonZero;
use std::path::PathBuf;

use crosscut_messages::{DecodeError, ScanDecoder, ScanMessage, ScanType};
use crosscut_stage::{Notes, Revolution, Source, SourceError, counted};

use crate::before::{Before, seconds};
use crate::clock::{Clock, Times};

use crate::container::{self, Container, Contents, Message, TopicReader};
use crate::topics::{scan_topic, topics_of};
use crate::{CsvGeometry, IngestError, Loss, LossKind, Parts, Sensor, TopicInfo, parts_in};

const NS_PER_S: f64 = 1e9;

/// This many scans are read ahead to find out about the clocks of a recording.
const READ_AHEAD: usize = 64;

/// Which scans of a recording are wanted.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadOptions {
    /// The scan topic; `None` takes the only one there is.
    pub topic: Option<String>,
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
}

impl Default for ReadOptions {
    fn default() -> Self {
        Self {
            topic: None,
            read_as: None,
            from_s: None,
            to_s: None,
            every: NonZero::<u64>::MIN,
            csv: CsvGeometry::default(),
        }
    }
}

/// A recorded flight. It gives one revolution for each scan message that is selected, empty ones too.
pub struct Recording {
    parts: VecDeque<TopicReader>,
    options: ReadOptions,
    sensor: Sensor,
    topic: TopicInfo,
    decoder: ScanDecoder,
    scan: ScanMessage,
    next_seq: u64,
    /// Messages that were read ahead from the part at hand, with their index in the topic.
    ahead: VecDeque<(u64, Message)>,
    /// Times of recording from all over the flight, until `clock` is made of them.
    log_times_ns: Vec<u64>,
    /// Known once messages were read ahead.
    clock: Option<Clock>,
    /// Scans before the first one that can be decoded: if there is none, nothing is given.
    undecodable: VecDeque<Undecodable>,
    any_decoded: bool,
    /// When the first scan was recorded.
    first_ns: Option<u64>,
    /// When the last message was recorded that was looked at, seconds after the first.
    since_first_s: f64,
    /// Of the first revolution that was given, the same.
    starts_at_s: Option<f64>,
    /// Whether any message lay in the time asked for.
    any_selected: bool,
    before: Before,
    last_log_time_ns: u64,
    reordered: u64,
    of_other_frames: u64,
    without_topic: Vec<PathBuf>,
    losses: Vec<Loss>,
}

/// A scan message that cannot be decoded.
struct Undecodable {
    seq: u64,
    log_time_ns: u64,
    recorded_ns: u64,
    cause: DecodeError,
}

impl Recording {
    /// Opens the recordings in `inputs` (see [`parts_in`]) as the parts of one flight, in that order, and finds
    /// the scan topic.
    ///
    /// # Errors
    /// When there is nothing that can be read: what was found instead. A part that is missing, empty or, in a folder, no
    /// recording, is a loss if others are not.
    pub fn open(inputs: &[PathBuf], options: &ReadOptions, sensor: Sensor) -> Result<Self, IngestError> {
        let (containers, mut losses) = open_all(inputs, &options.csv)?;
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
        let log_times_ns = contents().flat_map(|contents| contents.log_times_ns.taken().to_vec()).collect();
        let (mut parts, mut without_topic) = (VecDeque::new(), Vec::new());
        for container in containers {
            let Contents { path, losses: known, .. } = container.contents();
            let channels = topic.channels_in(container.contents());
            if channels.is_empty() && known.is_empty() {
                without_topic.push(path.clone());
            }
            let mut part = TopicReader::new(container, channels);
            losses.extend(part.take_losses());
            parts.push_back(part);
        }
        Ok(Self {
            parts,
            options: options.clone(),
            sensor,
            topic,
            decoder,
            scan: ScanMessage::default(),
            next_seq: 0,
            ahead: VecDeque::new(),
            log_times_ns,
            clock: None,
            undecodable: VecDeque::new(),
            any_decoded: false,
            first_ns: None,
            since_first_s: 0.0,
            starts_at_s: None,
            any_selected: false,
            before: Before::default(),
            last_log_time_ns: 0,
            reordered: 0,
            of_other_frames: 0,
            without_topic,
            losses,
        })
    }

    /// The topic that the scans are of.
    pub fn topic(&self) -> &str {
        &self.topic.name
    }

    /// How many revolutions there will be if none is lost, as far as that is known before they are read.
    pub fn total_messages(&self) -> Option<u64> {
        let ReadOptions { from_s, to_s, .. } = self.options;
        let all = from_s.is_none() && to_s.is_none() && self.sensor.frame_id().is_none();
        self.topic.messages.filter(|_| all).map(|total| total.div_ceil(self.options.every.get()))
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
        &self.without_topic
    }

    /// What was lost up to now. All of it is known once there are no more revolutions.
    pub fn losses(&self) -> &[Loss] {
        &self.losses
    }

    /// The next message with its index in the topic, from whichever part is at hand.
    fn next_message(&mut self) -> Option<(u64, Message)> {
        loop {
            if let Some(message) = self.ahead.pop_front().or_else(|| self.read_message()) {
                return Some(message);
            }
            self.parts.pop_front()?;
        }
    }

    /// The next message of the part at hand.
    fn read_message(&mut self) -> Option<(u64, Message)> {
        let part = self.parts.front_mut()?;
        let message = part.next();
        self.losses.extend(part.take_losses());
        self.next_seq += part.take_skipped();
        let seq = self.next_seq;
        self.next_seq += u64::from(message.is_some());
        Some((seq, message?))
    }

    /// Reads the first messages of the flight ahead, and makes the clock of their times.
    fn read_ahead(&mut self) -> Clock {
        while self.ahead.len() < READ_AHEAD && !self.parts.is_empty() {
            match self.read_message() {
                Some(message) => self.ahead.push_back(message),
                None if self.ahead.is_empty() => drop(self.parts.pop_front()),
                None => break,
            }
        }
        let mut first = Vec::new();
        for (_, message) in &self.ahead {
            let is_decoded = self.decoder.decode_into(&message.data, &mut self.scan).is_ok();
            let stamp_ns = self.scan.header().stamp.to_ns().filter(|_| is_decoded).unwrap_or(0);
            first.push(Times { log_ns: message.log_time_ns, stamp_ns });
        }
        Clock::new(&first, self.log_times_ns.drain(..))
    }

    /// Whether a message is asked for that was recorded at `recorded_ns`. Past the end, a part in order of log time is
    /// left as a whole.
    fn select(&mut self, seq: u64, recorded_ns: u64, is_in_order: bool, clock: Clock) -> bool {
        let first_ns = *self.first_ns.get_or_insert(if is_in_order { recorded_ns } else { clock.start_ns() });
        let since_first_s = (i128::from(recorded_ns) - i128::from(first_ns)) as f64 / NS_PER_S;
        if self.options.to_s.is_some_and(|to_s| since_first_s > to_s) {
            if is_in_order
                && clock.believes_all()
                && self.parts.front().is_some_and(TopicReader::is_by_log_time)
                && let Some(part) = self.parts.pop_front()
            {
                self.ahead.clear();
                self.next_seq += part.left();
            }
            return false;
        }
        self.since_first_s = since_first_s;
        let is_selected = seq.is_multiple_of(self.options.every.get())
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
                self.of_other_frames,
                self.scan.header().frame_id
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

    /// Reads a message into `scan`, and tells when it was recorded.
    fn decode(&mut self, message: &Message, clock: Clock) -> (Result<(), DecodeError>, u64, Option<&'static str>) {
        let decoded = self.decoder.decode_into(&message.data, &mut self.scan);
        let stamp_ns = self.scan.header().stamp.to_ns().filter(|_| decoded.is_ok()).unwrap_or(0);
        let (recorded_ns, note) = clock.recorded_ns(Times { log_ns: message.log_time_ns, stamp_ns });
        (decoded, recorded_ns, note)
    }

    /// Writes the scan that was decoded last into `out`.
    fn give(&mut self, recorded_ns: u64, clock: Clock, out: &mut Revolution, notes: &mut Notes) {
        self.sensor.message(&self.scan, out, notes);
        let (stamp_ns, note) = clock.stamp_ns(out.stamp_ns, recorded_ns);
        out.stamp_ns = stamp_ns;
        note.into_iter().for_each(|note| notes.add(note));
        self.before.compare(out, notes);
    }

    /// Writes an empty revolution into `out`, in place of a scan that cannot be decoded.
    fn give_undecodable(&mut self, scan: Undecodable, out: &mut Revolution, notes: &mut Notes) {
        self.note_order(scan.log_time_ns, notes);
        out.clear();
        (out.seq, out.stamp_ns) = (scan.seq, scan.recorded_ns);
        out.sweep.get_or_insert_default();
        notes.add(format!("the message cannot be decoded: {}", scan.cause));
    }

    /// Notes a scan that was recorded before the one that was given last.
    fn note_order(&mut self, log_time_ns: u64, notes: &mut Notes) {
        let is_believed = |ns| self.clock.is_none_or(|clock| clock.believes(ns));
        if log_time_ns < self.last_log_time_ns && is_believed(log_time_ns) && is_believed(self.last_log_time_ns) {
            self.reordered += 1;
            notes.add(format!("recorded {} before the scan before it", seconds(self.last_log_time_ns, log_time_ns)));
        }
        self.last_log_time_ns = log_time_ns;
        self.starts_at_s.get_or_insert(self.since_first_s);
    }

    /// Takes back the buffer of a message.
    fn recycle(&mut self, message: Message) {
        if let Some(part) = self.parts.front_mut() {
            part.recycle(message);
        }
    }

    /// Messages that cannot be decoded are one loss a file, however many they are.
    fn lose_message(&mut self, seq: u64, cause: DecodeError) {
        let Some(part) = self.parts.front() else { return };
        let file = &part.contents().path;
        let known = self.losses.iter_mut().filter(|loss| loss.file == *file).find_map(|loss| match &mut loss.kind {
            LossKind::Messages { count, .. } => Some(count),
            _ => None,
        });
        match known {
            Some(count) => *count += 1,
            None => {
                let kind = LossKind::Messages { topic: self.topic.name.clone(), first_seq: seq, count: 1, cause };
                self.losses.push(Loss { file: file.clone(), kind });
            }
        }
    }
}

impl Source for Recording {
    fn next(&mut self, out: &mut Revolution, notes: &mut Notes) -> Result<bool, SourceError> {
        let clock = match self.clock {
            Some(clock) => clock,
            None => self.read_ahead(),
        };
        self.clock = Some(clock);
        loop {
            if self.any_decoded
                && let Some(scan) = self.undecodable.pop_front()
            {
                self.give_undecodable(scan, out, notes);
                return Ok(true);
            }
            let Some((seq, message)) = self.next_message() else { break };
            let (decoded, recorded_ns, odd_time) = self.decode(&message, clock);
            let is_of_frame =
                decoded.is_err() || self.sensor.frame_id().is_none_or(|wanted| wanted == self.scan.header().frame_id);
            if self.select(seq, recorded_ns, odd_time.is_none(), clock) && is_of_frame {
                self.any_decoded |= decoded.is_ok();
                if let Err(cause) = decoded {
                    self.lose_message(seq, cause.clone());
                    let log_time_ns = message.log_time_ns;
                    self.undecodable.push_back(Undecodable { seq, log_time_ns, recorded_ns, cause });
                } else if self.undecodable.is_empty() {
                    self.note_order(message.log_time_ns, notes);
                    odd_time.into_iter().for_each(|note| notes.add(note));
                    self.give(recorded_ns, clock, out, notes);
                    out.seq = seq;
                    self.recycle(message);
                    return Ok(true);
                } else {
                    self.ahead.push_front((seq, message)); // after those that were held back
                    continue;
                }
            } else if !is_of_frame {
                self.of_other_frames += 1;
            }
            self.recycle(message);
        }
        match self.undecodable.front() {
            Some(scan) => Err(SourceError(format!(
                "none of the {} of {} can be decoded: {}",
                counted(self.undecodable.len() as u64, "message"),
                self.topic.name,
                scan.cause
            ))),
            None => self.nothing_selected().map_or(Ok(false), Err),
        }
    }
}

/// The parts of a flight that can be read, and what is missing of it.
type Opened = (Vec<Box<dyn Container>>, Vec<Loss>);

/// Opens every part of a flight. One that `metadata.yaml` names and is not there, or that is no recording, is a loss, as long as
/// another can be read.
pub(crate) fn open_all(inputs: &[PathBuf], csv: &CsvGeometry) -> Result<Opened, IngestError> {
    let Parts { files, missing: mut losses } = parts_in(inputs)?;
    let mut containers = Vec::new();
    for file in &files {
        match container::open(file, csv) {
            Ok(container) => containers.push(container),
            Err(error) => {
                let is_one_of_several = files.len() > 1 || !inputs.contains(file);
                let loss = error.as_loss(inputs.contains(file)).filter(|_| is_one_of_several);
                losses.push(loss.ok_or(error)?);
            }
        }
    }
    if containers.is_empty() { Err(IngestError::NothingReadable { losses }) } else { Ok((containers, losses)) }
}
