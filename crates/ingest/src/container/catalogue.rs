//! What is in a file: its topics, how many messages each has, and whether it is whole.

use std::collections::BTreeMap;

use mcap::records::{Channel, MessageHeader, SchemaHeader, Statistics};

use super::data_section::{DataSection, Step};
use super::records::Visitor;
use crate::{Damage, LossKind};

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

impl Catalogue {
    /// The first definition of a channel holds.
    pub(super) fn add(&mut self, schemas: &[SchemaHeader], channel: Channel) {
        let schema = schemas.iter().find(|schema| schema.id == channel.schema_id);
        self.channels.entry(channel.id).or_insert_with(|| Topic {
            name: channel.topic,
            type_name: schema.map(|schema| schema.name.clone()).unwrap_or_default(),
            encoding: channel.message_encoding,
        });
    }

    pub(super) fn count(&mut self, statistics: Statistics) {
        if statistics.message_count > 0 {
            self.log_time_ns = Some([statistics.message_start_time, statistics.message_end_time]);
        }
        self.counts = Some(statistics.channel_message_counts);
    }
}

/// Looks through a whole file, where there is no summary to say what is in it.
#[derive(Default)]
pub(super) struct Survey {
    pub(super) catalogue: Catalogue,
    schemas: Vec<SchemaHeader>,
    /// Channel and log time of the messages that are not settled.
    recent: Vec<(u16, u64)>,
    /// Where the messages end; `None` if the file is cut off before that.
    pub(super) end_of_data: Option<u64>,
    pub(super) losses: Vec<LossKind>,
}

impl Survey {
    pub(super) fn of(section: &mut DataSection) -> Self {
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
                Step::End { at_byte } => {
                    survey.end_of_data = Some(at_byte);
                    if survey.losses.is_empty()
                        && let Err(damage) = section.check_whole()
                    {
                        survey.losses.push(LossKind::Altered { damage });
                    }
                    break;
                }
                Step::Stopped { at_byte, damage: Damage::Ended } => {
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
