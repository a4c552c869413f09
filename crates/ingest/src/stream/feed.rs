//! The end of a stream where its messages come in.

use std::collections::BTreeMap;
use std::sync::Arc;

use crossbeam_channel::{Receiver, SendError, Sender, TrySendError, bounded};
use crosscut_messages::{CDR_ENCODING, ScanType};

use super::{LiveFeed, info, now_ns};
use crate::Loss;
use crate::container::{ChannelId, Topic, Visitor};

/// This many messages wait to be taken.
pub(super) const MOST_WAITING: usize = 64;

/// What comes in.
pub(super) enum Arrival {
    Topic(Arc<Topic>),
    Message { topic: Arc<Topic>, log_time_ns: u64, data: Vec<u8> },
    Lost(Loss),
    Missed { topic: Arc<Topic>, count: u64 },
    LeftOut { topic: Arc<Topic>, count: u64 },
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

/// Takes the messages of a live robot. Whoever hears them must not wait: of more messages than can be taken, the oldest are left
/// out, and counted, for a robot must not be answered late.
#[derive(Clone)]
pub struct Feed {
    sender: Sender<Arrival>,
    oldest: Receiver<Arrival>,
}

impl Feed {
    /// A feed, and what its messages come out of.
    pub fn of_robot() -> (Self, LiveFeed) {
        let (sender, oldest) = bounded(MOST_WAITING);
        (Self { sender, oldest: oldest.clone() }, LiveFeed(oldest))
    }

    /// Takes a message of ROS 2 in CDR, which arrived now, and how many of its topic are missing before it.
    ///
    /// # Errors
    /// When nobody reads it any more.
    pub fn hear(&self, topic: &str, type_name: &str, data: Vec<u8>, missing: u64) -> Result<(), StreamEnded> {
        let topic = Arc::new(Topic {
            name: topic.to_owned(),
            type_name: type_name.to_owned(),
            encoding: CDR_ENCODING.to_owned(),
            schema_encoding: "ros2msg".to_owned(),
        });
        if missing > 0 {
            self.put(Arrival::Missed { topic: Arc::clone(&topic), count: missing })?;
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

    fn put(&self, arrival: Arrival) -> Result<(), StreamEnded> {
        let mut arrival = arrival;
        loop {
            arrival = match self.sender.try_send(arrival) {
                Ok(()) => return Ok(()),
                Err(TrySendError::Disconnected(_)) => return Err(StreamEnded),
                Err(TrySendError::Full(arrival)) => arrival,
            };
            // One makes room for the message, the other for the count of what was left out.
            for _ in 0..2 {
                let oldest = self.oldest.try_recv();
                if let Ok(Arrival::Message { topic, .. }) = oldest {
                    self.sender.try_send(Arrival::LeftOut { topic, count: 1 }).ok();
                } else if let Ok(counted) = oldest {
                    self.sender.try_send(counted).ok();
                }
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
