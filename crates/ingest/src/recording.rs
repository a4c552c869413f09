//! One flight, from one file or several, revolution by revolution.

use std::collections::VecDeque;
use std::num::NonZero;
use std::path::PathBuf;

use crosscut_messages::{DecodeError, ScanDecoder, ScanType};
use crosscut_stage::{Beam, Notes, Revolution, Source, SourceError};

use crate::container::{Container, Message, TopicReader};
use crate::topics::{scan_topic, topics_of};
use crate::turns::{Turn, Turns};
use crate::{IngestError, Loss, LossKind, Parts, Sensor, TopicInfo, parts_in};

const NS_PER_S: f64 = 1e9;

/// Scans are missing, or the clock was set, where a stamp is later than the one before by more than this, and by more than
/// so many times what it was before; after the first scan nobody knows.
const GAP_NS: u64 = 1_000_000_000;
const GAP_TIMES: u64 = 5;

/// Which scans of a recording are wanted.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadOptions {
    /// The scan topic; `None` takes the only one there is.
    pub topic: Option<String>,
    /// What its messages are, whatever the recording calls them; `None` believes the recording.
    pub read_as: Option<ScanType>,
    /// From this many seconds after the first scan's log time.
    pub from_s: Option<f64>,
    /// Up to and with this many seconds after the first scan's log time.
    pub to_s: Option<f64>,
    /// Only messages whose index in the topic is a multiple of this.
    pub every: NonZero<u64>,
}

impl Default for ReadOptions {
    fn default() -> Self {
        Self { topic: None, read_as: None, from_s: None, to_s: None, every: NonZero::<u64>::MIN }
    }
}

/// A recorded flight. It gives one revolution for each scan message that is selected, empty ones too.
pub struct Recording {
    parts: VecDeque<TopicReader>,
    options: ReadOptions,
    sensor: Sensor,
    topic: TopicInfo,
    decoder: ScanDecoder,
    turns: Turns,
    /// Number of the part that is read, and the file of each.
    part: usize,
    files: Vec<PathBuf>,
    has_ended: bool,
    next_seq: u64,
    first_log_time_ns: Option<u64>,
    /// When the last message was recorded that was looked at, seconds after the first.
    since_first_s: f64,
    /// Of the first revolution that was given, the same.
    starts_at_s: Option<f64>,
    /// Whether any message lay in the time asked for.
    any_selected: bool,
    previous: Option<Previous>,
    last_log_time_ns: u64,
    reordered: u64,
    of_other_frames: u64,
    last_other_frame: String,
    without_topic: Vec<PathBuf>,
    losses: Vec<Loss>,
}

/// What the revolution before said, to be compared with the next.
struct Previous {
    stamp_ns: u64,
    /// From a stamp to the next, the last time that they were apart and nothing was missing.
    usual_ns: Option<u64>,
    frame_id: String,
}

impl Recording {
    /// Opens the recordings in `inputs` (see [`parts_in`]) as the parts of one flight, in that order, and finds
    /// the scan topic.
    ///
    /// # Errors
    /// When there is nothing that can be read: what was found instead. A part that is missing, empty or, in a folder, no
    /// recording, is a loss if others are not.
    pub fn open(inputs: &[PathBuf], options: &ReadOptions, sensor: Sensor) -> Result<Self, IngestError> {
        let (containers, mut losses) = open_all(inputs)?;
        let topics = topics_of(&containers);
        let damage = || {
            let of_parts = containers.iter().flat_map(|container| container.losses.clone());
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
        let turns = Turns::new(!decoder.gives_clouds(), sensor.finds_blind_sectors());
        let (mut parts, mut files, mut without_topic) = (VecDeque::new(), Vec::new(), Vec::new());
        for container in containers {
            let channels = topic.channels_in(&container);
            if channels.is_empty() && container.losses.is_empty() {
                without_topic.push(container.path.clone());
            }
            files.push(container.path.clone());
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
            turns,
            part: 0,
            files,
            has_ended: false,
            next_seq: 0,
            first_log_time_ns: None,
            since_first_s: 0.0,
            starts_at_s: None,
            any_selected: false,
            previous: None,
            last_log_time_ns: 0,
            reordered: 0,
            of_other_frames: 0,
            last_other_frame: String::new(),
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
        let is_joined = self.turns.messages_in_turn() > 1;
        let all = from_s.is_none() && to_s.is_none() && self.sensor.frame_id().is_none() && !is_joined;
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
            let part = self.parts.front_mut()?;
            let message = part.next();
            self.losses.extend(part.take_losses());
            self.next_seq += part.take_skipped();
            if let Some(message) = message {
                self.next_seq += 1;
                return Some((self.next_seq - 1, message));
            }
            self.parts.pop_front();
            self.part += 1;
        }
    }

    /// Reads a message and gives it to the turns, unless it is of another frame than the one asked for; `false` at the end.
    fn read_message(&mut self) -> bool {
        let Some((seq, message)) = self.next_message() else { return false };
        let since_first_s = self.since_first_s(message.log_time_ns);
        let mut scan = self.turns.place();
        let decoded = self.decoder.decode_into(&message.data, &mut scan);
        let frame_id = &scan.header().frame_id;
        if decoded.is_ok() && self.sensor.frame_id().is_some_and(|wanted| wanted != frame_id) {
            self.of_other_frames += u64::from(self.is_wanted(seq, since_first_s));
            self.last_other_frame.clone_from(frame_id);
        } else {
            let turn = Turn { scan: decoded.map(|()| scan), ..Turn::new(seq, message.log_time_ns, self.part) };
            self.turns.push(turn, &self.sensor);
        }
        if let Some(part) = self.parts.front_mut() {
            part.recycle(message);
        }
        true
    }

    fn since_first_s(&mut self, log_time_ns: u64) -> f64 {
        let first_ns = *self.first_log_time_ns.get_or_insert(log_time_ns);
        (i128::from(log_time_ns) - i128::from(first_ns)) as f64 / NS_PER_S
    }

    fn is_wanted(&self, seq: u64, since_first_s: f64) -> bool {
        let ReadOptions { from_s, to_s, every, .. } = self.options;
        seq.is_multiple_of(every.get())
            && from_s.is_none_or(|from_s| since_first_s >= from_s)
            && to_s.is_none_or(|to_s| since_first_s <= to_s)
    }

    /// Whether the turn is asked for. Past the end, a part in order of log time is left as a whole.
    fn select(&mut self, turn: &Turn) -> bool {
        let since_first_s = self.since_first_s(turn.log_time_ns);
        if self.options.to_s.is_some_and(|to_s| since_first_s > to_s) {
            if turn.part == self.part
                && self.parts.front().is_some_and(TopicReader::is_by_log_time)
                && let Some(part) = self.parts.pop_front()
            {
                self.next_seq += part.left();
                self.part += 1;
            }
            return false;
        }
        self.since_first_s = since_first_s;
        let is_selected = self.is_wanted(turn.seq, since_first_s);
        self.any_selected |= is_selected;
        is_selected
    }

    /// Why there was nothing to give although there are scans, if that is so: nobody asks for nothing.
    fn nothing_selected(&self) -> Option<SourceError> {
        let topic = &self.topic.name;
        if let Some(wanted) = self.sensor.frame_id()
            && self.previous.is_none()
            && self.of_other_frames > 0
        {
            return Some(SourceError(format!(
                "ingest.frame_id is {wanted:?}, but none of the {} scans of {topic} is of that frame; the last one is of {:?}",
                self.of_other_frames, self.last_other_frame
            )));
        }
        if self.any_selected || self.first_log_time_ns.is_none() {
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
    fn read(&mut self, turn: &mut Turn, out: &mut Revolution, notes: &mut Notes) {
        if turn.log_time_ns < self.last_log_time_ns {
            self.reordered += 1;
            notes.add(format!(
                "recorded {} before the scan before it",
                seconds(self.last_log_time_ns, turn.log_time_ns)
            ));
        }
        self.last_log_time_ns = turn.log_time_ns;
        for (seq, cause) in std::mem::take(&mut turn.undecodable) {
            self.lose_message(turn.part, seq, cause);
        }
        match &turn.scan {
            Ok(scan) => {
                self.sensor.message(scan, out, notes);
                turn.notes.drain(..).for_each(|note| notes.add(note));
                if let (Some(sweep), Some(scan)) = (&mut out.sweep, turn.laser_scan()) {
                    let missing = sweep.beams.iter_mut().zip(&turn.missing).filter(|(_, is_missing)| **is_missing);
                    missing.for_each(|(beam, _)| *beam = Beam::Unknown);
                    self.turns.blind().hide(scan, out, notes);
                }
                if out.stamp_ns == 0 {
                    out.stamp_ns = turn.log_time_ns;
                    notes.add("no stamp: the time of recording is used");
                }
                self.compare_with_previous(out, notes);
            }
            Err(cause) => {
                out.clear();
                out.stamp_ns = turn.log_time_ns;
                out.sweep.get_or_insert_default();
                notes.add(format!("the message cannot be decoded: {cause}"));
                self.lose_message(turn.part, turn.seq, cause.clone());
            }
        }
        out.seq = turn.seq;
        self.starts_at_s.get_or_insert(self.since_first_s);
    }

    fn compare_with_previous(&mut self, revolution: &Revolution, notes: &mut Notes) {
        let Some(previous) = &mut self.previous else {
            let (stamp_ns, frame_id) = (revolution.stamp_ns, revolution.frame_id.clone());
            self.previous = Some(Previous { stamp_ns, usual_ns: None, frame_id });
            return;
        };
        if revolution.stamp_ns == previous.stamp_ns {
            notes.add("the stamp is that of the scan before");
        } else if revolution.stamp_ns < previous.stamp_ns {
            let back = seconds(previous.stamp_ns, revolution.stamp_ns);
            notes.add(format!("the stamp is {back} before that of the scan before"));
        }
        let interval_ns = revolution.stamp_ns.checked_sub(previous.stamp_ns).filter(|&ns| ns > 0);
        let is_gap = |usual_ns: u64| interval_ns.is_some_and(|ns| ns > GAP_NS && ns / GAP_TIMES > usual_ns);
        if previous.usual_ns.is_some_and(is_gap) {
            let on = seconds(revolution.stamp_ns, previous.stamp_ns);
            notes.add(format!("the stamp is {on} after that of the scan before"));
        } else {
            previous.usual_ns = interval_ns.or(previous.usual_ns);
        }
        previous.stamp_ns = revolution.stamp_ns;
        if revolution.frame_id != previous.frame_id {
            notes.add(format!(
                "frame_id `{}` after `{}`; of several sensors on a topic ingest.frame_id takes one",
                revolution.frame_id, previous.frame_id
            ));
            previous.frame_id.clone_from(&revolution.frame_id);
        }
    }

    /// Messages that cannot be decoded are one loss a file, however many they are.
    fn lose_message(&mut self, part: usize, seq: u64, cause: DecodeError) {
        let Some(file) = self.files.get(part) else { return };
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
        loop {
            while let Some(mut turn) = self.turns.pop() {
                let is_selected = self.select(&turn);
                if is_selected {
                    self.read(&mut turn, out, notes);
                }
                self.turns.recycle(turn);
                if is_selected {
                    return Ok(true);
                }
            }
            if self.has_ended {
                break;
            }
            if !self.read_message() {
                self.turns.finish(&self.sensor);
                self.has_ended = true;
            }
        }
        self.nothing_selected().map_or(Ok(false), Err)
    }
}

/// Opens every part. One that `metadata.yaml` names and is not there, or that is no recording, is a loss, as long as
/// another can be read.
fn open_all(inputs: &[PathBuf]) -> Result<(Vec<Container>, Vec<Loss>), IngestError> {
    let Parts { files, missing: mut losses } = parts_in(inputs)?;
    let mut containers = Vec::new();
    for file in &files {
        match Container::open(file) {
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

/// The time from `earlier_ns` to `later_ns` in words.
fn seconds(later_ns: u64, earlier_ns: u64) -> String {
    format!("{:.3} s", later_ns.saturating_sub(earlier_ns) as f64 / NS_PER_S)
}
