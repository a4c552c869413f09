//! The truth that a simulated or labelled recording holds beside its scans.

use std::collections::{BTreeMap, VecDeque};
use std::path::Path;

use crosscut_messages::{JSON_ENCODING, TRUTH_MAP_TOPIC, TRUTH_TOPIC, Truth, TruthError, TruthMap, TruthMapError};

use crate::container::{self, TopicReader};
use crate::{CsvGeometry, IngestError};

/// The truths of one recording. A truth belongs to the scan with the same log time; of several with the same log time,
/// the first to the first.
pub struct Truths {
    reader: TopicReader,
    /// Read, but not asked for yet, by log time.
    waiting: BTreeMap<u64, VecDeque<Result<Truth, TruthError>>>,
}

/// The map of the mine in the recording `path`; `None` if it holds none.
///
/// # Errors
/// When the recording cannot be read; the inner error is that of the message.
pub fn truth_map(path: &Path) -> Result<Option<Result<TruthMap, TruthMapError>>, IngestError> {
    let container = container::open(path, &CsvGeometry::default())?;
    let contents = container.contents();
    let mut channels = contents.channels_of(TRUTH_MAP_TOPIC);
    channels.retain(|id| contents.channels.get(id).is_some_and(|topic| topic.encoding == JSON_ENCODING));
    if channels.is_empty() {
        return Ok(None);
    }
    let mut reader = TopicReader::new(container, channels);
    Ok(reader.next().map(|message| TruthMap::from_json(&message.data)))
}

impl Truths {
    /// Opens the recording `path`.
    ///
    /// # Errors
    /// When it cannot be read, or has no truth.
    pub fn open(path: &Path) -> Result<Self, IngestError> {
        let container = container::open(path, &CsvGeometry::default())?;
        let contents = container.contents();
        let mut channels = contents.channels_of(TRUTH_TOPIC);
        channels.retain(|id| contents.channels.get(id).is_some_and(|topic| topic.encoding == JSON_ENCODING));
        if channels.is_empty() || contents.count(&channels) == Some(0) {
            return Err(IngestError::NoTruth { path: path.to_owned() });
        }
        Ok(Self { reader: TopicReader::new(container, channels), waiting: BTreeMap::new() })
    }

    /// The truth of the next scan that was recorded at `log_time_ns`, if there is one. Scans are asked for in the order
    /// in which [`Recording`](crate::Recording) gives them.
    ///
    /// In a recording without an index, where order says nothing, a missing truth is looked for up to the end, and all
    /// on the way is kept in memory.
    ///
    /// # Errors
    /// When its message cannot be read.
    pub fn at(&mut self, log_time_ns: u64) -> Result<Option<Truth>, TruthError> {
        let in_order = self.reader.container.is_by_log_time();
        if in_order {
            self.waiting = self.waiting.split_off(&log_time_ns);
        }
        while !self.waiting.contains_key(&log_time_ns) {
            if in_order && self.waiting.last_key_value().is_some_and(|(&latest, _)| latest > log_time_ns) {
                break;
            }
            let Some(message) = self.reader.next() else { break };
            let truth = Truth::from_json(&message.data);
            self.waiting.entry(message.log_time_ns).or_default().push_back(truth);
            self.reader.container.recycle(message);
        }
        let Some(same_time) = self.waiting.get_mut(&log_time_ns) else { return Ok(None) };
        let truth = same_time.pop_front();
        if same_time.is_empty() {
            self.waiting.remove(&log_time_ns);
        }
        truth.transpose()
    }
}
