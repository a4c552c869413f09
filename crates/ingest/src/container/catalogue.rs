//! What is in a file: its topics, how many messages each has, and whether it is whole.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use mcap::records::{Channel, ChunkIndex, MessageHeader, Record, SchemaHeader, Statistics, op};

use super::data_section::{DataSection, Step};
use super::records::Visitor;
use super::summary::Summary;
use crate::{Found, IngestError, Loss, LossKind};

/// Enough of a file to tell what it is.
const SNIFFED_BYTES: u64 = 4096;

/// An MCAP file that was opened and looked through.
pub(crate) struct Container {
    pub(crate) path: PathBuf,
    pub(crate) length: u64,
    pub(crate) catalogue: Catalogue,
    /// Chunks by log time, ties by place; empty if there is no index.
    pub(crate) chunks: Vec<ChunkIndex>,
    /// Without an index the whole file was looked through, so all that is lost is known; with one, only what is wrong
    /// with the index.
    pub(crate) losses: Vec<Loss>,
    pub(super) section: DataSection,
}

/// The topics of a file.
#[derive(Default)]
pub(crate) struct Catalogue {
    pub(crate) channels: BTreeMap<u16, Topic>,
    /// Messages of each channel, if they are counted.
    pub(crate) counts: Option<BTreeMap<u16, u64>>,
    /// First and last log time, if there are messages.
    pub(crate) log_time_ns: Option<[u64; 2]>,
}

/// What a channel carries.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Topic {
    pub(crate) name: String,
    pub(crate) type_name: String,
    pub(crate) encoding: String,
}

impl Container {
    pub(crate) fn open(path: &Path) -> Result<Self, IngestError> {
        let failed = |source| IngestError::Open { path: path.to_owned(), source };
        let mut file = File::open(path).map_err(failed)?;
        let length = file.metadata().map_err(failed)?.len();
        let mut start = Vec::new();
        (&mut file).take(SNIFFED_BYTES).read_to_end(&mut start).map_err(failed)?;
        if !start.starts_with(mcap::MAGIC) {
            return Err(IngestError::NotMcap { path: path.to_owned(), found: Found::in_file(&start) });
        }
        let mut section = DataSection::new(file, length).map_err(failed)?;
        let mut losses = Vec::new();
        let mut lost = |kind| losses.push(Loss { file: path.to_owned(), kind });
        let (summary, index_damage) = match Summary::read(section.input(), length) {
            Ok(summary) => (summary.unwrap_or_default(), None),
            Err(damage) => (Summary::default(), Some(damage)),
        };
        let chunks = summary.chunks;
        let mut catalogue = Catalogue::default();
        for channel in summary.channels {
            catalogue.add(&summary.schemas, channel);
        }
        match summary.statistics {
            Some(statistics) if !catalogue.channels.is_empty() && !chunks.is_empty() => catalogue.count(statistics),
            _ => {
                let survey = Survey::of(&mut section);
                if let (Some(damage), true) = (index_damage, survey.complete) {
                    lost(LossKind::Index { damage });
                }
                if chunks.is_empty() {
                    survey.losses.into_iter().for_each(lost);
                }
                catalogue = survey.catalogue;
            }
        }
        Ok(Self { path: path.to_owned(), length, catalogue, chunks, losses, section })
    }

    /// Profile and library of the file, as its first record says.
    pub(crate) fn header(&mut self) -> Option<(String, String)> {
        match self.section.record(mcap::MAGIC.len() as u64, op::HEADER) {
            Ok(Record::Header(header)) => Some((header.profile, header.library)),
            _ => None,
        }
    }

    /// The channels of a topic.
    pub(crate) fn channels_of(&self, topic: &str) -> BTreeSet<u16> {
        self.catalogue.channels.iter().filter(|(_, channel)| channel.name == topic).map(|(&id, _)| id).collect()
    }

    /// How many messages these channels have, if they are counted.
    pub(crate) fn count(&self, channels: &BTreeSet<u16>) -> Option<u64> {
        let counts = self.catalogue.counts.as_ref()?;
        Some(channels.iter().map(|id| counts.get(id).copied().unwrap_or(0)).sum())
    }
}

impl Catalogue {
    /// The first definition of a channel holds.
    fn add(&mut self, schemas: &[SchemaHeader], channel: Channel) {
        let schema = schemas.iter().find(|schema| schema.id == channel.schema_id);
        self.channels.entry(channel.id).or_insert_with(|| Topic {
            name: channel.topic,
            type_name: schema.map(|schema| schema.name.clone()).unwrap_or_default(),
            encoding: channel.message_encoding,
        });
    }

    fn count(&mut self, statistics: Statistics) {
        if statistics.message_count > 0 {
            self.log_time_ns = Some([statistics.message_start_time, statistics.message_end_time]);
        }
        self.counts = Some(statistics.channel_message_counts);
    }
}

/// Looks through a whole file, where there is no summary to say what is in it.
#[derive(Default)]
struct Survey {
    catalogue: Catalogue,
    schemas: Vec<SchemaHeader>,
    /// Channel and log time of the messages that are not settled.
    recent: Vec<(u16, u64)>,
    /// The last message is there: the file is not cut off before it.
    complete: bool,
    losses: Vec<LossKind>,
}

impl Survey {
    fn of(section: &mut DataSection) -> Self {
        let mut survey = Self::default();
        survey.catalogue.counts = Some(BTreeMap::new());
        if let Err(error) = section.rewind() {
            survey.losses.push(LossKind::Rest { at_byte: 0, damage: error.into() });
            return survey;
        }
        loop {
            match section.step(&mut survey) {
                Step::Whole => {}
                Step::Lost { at_byte, damage } => {
                    survey.losses.push(LossKind::Part { at_byte, scans: None, damage });
                }
                Step::End => {
                    survey.complete = true;
                    if survey.losses.is_empty()
                        && let Err(damage) = section.check_whole()
                    {
                        survey.losses.push(LossKind::Altered { damage });
                    }
                    break;
                }
                Step::Stopped { at_byte, damage: crate::Damage::Ended } => {
                    survey.losses.push(LossKind::CutOff { at_byte });
                    break;
                }
                Step::Stopped { at_byte, damage } => {
                    survey.losses.push(LossKind::Rest { at_byte, damage });
                    break;
                }
            }
        }
        survey.count_unknown();
        survey
    }

    fn count_unknown(&mut self) {
        let counts = self.catalogue.counts.iter().flatten();
        let count = counts.filter(|(id, _)| !self.catalogue.channels.contains_key(id)).map(|(_, count)| count).sum();
        if count > 0 {
            self.losses.push(LossKind::UnknownTopic { count });
        }
    }
}

impl Visitor for Survey {
    fn schema(&mut self, schema: SchemaHeader) {
        if self.schemas.iter().all(|known| known.id != schema.id) {
            self.schemas.push(schema);
        }
    }

    fn channel(&mut self, channel: Channel) {
        self.catalogue.add(&self.schemas, channel);
    }

    fn wants(&self, _: &MessageHeader) -> bool {
        false
    }

    fn message(&mut self, header: &MessageHeader, _: &mut Vec<u8>) {
        self.recent.push((header.channel_id, header.log_time));
    }

    fn settle(&mut self, whole: bool) {
        for (channel, log_time_ns) in self.recent.drain(..) {
            if whole {
                *self.catalogue.counts.get_or_insert_default().entry(channel).or_default() += 1;
                let [first, last] = self.catalogue.log_time_ns.unwrap_or([log_time_ns; 2]);
                self.catalogue.log_time_ns = Some([first.min(log_time_ns), last.max(log_time_ns)]);
            }
        }
    }
}
