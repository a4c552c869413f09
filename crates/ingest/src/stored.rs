//! Messages as they are stored, for programs that read again what they wrote: with the limits of any other file.

use std::collections::BTreeMap;
use std::path::Path;

use crate::container::{self, TopicReader};
use crate::{CsvGeometry, IngestError};

/// The messages of some topics of a file.
pub struct Stored {
    reader: TopicReader,
}

/// A message as it was written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StoredMessage {
    /// Its topic.
    pub topic: String,
    /// When it was recorded, nanoseconds since the epoch.
    pub log_time_ns: u64,
    /// Its bytes.
    pub data: Vec<u8>,
}

impl Stored {
    /// Opens the file for these topics. Of a damaged file, the messages that are whole are read.
    ///
    /// # Errors
    /// When it cannot be opened or is no recording.
    pub fn open(path: &Path, topics: &[&str]) -> Result<Self, IngestError> {
        let container = container::open(path, &CsvGeometry::default())?;
        let channels = topics.iter().flat_map(|topic| container.contents().channels_of(topic)).collect();
        Ok(Self { reader: TopicReader::new(container, channels) })
    }

    /// What the writer of an MCAP says of it under this name, before its first message; nothing if it says nothing.
    ///
    /// # Errors
    /// When the file cannot be opened.
    pub fn metadata(path: &Path, name: &str) -> Result<BTreeMap<String, String>, IngestError> {
        let failed = |source| IngestError::cannot_open(path, source);
        Ok(container::mcap_metadata(path, name).map_err(failed)?.unwrap_or_default())
    }
}

impl Iterator for Stored {
    type Item = StoredMessage;

    fn next(&mut self) -> Option<StoredMessage> {
        let message = self.reader.next()?;
        let topic = self.reader.container.contents().channels.get(&message.channel).map(|topic| topic.name.clone());
        Some(StoredMessage { topic: topic?, log_time_ns: message.log_time_ns, data: message.data })
    }
}
