//! The messages of the scan topic, from one part of a flight after the other, with the time at which each was recorded.

use std::collections::VecDeque;
use std::path::PathBuf;

use crosscut_messages::{DecodeError, ScanDecoder, ScanMessage};

use crate::clock::{Clock, Times};
use crate::container::{Container, Message, TopicReader, Wait};

use crate::turns::Turn;
use crate::{Loss, LossKind, TopicInfo};

/// This many messages are read ahead to find out about the clocks of a recording.
const READ_AHEAD: usize = 64;

/// The messages of one topic over all parts of a flight.
pub(crate) struct Messages {
    topic: String,
    parts: VecDeque<TopicReader>,
    /// Number of the part that is read, and the file of each.
    part: usize,
    files: Vec<PathBuf>,
    without_topic: Vec<PathBuf>,
    decoder: ScanDecoder,
    next_seq: u64,
    /// Messages that were read ahead from the part at hand, with their index in the topic.
    ahead: VecDeque<(u64, Message)>,
    /// No more is read ahead once that takes this much.
    waiting_bytes: u64,
    /// Times of recording from all over the flight, until `clock` is made of them.
    log_times_ns: Vec<u64>,
    /// Known once messages were read ahead.
    clock: Option<Clock>,
    losses: Vec<Loss>,
}

impl Messages {
    /// The messages of `topic` in `containers`; `losses` are those of parts that are not among them.
    pub(crate) fn new(
        containers: Vec<Box<dyn Container>>,
        topic: &TopicInfo,
        decoder: ScanDecoder,
        losses: Vec<Loss>,
        waiting_bytes: u64,
    ) -> Self {
        let mut messages = Self {
            topic: topic.name.clone(),
            log_times_ns: containers.iter().flat_map(|one| one.contents().log_times_ns.taken().to_vec()).collect(),
            parts: VecDeque::new(),
            part: 0,
            files: Vec::new(),
            without_topic: Vec::new(),
            decoder,
            next_seq: 0,
            ahead: VecDeque::new(),
            waiting_bytes,
            clock: None,
            losses,
        };
        for container in containers {
            let contents = container.contents();
            let channels = topic.channels_in(contents);
            if channels.is_empty() && contents.losses.is_empty() {
                messages.without_topic.push(contents.path.clone());
            }
            messages.files.push(contents.path.clone());
            let mut part = TopicReader::new(container, channels);
            messages.losses.extend(part.take_losses());
            messages.parts.push_back(part);
        }
        messages
    }

    /// The parts without such messages.
    pub(crate) fn without_topic(&self) -> &[PathBuf] {
        &self.without_topic
    }

    /// What was lost up to now.
    pub(crate) fn losses(&self) -> &[Loss] {
        &self.losses
    }

    /// Adds losses that are not among those that are known.
    pub(crate) fn add_losses<'a>(&mut self, losses: impl Iterator<Item = &'a Loss>) {
        for loss in losses {
            if !self.losses.contains(loss) {
                self.losses.push(loss.clone());
            }
        }
    }

    /// Adds a loss of the first file.
    pub(crate) fn lose_in_first(&mut self, kind: LossKind) {
        let file = self.files.first().cloned().unwrap_or_default();
        self.losses.push(Loss { file, kind });
    }

    /// Adds message `seq`, which cannot be decoded. Such messages are one loss a file, however many they are; lines that
    /// cannot be read were counted when the file was looked through.
    pub(crate) fn lose(&mut self, part: usize, seq: u64, cause: DecodeError) {
        if matches!(cause, DecodeError::Damaged(_)) {
            return;
        }
        let file = &self.files[part];
        let known = self.losses.iter_mut().filter(|loss| loss.file == *file).find_map(|loss| match &mut loss.kind {
            LossKind::Messages { topic, count, .. } if *topic == self.topic => Some(count),
            _ => None,
        });
        match known {
            Some(count) => *count += 1,
            None => {
                let kind = LossKind::Messages { topic: self.topic.clone(), first_seq: seq, count: 1, cause };
                self.losses.push(Loss { file: file.clone(), kind });
            }
        }
    }

    /// The clock of the recording. For that its first messages are read ahead.
    pub(crate) fn clock(&mut self) -> Clock {
        let clock = self.clock.unwrap_or_else(|| self.read_ahead());
        self.clock = Some(clock);
        clock
    }

    /// The next message, decoded into `scan`.
    pub(crate) fn next(&mut self, mut scan: ScanMessage) -> Option<Turn> {
        let clock = self.clock();
        let (seq, message) = self.next_message()?;
        let decoded = match &message.damage {
            Some(cause) => Err(DecodeError::Damaged(cause.clone())),
            None => self.decoder.decode_into(&message.data, &mut scan),
        };
        let stamp_ns = scan.header().stamp.to_ns().filter(|_| decoded.is_ok()).unwrap_or(0);
        let log_time_ns = message.log_time_ns;
        let (recorded_ns, odd_time) = clock.recorded_ns(Times { log_ns: log_time_ns, stamp_ns });
        if let Some(part) = self.parts.front_mut() {
            part.container.recycle(message);
        }
        let scan = decoded.map(|()| scan);
        Some(Turn { log_time_ns, recorded_ns, odd_time, scan, ..Turn::new(seq, self.part) })
    }

    /// How long [`Messages::next`] waits for messages of a stream from now on.
    pub(crate) fn wait(&mut self, wait: Wait) {
        if let Some(part) = self.parts.front_mut() {
            part.container.wait(wait);
        }
    }

    /// Whether there was no message in time, rather than no more.
    pub(crate) fn is_waiting(&self) -> bool {
        self.parts.front().is_some_and(|part| part.container.is_waiting())
    }

    /// Why the stream can no longer be read, if that ended it.
    pub(crate) fn failure(&self) -> Option<String> {
        self.parts.front().and_then(|part| part.container.failure())
    }

    /// Leaves out the rest of a part, if it is the one that is read and its messages come by their times.
    pub(crate) fn leave_part(&mut self, part: usize) {
        if part == self.part
            && self.clock().believes_all()
            && self.parts.front().is_some_and(|part| part.container.is_by_log_time())
            && let Some(left) = self.next_part()
        {
            self.ahead.clear();
            self.next_seq += left.left();
        }
    }

    fn next_part(&mut self) -> Option<TopicReader> {
        self.part += 1;
        self.parts.pop_front()
    }

    /// The next message with its index in the topic, from whichever part is at hand.
    fn next_message(&mut self) -> Option<(u64, Message)> {
        loop {
            if let Some(message) = self.ahead.pop_front().or_else(|| self.read()) {
                return Some(message);
            }
            if self.is_waiting() || self.failure().is_some() {
                return None;
            }
            self.next_part()?;
        }
    }

    /// Reads the next message of the part at hand.
    fn read(&mut self) -> Option<(u64, Message)> {
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
        let mut bytes = 0;
        while self.ahead.len() < READ_AHEAD && bytes < self.waiting_bytes && !self.parts.is_empty() {
            match self.read() {
                Some(message) => {
                    bytes += message.1.data.len() as u64;
                    self.ahead.push_back(message);
                }
                None if self.ahead.is_empty() && !self.is_waiting() && self.failure().is_none() => {
                    drop(self.next_part());
                }
                None => break,
            }
        }
        let (mut scan, mut first) = (ScanMessage::default(), Vec::new());
        for (_, message) in &self.ahead {
            let is_decoded = self.decoder.decode_into(&message.data, &mut scan).is_ok();
            let stamp_ns = scan.header().stamp.to_ns().filter(|_| is_decoded).unwrap_or(0);
            first.push(Times { log_ns: message.log_time_ns, stamp_ns });
        }
        Clock::new(&first, self.log_times_ns.drain(..))
    }
}
