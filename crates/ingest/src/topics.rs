//! Which topic carries the scans.

use std::collections::{BTreeMap, BTreeSet};

use crosscut_messages::{ScanDecoder, ScanType, ros};

use crate::container::{ChannelId, Contents, Topic};
use crate::{IngestError, TopicInfo, TopicList};

impl TopicInfo {
    /// Whether it carries scans that can be read.
    pub fn has_scans(&self) -> bool {
        self.decoder(None).is_some()
    }

    /// Whether it carries odometry that can be read.
    pub(crate) fn has_odometry(&self) -> bool {
        ros::is_odometry(&self.type_name, &self.encoding)
    }

    /// Whether it carries transforms that can be read.
    pub(crate) fn has_transforms(&self) -> bool {
        ros::is_transforms(&self.type_name, &self.encoding)
    }

    /// What reads its messages, if they are scans; `read_as` is believed over the name of their type.
    pub(crate) fn decoder(&self, read_as: Option<ScanType>) -> Option<ScanDecoder> {
        match read_as {
            Some(scan_type) => {
                let own = self.decoder(None).filter(|own| own.scan_type().name().starts_with("foxglove."));
                let is_same = |own: &ScanDecoder| own.gives_clouds() == (scan_type == ScanType::PointCloud2);
                own.filter(is_same).or_else(|| ScanDecoder::for_type(scan_type, &self.encoding))
            }
            None => ScanDecoder::for_schema(&self.type_name, &self.schema_encoding, &self.encoding),
        }
    }

    /// The channels of this topic in a file; another type under the same name is another topic.
    pub(crate) fn channels_in(&self, contents: &Contents) -> BTreeSet<ChannelId> {
        let is_same = |topic: &Topic| {
            (&topic.name, &topic.type_name, &topic.encoding, &topic.schema_encoding)
                == (&self.name, &self.type_name, &self.encoding, &self.schema_encoding)
        };
        contents.channels.iter().filter(|(_, topic)| is_same(topic)).map(|(&id, _)| id).collect()
    }
}

/// All topics of these files by name, each counted over all of them.
pub(crate) fn topics_of<'a>(files: impl Iterator<Item = &'a Contents> + Clone) -> Vec<TopicInfo> {
    let are_counted = files.clone().all(|contents| contents.counts.is_some());
    let mut messages: BTreeMap<&Topic, u64> = BTreeMap::new();
    for contents in files {
        for (id, topic) in &contents.channels {
            let count = contents.counts.as_ref().and_then(|counts| counts.get(id)).copied().unwrap_or(0);
            let sum = messages.entry(topic).or_default();
            *sum = sum.saturating_add(count);
        }
    }
    let info = |(topic, count): (&Topic, u64)| {
        let Topic { name, type_name, encoding, schema_encoding } = topic.clone();
        TopicInfo { name, type_name, encoding, schema_encoding, messages: are_counted.then_some(count) }
    };
    messages.into_iter().map(info).collect()
}

/// The channels of each topic of a file, in the order of [`topics_of`].
pub(crate) fn channels_of_each(contents: &Contents) -> Vec<BTreeSet<ChannelId>> {
    let mut channels: BTreeMap<&Topic, BTreeSet<ChannelId>> = BTreeMap::new();
    for (&id, topic) in &contents.channels {
        channels.entry(topic).or_default().insert(id);
    }
    channels.into_values().collect()
}

/// The topic that carries the scans, and what reads them: the topic that is asked for, else the only one there is.
pub(crate) fn scan_topic(
    topics: Vec<TopicInfo>,
    wanted: Option<&str>,
    read_as: Option<ScanType>,
) -> Result<(TopicInfo, ScanDecoder), IngestError> {
    match wanted {
        Some(wanted) => wanted_topic(topics, wanted, read_as),
        None => only_topic(topics, read_as),
    }
}

/// Whether two names are of one topic: ROS 1 has topics without the slash in front, and people leave it out.
pub(crate) fn is_same_name(one: &str, other: &str) -> bool {
    one.trim_start_matches('/') == other.trim_start_matches('/')
}

fn wanted_topic(
    mut topics: Vec<TopicInfo>,
    wanted: &str,
    read_as: Option<ScanType>,
) -> Result<(TopicInfo, ScanDecoder), IngestError> {
    let is_there = topics.iter().any(|topic| topic.name == wanted);
    let is_wanted = |topic: &&TopicInfo| topic.name == wanted || (!is_there && is_same_name(&topic.name, wanted));
    let found = topics.iter().filter(is_wanted).find_map(|topic| Some((topic.clone(), topic.decoder(read_as)?)));
    if let Some(found) = found {
        return Ok(found);
    }
    let is_there = topics.iter().any(|topic| is_wanted(&topic));
    let distance = |topic: &TopicInfo| (!is_wanted(&topic), strsim::damerau_levenshtein(&topic.name, wanted));
    topics.sort_by_cached_key(distance);
    let (wanted, topics) = (wanted.to_owned(), TopicList(topics));
    Err(if is_there {
        IngestError::NotAScanTopic { wanted, topics }
    } else {
        IngestError::NoSuchTopic { wanted, topics }
    })
}

fn only_topic(topics: Vec<TopicInfo>, read_as: Option<ScanType>) -> Result<(TopicInfo, ScanDecoder), IngestError> {
    let scan_type = |topic: &TopicInfo| topic.decoder(None).map(ScanDecoder::scan_type);
    let is_flat = |topic: &TopicInfo| topic.decoder(None).is_some_and(|decoder| !decoder.gives_clouds());
    // The first of these that a topic meets. Beside a 2D lidar, a cloud may be that of a camera.
    let preferred: &[&dyn Fn(&TopicInfo) -> bool] = match read_as {
        None => &[&is_flat, &TopicInfo::has_scans],
        Some(_) => &[&|topic| scan_type(topic) == read_as, &|topic| topic.type_name.is_empty(), &|_| true],
    };
    let meeting = |is_met: &dyn Fn(&TopicInfo) -> bool| -> Vec<TopicInfo> {
        let is_candidate = |topic: &&TopicInfo| topic.decoder(read_as).is_some() && is_met(topic);
        topics.iter().filter(is_candidate).cloned().collect()
    };
    // A sensor that was announced but never sent anything is no candidate beside one that did.
    let with_messages = preferred.iter().map(|is_met| meeting(&|topic| is_met(topic) && topic.messages != Some(0)));
    let all = preferred.iter().map(|is_met| meeting(is_met));
    let candidates = with_messages.chain(all).find(|candidates| !candidates.is_empty()).unwrap_or_default();
    match &candidates[..] {
        [] => Err(IngestError::NoScanTopic { topics: TopicList(topics) }),
        [only] => {
            let decoder = only.decoder(read_as).expect("it was looked for by this");
            Ok((only.clone(), decoder))
        }
        _ => Err(IngestError::SeveralScanTopics { topics: TopicList(candidates) }),
    }
}
