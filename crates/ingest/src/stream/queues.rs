//! The end of a stream where its messages come out, in a queue for each of its readers.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use crossbeam_channel::{Receiver, RecvTimeoutError};

use super::feed::{Arrival, MOST_WAITING, Missing, info, now_ns};
use crate::container::{ChannelId, Contents, Message, Topic};
use crate::topics::{is_same_name, scan_topic, topics_of};
use crate::{Damage, Following, IngestError, Loss, LossKind, ReadOptions};

/// So long after the first scan, what is not learned by then is done without: nobody waits longer for the first answer.
pub(super) const LEARNING: Duration = Duration::from_secs(1);
/// This many messages of a topic of scans show which topics there are.
const FIRST_SCANS: u64 = 100;
/// A scan of a live robot waits so long for odometry, and for the scans of other scanners.
pub(super) const LIVE_WAIT_NS: u64 = 200_000_000;
/// Between two looks whether waiting is over.
const INTERVAL: Duration = Duration::from_millis(50);

/// The end of a stream where its messages come out.
pub(super) struct Stream {
    pub(super) path: PathBuf,
    pub(super) arrivals: Receiver<Arrival>,
    pub(super) following: Following,
    pub(super) is_live: bool,
    pub(super) topics: BTreeMap<Arc<Topic>, ChannelId>,
    /// How many messages of each topic came.
    pub(super) seen: BTreeMap<ChannelId, u64>,
    /// All messages so far, until it is known which are read.
    pub(super) history: Option<Vec<Message>>,
    pub(super) queues: Vec<Queue>,
    /// Of the messages that wait, and how many may.
    pub(super) bytes: u64,
    pub(super) most_bytes: u64,
    /// The latest time of recording.
    pub(super) latest_ns: u64,
    pub(super) first_scan_at: Option<Instant>,
    pub(super) has_ended: bool,
    pub(super) missing: Arc<Mutex<Missing>>,
    pub(super) losses: Vec<Loss>,
    pub(super) failure: Option<String>,
}

/// The messages of one reader.
#[derive(Default)]
pub(super) struct Queue {
    pub(super) channels: BTreeSet<ChannelId>,
    pub(super) messages: VecDeque<Message>,
}

impl Stream {
    pub(super) fn new(path: PathBuf, arrivals: Receiver<Arrival>, following: &Following, is_live: bool) -> Self {
        Self {
            path,
            arrivals,
            following: following.clone(),
            is_live,
            topics: BTreeMap::new(),
            seen: BTreeMap::new(),
            history: Some(Vec::new()),
            queues: Vec::new(),
            bytes: 0,
            most_bytes: 0,
            latest_ns: 0,
            first_scan_at: None,
            has_ended: false,
            missing: Arc::default(),
            losses: Vec::new(),
            failure: None,
        }
    }

    /// What is known of it so far. Topics of scans without a message are counted as such: they may stay silent.
    pub(super) fn contents(&self) -> Contents {
        let channels: BTreeMap<ChannelId, Topic> =
            self.topics.iter().map(|(topic, &id)| (id, (**topic).clone())).collect();
        let is_other = |id: &ChannelId| channels.get(id).is_none_or(|topic| !info(topic).has_scans());
        let count = |id: &ChannelId| self.seen.get(id).copied().unwrap_or(0).max(u64::from(is_other(id)));
        let counts = channels.keys().map(|id| (*id, count(id))).collect();
        Contents { path: self.path.clone(), format: "stream", channels, counts: Some(counts), ..Contents::default() }
    }

    /// Waits until it is known which topics there are: for a while after the first scan.
    pub(super) fn wait_for_topics(&mut self, options: &ReadOptions) -> Result<(), IngestError> {
        let mut known = 0;
        loop {
            if self.topics.len() != known || self.has_ended {
                known = self.topics.len();
                let topics = topics_of(std::iter::once(&self.contents()));
                match scan_topic(topics, options.topic.as_deref(), options.read_as) {
                    Err(error) if self.has_ended => return Err(self.because(error)),
                    Err(error @ IngestError::NotAScanTopic { .. }) => return Err(error),
                    _ => {}
                }
            }
            let scans = self.topics.iter().filter(|(topic, _)| {
                let is_wanted = options.topic.as_ref().is_none_or(|name| is_same_name(name, &topic.name));
                is_wanted && info(topic).decoder(options.read_as).is_some()
            });
            let first = scans.filter_map(|(_, id)| self.seen.get(id)).copied().max().unwrap_or(0);
            if first > 0 {
                self.first_scan_at.get_or_insert_with(Instant::now);
            }
            let until = self.first_scan_at.map(|at| at + LEARNING);
            let is_known = first >= FIRST_SCANS || self.bytes >= self.most_bytes;
            if self.has_ended || (first > 0 && is_known) || until.is_some_and(|until| until <= Instant::now()) {
                return Ok(());
            }
            self.receive(until);
        }
    }

    /// Why there is nothing to read, once the stream has ended: rather what was lost than what is not there.
    fn because(&mut self, error: IngestError) -> IngestError {
        if let Some(cause) = self.failure.take() {
            return IngestError::NotHeard { path: self.path.clone(), cause };
        }
        if self.topics.is_empty() { IngestError::NothingReadable { losses: self.all_losses() } } else { error }
    }

    /// Takes the next message, if it comes by then; `None` waits as long as it takes.
    pub(super) fn receive(&mut self, until: Option<Instant>) {
        while !self.has_ended {
            if self.following.is_over() {
                let waiting: Vec<Arrival> = self.arrivals.try_iter().take(MOST_WAITING).collect();
                waiting.into_iter().for_each(|arrival| self.take(arrival));
                self.has_ended = true;
                return;
            }
            let left = until.map_or(INTERVAL, |until| until.saturating_duration_since(Instant::now()));
            match self.arrivals.recv_timeout(left.min(INTERVAL)) {
                Ok(arrival) => return self.take(arrival),
                Err(RecvTimeoutError::Disconnected) => self.has_ended = true,
                Err(RecvTimeoutError::Timeout) if left.is_zero() => return,
                Err(RecvTimeoutError::Timeout) => {}
            }
        }
    }

    fn take(&mut self, arrival: Arrival) {
        match arrival {
            Arrival::Topic(topic) => {
                self.channel(&topic);
            }
            Arrival::Message { topic, log_time_ns, data } => {
                let channel = self.channel(&topic);
                *self.seen.entry(channel).or_default() += 1;
                self.latest_ns = self.latest_ns.max(log_time_ns);
                self.queue(Message { channel, log_time_ns, data, damage: None });
            }
            Arrival::Lost(loss) => self.losses.push(loss),
            Arrival::Failed(why) => {
                self.failure = Some(why);
                self.has_ended = true;
            }
        }
    }

    fn channel(&mut self, topic: &Arc<Topic>) -> ChannelId {
        let next = self.topics.len() as ChannelId;
        *self.topics.entry(Arc::clone(topic)).or_insert(next)
    }

    /// Gives a message to all who read its topic.
    fn queue(&mut self, message: Message) {
        let bytes = message.data.len() as u64;
        let wanted = self.queues.iter_mut().filter(|queue| queue.channels.contains(&message.channel));
        let mut wanted: Vec<&mut Queue> = wanted.collect();
        if self.history.is_none() && wanted.is_empty() {
            return;
        }
        if self.bytes.saturating_add(bytes) > self.most_bytes && self.history.is_none() {
            let damage = Damage::TooLarge { bytes: self.bytes + bytes, limit: self.most_bytes };
            let is_known = |loss: &Loss| matches!(&loss.kind, LossKind::Part { damage: Damage::TooLarge { .. }, .. });
            if !self.losses.iter().any(is_known) {
                let kind = LossKind::Part { at_byte: 0, scans: None, damage };
                self.losses.push(Loss { file: self.path.clone(), kind });
            }
            return;
        }
        if let Some(history) = &mut self.history {
            self.bytes += bytes;
            history.push(message);
        } else if let Some(last) = wanted.pop() {
            self.bytes += bytes * (1 + wanted.len() as u64);
            wanted.into_iter().for_each(|queue| queue.messages.push_back(message.clone()));
            last.messages.push_back(message);
        }
    }

    /// All that was lost, once it has ended.
    pub(super) fn all_losses(&mut self) -> Vec<Loss> {
        let mut losses = std::mem::take(&mut self.losses);
        if self.has_ended {
            let missing = std::mem::take(&mut *self.missing.lock().unwrap_or_else(PoisonError::into_inner));
            let on_the_way = missing.on_the_way.into_iter().map(|(topic, count)| LossKind::NotArrived { topic, count });
            let left_out = missing.left_out.into_iter().map(|(topic, count)| LossKind::TooLate { topic, count });
            losses.extend(on_the_way.chain(left_out).map(|kind| Loss { file: self.path.clone(), kind }));
        }
        losses
    }

    /// Whether nothing that was recorded by `recorded_ns` is still to come. A robot may have fallen silent: its stream is past a
    /// time when that is a while ago.
    pub(super) fn is_past(&self, recorded_ns: u64) -> bool {
        self.latest_ns > recorded_ns || (self.is_live && now_ns() > recorded_ns)
    }
}

pub(super) fn lock(stream: &Mutex<Stream>) -> MutexGuard<'_, Stream> {
    stream.lock().unwrap_or_else(PoisonError::into_inner)
}
