//! The end of a stream where its messages come in.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{SystemTime, UNIX_EPOCH};

use crossbeam_channel::{Receiver, SendError, Sender, TrySendError, bounded};
use crosscut_messages::ScanType;

use crate::container::{ChannelId, Topic, Visitor};
use crate::{Loss, TopicInfo};

/// This many messages wait to be taken.
pub(super) const MOST_WAITING: usize = 64;

/// What comes in.
pub(super) enum Arrival {
    Topic(Arc<Topic>),
    Message { topic: Arc<Topic>, log_time_ns: u64, data: Vec<u8> },
    Lost(Loss),
    Failed(String),
}

/// Nobody reads the stream any more.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("nobody reads the messages any more")]
pub struct StreamEnded;

impl<T> From<SendError<T>> for StreamEnded {
    fn from(_: SendError<T>) -> Self {
        Self
    }
}

/// Messages of a live robot that are missing, by topic.
#[derive(Debug, Default)]
pub(super) struct Missing {
    /// Those that did not arrive, by their numbers.
    pub(super) on_the_way: BTreeMap<String, u64>,
    /// Those for which there was no time.
    pub(super) left_out: BTreeMap<String, u64>,
}

/// Takes the messages of a live robot. Whoever hears them must not wait: of more messages than can be taken, the oldest are left
/// out, and counted, for a robot must not be answered late.
#[derive(Clone)]
pub struct Feed {
    sender: Sender<Arrival>,
    oldest: Receiver<Arrival>,
    missing: Arc<Mutex<Missing>>,
}

impl Feed {
    /// A feed, and what its messages come out of.
    pub fn of_robot() -> (Self, LiveFeed) {
        let (sender, oldest) = bounded(MOST_WAITING);
        let missing = Arc::default();
        (Self { sender, oldest: oldest.clone(), missing: Arc::clone(&missing) }, LiveFeed { arrivals: oldest, missing })
    }

    /// Takes a message of ROS 2 in CDR, which arrived now, and how many of its topic are missing before it.
    ///
    /// # Errors
    /// When nobody reads it any more.
    pub fn hear(&self, topic: &str, type_name: &str, data: Vec<u8>, missing: u64) -> Result<(), StreamEnded> {
        let topic = Arc::new(Topic::in_cdr(topic, type_name));
        if missing > 0 {
            *self.missing().on_the_way.entry(topic.name.clone()).or_default() += missing;
        }
        self.put(Arrival::Message { topic, log_time_ns: now_ns(), data })
    }

    /// The robot can no longer be heard: the recording ends with this error.
    ///
    /// # Errors
    /// When nobody reads it any more.
    pub fn fail(&self, why: String) -> Result<(), StreamEnded> {
        self.put(Arrival::Failed(why))
    }

    fn missing(&self) -> MutexGuard<'_, Missing> {
        self.missing.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn put(&self, mut arrival: Arrival) -> Result<(), StreamEnded> {
        loop {
            arrival = match self.sender.try_send(arrival) {
                Ok(()) => return Ok(()),
                Err(TrySendError::Disconnected(_)) => return Err(StreamEnded),
                Err(TrySendError::Full(arrival)) => arrival,
            };
            match self.oldest.try_recv() {
                Ok(Arrival::Message { topic, .. }) => {
                    *self.missing().left_out.entry(topic.name.clone()).or_default() += 1;
                }
                Ok(failed @ Arrival::Failed(_)) => arrival = failed, // nothing counts after it
                _ => {}
            }
        }
    }
}

/// Takes the messages of files. Whoever reads these waits until there is room.
pub(super) struct FileFeed {
    sender: Sender<Arrival>,
    read_as: Option<ScanType>,
}

/// A feed of files, and what its messages come out of.
pub(super) fn of_file(read_as: Option<ScanType>) -> (FileFeed, Receiver<Arrival>) {
    let (sender, arrivals) = bounded(MOST_WAITING);
    (FileFeed { sender, read_as }, arrivals)
}

impl FileFeed {
    pub(super) fn lose(&self, loss: Loss) -> Result<(), StreamEnded> {
        Ok(self.sender.send(Arrival::Lost(loss))?)
    }
}

/// Feeds what is read of one file. What is not known to be whole waits.
pub(super) struct Feeding<'a> {
    feed: &'a FileFeed,
    /// With each channel, whether anybody may want its messages.
    topics: BTreeMap<ChannelId, (Arc<Topic>, bool)>,
    unsettled: Vec<Arrival>,
    pub(super) is_wanted: bool,
}

impl<'a> Feeding<'a> {
    pub(super) fn new(feed: &'a FileFeed) -> Self {
        Self { feed, topics: BTreeMap::new(), unsettled: Vec::new(), is_wanted: true }
    }
}

impl Visitor for Feeding<'_> {
    fn channel(&mut self, id: ChannelId, topic: Topic) {
        let info = info(&topic);
        let may_be_wanted = info.decoder(self.feed.read_as).is_some() || info.has_odometry() || info.has_transforms();
        let (topic, _) = self.topics.entry(id).or_insert_with(|| (Arc::new(topic), may_be_wanted));
        self.unsettled.push(Arrival::Topic(Arc::clone(topic)));
    }

    fn wants(&self, channel: ChannelId) -> bool {
        self.topics.get(&channel).is_some_and(|(_, may_be_wanted)| *may_be_wanted)
    }

    fn message(&mut self, channel: ChannelId, log_time_ns: u64, body: &mut Vec<u8>) {
        if let Some((topic, true)) = self.topics.get(&channel) {
            let (topic, data) = (Arc::clone(topic), std::mem::take(body));
            self.unsettled.push(Arrival::Message { topic, log_time_ns, data });
        }
    }

    fn settle(&mut self, whole: bool) {
        let settled = std::mem::take(&mut self.unsettled).into_iter().filter(|_| whole);
        for arrival in settled {
            self.is_wanted &= self.feed.sender.send(arrival).is_ok();
        }
    }
}

/// What the messages of a live robot come out of; see [`Feed::of_robot`].
pub struct LiveFeed {
    pub(super) arrivals: Receiver<Arrival>,
    pub(super) missing: Arc<Mutex<Missing>>,
}

/// Now, nanoseconds since the epoch.
pub(super) fn now_ns() -> u64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_nanos() as u64)
}

pub(super) fn info(topic: &Topic) -> TopicInfo {
    let Topic { name, type_name, encoding, schema_encoding } = topic.clone();
    TopicInfo { name, type_name, encoding, schema_encoding, messages: None }
}
