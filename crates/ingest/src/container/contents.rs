//! What is in a file: its topics, how many messages each has, when they were recorded, and whether the file is whole.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::sync::Arc;

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
    /// Earliest and latest log time, if there are messages.
    pub(crate) log_time_ns: Option<[u64; 2]>,
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

/// Times from all over a file, evenly spaced among those that were added; a few hundred, however many these are.
#[derive(Clone, Debug, Default)]
pub(crate) struct TimeSample {
    taken: Vec<u64>,
    /// Of this many, one is taken; 0 stands for 1.
    stride: u64,
    added: u64,
}

impl TimeSample {
    const MOST: usize = 512;

    pub(crate) fn add(&mut self, ns: u64) {
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
