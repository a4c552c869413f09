//! Which topic carries the scans.

use std::collections::BTreeSet;
use std::fmt;

use crosscut_messages::{CDR_ENCODING, DecodeError, LaserScan, Message as _, ROS1_ENCODING};
use crosscut_stage::counted;

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
            let count = messages.map(|count| counted(count, "message")).unwrap_or_default();
            let type_name = if type_name.is_empty() { "(no schema)" } else { type_name };
            let line = format!("  {name}  {type_name}  {encoding}  {count}");
            write!(f, "{}{}", if i == 0 { "" } else { "\n" }, line.trim_end())?;
        }
        Ok(())
    }
}

impl TopicInfo {
    /// Whether it carries scans that can be read.
    pub fn has_scans(&self) -> bool {
        let readable = [(LaserScan::SCHEMA_NAME, CDR_ENCODING), (LaserScan::ROS1_SCHEMA_NAME, ROS1_ENCODING)];
        readable.contains(&(&self.type_name, &self.encoding))
    }

    /// Reads a message of this topic, which [has scans](Self::has_scans).
    pub(crate) fn decode_into(&self, message: &[u8], scan: &mut LaserScan) -> Result<(), DecodeError> {
        if self.encoding == ROS1_ENCODING { scan.decode_ros1_into(message) } else { scan.decode_into(message) }
    }

    /// The channels of this topic in `container`; another type under the same name is another topic.
    pub(crate) fn channels_in(&self, container: &Container) -> BTreeSet<u16> {
        let is_same = |topic: &Topic| {
            (&topic.name, &topic.type_name, &topic.encoding) == (&self.name, &self.type_name, &self.encoding)
        };
        container.catalogue.channels.iter().filter(|(_, topic)| is_same(topic)).map(|(&id, _)| id).collect()
    }
}

/// All topics of the containers by name, each counted over all of them.
pub(crate) fn topics_of(containers: &[Container]) -> Vec<TopicInfo> {
    let mut topics: Vec<Topic> = containers.iter().flat_map(|c| c.catalogue.channels.values().cloned()).collect();
    topics.sort();
    topics.dedup();
    let info = |Topic { name, type_name, encoding }| {
        let mut info = TopicInfo { name, type_name, encoding, messages: None };
        info.messages = containers.iter().map(|container| container.count(&info.channels_in(container))).sum();
        info
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
