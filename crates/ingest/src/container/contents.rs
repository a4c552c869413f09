//! A file of a flight as its readers see it: its topics, how many messages each has, when they were recorded, whether it is
//! whole, and its messages in order.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::sync::Arc;

use crosscut_messages::{CDR_ENCODING, SCHEMA_ENCODING};
use tempfile::TempPath;

use crate::Loss;

/// Number of a channel in its file. Several channels may carry one topic.
pub(crate) type ChannelId = u32;

/// What is in a file.
#[derive(Clone, Debug, Default)]
pub(crate) struct Contents {
    pub(crate) path: PathBuf,
    /// Where its bytes are, if it is compressed as a whole, or standard input.
    pub(crate) temporary: Option<Arc<TempPath>>,
    /// Size of the file.
    pub(crate) bytes: u64,
    /// Name of the format, such as `MCAP`.
    pub(crate) format: &'static str,
    /// What else there is to say of the file: a name (`index`) and its value, empty if the file does not say.
    pub(crate) properties: Vec<(&'static str, String)>,
    /// What each channel carries.
    pub(crate) channels: BTreeMap<ChannelId, Topic>,
    /// Messages of each channel, if they are counted.
    pub(crate) counts: Option<BTreeMap<ChannelId, u64>>,
    /// Log times from all over the file.
    pub(crate) log_times_ns: TimeSample,
    /// What is known to be lost since the file was opened. Where the file had to be looked through as a whole, that is
    /// everything; otherwise only what is wrong with its index.
    pub(crate) losses: Vec<Loss>,
}

/// What a channel carries.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Topic {
    /// Its name.
    pub(crate) name: String,
    /// Name of the type of its messages; empty if the file does not say.
    pub(crate) type_name: String,
    /// Encoding of the messages: `cdr`, `ros1`, `json`, `protobuf`...
    pub(crate) encoding: String,
    /// Encoding of the type's definition: `ros2msg`, `ros1msg`, `jsonschema`...; empty if the file does not say.
    pub(crate) schema_encoding: String,
}

impl Topic {
    /// Of messages of ROS 2 in CDR.
    pub(crate) fn in_cdr(name: &str, type_name: &str) -> Self {
        let [name, type_name, encoding, schema_encoding] =
            [name, type_name, CDR_ENCODING, SCHEMA_ENCODING].map(str::to_owned);
        Self { name, type_name, encoding, schema_encoding }
    }
}

/// Times from all over a file, evenly spaced among those that were added; a few hundred, however many these are.
#[derive(Clone, Debug, Default)]
pub(crate) struct TimeSample {
    /// The earliest and the latest of all, if there are any.
    pub(crate) span_ns: Option<[u64; 2]>,
    taken: Vec<u64>,
    /// Of this many, one is taken; 0 stands for 1.
    stride: u64,
    added: u64,
}

impl TimeSample {
    const MOST: usize = 512;

    pub(crate) fn add(&mut self, ns: u64) {
        let [first, last] = self.span_ns.unwrap_or([ns; 2]);
        self.span_ns = Some([first.min(ns), last.max(ns)]);
        if self.taken.len() == Self::MOST {
            self.stride = self.stride.max(1) * 2;
            let mut index = 0;
            self.taken.retain(|_| {
                index += 1;
                index % 2 == 1
            });
        }
        if self.added.is_multiple_of(self.stride.max(1)) {
            self.taken.push(ns);
        }
        self.added += 1;
    }

    pub(crate) fn taken(&self) -> &[u64] {
        &self.taken
    }
}

impl Contents {
    /// The channels of a topic.
    pub(crate) fn channels_of(&self, topic: &str) -> BTreeSet<ChannelId> {
        self.channels.iter().filter(|(_, channel)| channel.name == topic).map(|(&id, _)| id).collect()
    }

    /// How many messages these channels have, if they are counted.
    pub(crate) fn count(&self, channels: &BTreeSet<ChannelId>) -> Option<u64> {
        let counts = self.counts.as_ref()?;
        Some(channels.iter().fold(0, |sum: u64, id| sum.saturating_add(counts.get(id).copied().unwrap_or(0))))
    }
}

/// One file of a flight that was opened and looked through.
pub(crate) trait Container: Send {
    /// What is in it.
    fn contents(&self) -> &Contents;

    /// What is in it, to be completed by whoever opened it.
    fn contents_mut(&mut self) -> &mut Contents;

    /// From now on, [`next`](Self::next) gives the messages of these channels, from the first. The file stays closed
    /// until then: a flight may have more parts than a process may have files open.
    fn select(&mut self, channels: &BTreeSet<ChannelId>);

    /// Another reader of the same stream; `None` if this is a file, which can be opened again.
    fn again(&self) -> Option<Box<dyn Container>> {
        None
    }

    /// How long [`next`](Self::next) waits for messages of a stream from now on. Those of a file are there.
    fn wait(&mut self, _: Wait) {}

    /// Whether [`next`](Self::next) gave nothing because it did not come in time, rather than because there is no more.
    fn is_waiting(&self) -> bool {
        false
    }

    /// Why a stream can no longer be read, if that ended it.
    fn failure(&self) -> Option<String> {
        None
    }

    /// Messages that wait for those before them may take this much memory; what exceeds it is lost.
    fn limit_waiting(&mut self, _: u64) {}

    /// The next message of the selected channels; give it back by [`recycle`](Self::recycle).
    fn next(&mut self) -> Option<Message>;

    /// Takes back the buffer of a message.
    fn recycle(&mut self, _: Message) {}

    /// Whether messages come by log time, ties in file order; otherwise they come in file order.
    fn is_by_log_time(&self) -> bool;

    /// How many messages of the selected channels were lost since the last call, as far as that is known.
    fn take_skipped(&mut self) -> u64 {
        0
    }

    /// What was lost since the last call, beside what [`contents`](Self::contents) says.
    fn take_losses(&mut self) -> Vec<Loss>;
}

/// A message as it was recorded.
#[derive(Clone, Debug, Default)]
pub(crate) struct Message {
    pub(crate) channel: ChannelId,
    pub(crate) log_time_ns: u64,
    pub(crate) data: Vec<u8>,
    /// Why there is no data, if it could not be read.
    pub(crate) damage: Option<String>,
}

/// How long a reader waits for its next message.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Wait {
    /// Until it comes, or there are no more.
    #[default]
    Always,
    /// As long as what the first messages show is being learned.
    Learning,
    /// Until the stream is past this time of recording.
    Recorded(u64),
    /// Not at all.
    Never,
}
