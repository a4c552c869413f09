//! Which topic carries the scans.

use std::fmt;

use crosscut_messages::{CDR_ENCODING, LaserScan, Message};

use crate::IngestError;
use crate::container::{Container, Topic};

/// A topic of a recording.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TopicInfo {
    /// Its name.
    pub name: String,
    /// Type of its messages; empty if the recording does not say.
    pub type_name: String,
    /// Encoding of its messages.
    pub encoding: String,
    /// How many messages it has, if they are counted.
    pub messages: Option<u64>,
}

/// Topics, one a line when displayed.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TopicList(pub Vec<TopicInfo>);

impl fmt::Display for TopicList {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, topic) in self.0.iter().enumerate() {
            let TopicInfo { name, type_name, encoding, messages } = topic;
            let count = messages.map(|count| format!("{count} messages")).unwrap_or_default();
            let line = format!("  {name}  {type_name}  {encoding}  {count}");
            write!(f, "{}{}", if i == 0 { "" } else { "\n" }, line.trim_end())?;
        }
        Ok(())
    }
}

impl TopicInfo {
    pub(crate) fn has_scans(&self) -> bool {
        self.type_name == LaserScan::SCHEMA_NAME && self.encoding == CDR_ENCODING
    }
}

/// All topics of the containers by name, each counted over all of them.
pub(crate) fn topics_of(containers: &[Container]) -> Vec<TopicInfo> {
    let mut topics: Vec<Topic> = containers.iter().flat_map(|c| c.catalogue.channels.values().cloned()).collect();
    topics.sort();
    topics.dedup();
    let count = |topic: &Topic| {
        let in_one = |container: &Container| {
            let channels = container.catalogue.channels.iter();
            container.count(&channels.filter(|(_, known)| *known == topic).map(|(&id, _)| id).collect())
        };
        containers.iter().map(in_one).sum::<Option<u64>>()
    };
    let info = |topic: Topic| TopicInfo {
        messages: count(&topic),
        name: topic.name,
        type_name: topic.type_name,
        encoding: topic.encoding,
    };
    topics.into_iter().map(info).collect()
}

/// The topic that carries the scans: the one that is asked for, else the only one there is.
pub(crate) fn scan_topic(topics: Vec<TopicInfo>, wanted: Option<&str>) -> Result<TopicInfo, IngestError> {
    match wanted {
        Some(wanted) => wanted_topic(topics, wanted),
        None => only_topic(topics),
    }
}

fn wanted_topic(mut topics: Vec<TopicInfo>, wanted: &str) -> Result<TopicInfo, IngestError> {
    if let Some(topic) = topics.iter().find(|topic| topic.name == wanted && topic.has_scans()) {
        return Ok(topic.clone());
    }
    let is_there = topics.iter().any(|topic| topic.name == wanted);
    let distance = |topic: &TopicInfo| (topic.name != wanted, strsim::damerau_levenshtein(&topic.name, wanted));
    topics.sort_by_cached_key(distance);
    let (wanted, topics) = (wanted.to_owned(), TopicList(topics));
    Err(if is_there {
        IngestError::NotAScanTopic { wanted, topics }
    } else {
        IngestError::NoSuchTopic { wanted, topics }
    })
}

fn only_topic(topics: Vec<TopicInfo>) -> Result<TopicInfo, IngestError> {
    let (scans, others): (Vec<_>, Vec<_>) = topics.into_iter().partition(TopicInfo::has_scans);
    // A sensor that was announced but never sent anything is no candidate beside one that did.
    let with_messages: Vec<_> = scans.iter().filter(|topic| topic.messages != Some(0)).cloned().collect();
    let mut candidates = if with_messages.is_empty() { scans } else { with_messages };
    match candidates.len() {
        0 => Err(IngestError::NoScanTopic { topics: TopicList(others) }),
        1 => Ok(candidates.remove(0)),
        _ => Err(IngestError::SeveralScanTopics { topics: TopicList(candidates) }),
    }
}
