//! Looks through a whole file, where there is no index to say what is in it.

use std::collections::BTreeMap;

use super::chunked::{ChunkedFile, Progress, Visitor};
use super::contents::TimeSample;
use super::{ChannelId, Topic};
use crate::{Damage, LossKind};

/// What was found in a file that was looked through.
#[derive(Default)]
pub(super) struct Survey {
    pub(super) channels: BTreeMap<ChannelId, Topic>,
    pub(super) counts: BTreeMap<ChannelId, u64>,
    pub(super) log_times_ns: TimeSample,
    /// Channel and log time of the messages that are not settled.
    recent: Vec<(ChannelId, u64)>,
    /// Where the messages end; `None` if the file is cut off before that.
    pub(super) end_of_data: Option<u64>,
    pub(super) losses: Vec<LossKind>,
}

impl Survey {
    pub(super) fn of(file: &mut impl ChunkedFile) -> Self {
        let mut survey = Self::default();
        if let Err(error) = file.rewind() {
            survey.losses.push(LossKind::Rest { at_byte: 0, damage: error.into() });
            return survey;
        }
        loop {
            match file.step(&mut survey) {
                Progress::Whole => {}
                Progress::Lost { at_byte, damage } => {
                    survey.losses.push(LossKind::Part { at_byte, scans: None, damage });
                }
                Progress::End { at_byte } => {
                    survey.end_of_data = Some(at_byte);
                    if survey.losses.is_empty()
                        && let Err(damage) = file.check_whole()
                    {
                        survey.losses.push(LossKind::Altered { damage });
                    }
                    break;
                }
                Progress::Stopped { at_byte, damage: Damage::Ended } => {
                    survey.losses.push(LossKind::CutOff { at_byte });
                    break;
                }
                Progress::Stopped { at_byte, damage } => {
                    survey.losses.push(LossKind::Rest { at_byte, damage });
                    break;
                }
            }
        }
        let undefined = survey.counts.iter().filter(|(id, _)| !survey.channels.contains_key(id));
        let count = undefined.map(|(_, count)| count).sum();
        if count > 0 {
            survey.losses.push(LossKind::UnknownTopic { count });
        }
        survey
    }
}

impl Visitor for Survey {
    fn channel(&mut self, id: ChannelId, topic: Topic) {
        self.channels.entry(id).or_insert(topic); // the first definition holds
    }

    fn wants(&self, _: ChannelId) -> bool {
        false
    }

    fn message(&mut self, channel: ChannelId, log_time_ns: u64, _: &mut Vec<u8>) {
        self.recent.push((channel, log_time_ns));
    }

    fn settle(&mut self, whole: bool) {
        for (channel, log_time_ns) in self.recent.drain(..) {
            if whole {
                *self.counts.entry(channel).or_default() += 1;
                self.log_times_ns.add(log_time_ns);
            }
        }
    }
}
