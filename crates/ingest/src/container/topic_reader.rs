//! The messages of one topic, one after the other.

use std::collections::{BTreeSet, VecDeque};
use std::mem;

use mcap::records::{Channel, ChunkIndex, MessageHeader, Record, SchemaHeader, op};

use super::Container;
use super::data_section::{DataSection, Step};
use super::records::Visitor;
use crate::{Damage, Loss, LossKind};

/// A message of the topic.
#[derive(Default)]
pub(crate) struct Message {
    pub(crate) log_time_ns: u64,
    /// Where its chunk is, then its place among those read: what decides between equal log times.
    order: (u64, u64),
    pub(crate) data: Vec<u8>,
}

/// Reads the messages of one topic: by log time if there is an index, ties in file order; else in file order.
///
/// Memory holds the messages of the chunks that overlap in time.
pub(crate) struct TopicReader {
    container: Container,
    plan: Plan,
    collector: Collector,
    /// Messages that were handed out, or are known to be in chunks that are lost.
    passed: u64,
    /// Those in lost chunks, since the last one that was handed out.
    skipped: u64,
    /// A chunk was lost, and it is not known how many messages with it.
    lost_uncounted: bool,
    /// It is told already that nothing can be read from some place on.
    rest_is_lost: bool,
    losses: Vec<Loss>,
}

enum Plan {
    ByLogTime(VecDeque<ChunkIndex>),
    InFileOrder { ended: bool },
}

impl TopicReader {
    /// The file of `container` is closed until the first message is asked for.
    pub(crate) fn new(mut container: Container, channels: BTreeSet<u16>) -> Self {
        let has_scans = |chunk: &ChunkIndex| {
            let indexed = &chunk.message_index_offsets;
            indexed.is_empty() || channels.iter().any(|id| indexed.contains_key(id))
        };
        let mut losses = mem::take(&mut container.losses);
        let plan = if container.chunks.is_empty() {
            let rested = container.section.rest();
            let ended = rested.is_err();
            losses.extend(rested.err().map(|error| {
                let kind = LossKind::Rest { at_byte: 0, damage: error.into() };
                Loss { file: container.path.clone(), kind }
            }));
            Plan::InFileOrder { ended }
        } else {
            Plan::ByLogTime(container.chunks.iter().filter(|chunk| has_scans(chunk)).cloned().collect())
        };
        let rest_is_lost = losses.iter().any(|loss| matches!(loss.kind, LossKind::Rest { .. }));
        let collector = Collector { channels, ..Collector::default() };
        Self { container, plan, collector, passed: 0, skipped: 0, lost_uncounted: false, rest_is_lost, losses }
    }

    pub(crate) fn container(&self) -> &Container {
        &self.container
    }

    pub(crate) fn into_container(self) -> Container {
        self.container
    }

    /// The next message; give it back by [`TopicReader::recycle`].
    pub(crate) fn next(&mut self) -> Option<Message> {
        match self.plan {
            Plan::ByLogTime(_) => self.read_chunks(),
            // What is damaged was found, and is in the losses, since the file was looked through.
            Plan::InFileOrder { ref mut ended } => {
                while self.collector.queue.is_empty() && !*ended {
                    let step = self.container.section.step(&mut self.collector);
                    *ended = matches!(step, Step::End { .. } | Step::Stopped { .. });
                    // Since then it may have gone.
                    if let Step::Stopped { at_byte, damage: damage @ Damage::Unreadable(_) } = step
                        && !mem::replace(&mut self.rest_is_lost, true)
                    {
                        let kind = LossKind::Rest { at_byte, damage };
                        self.losses.push(Loss { file: self.container.path.clone(), kind });
                    }
                }
            }
        }
        let message = self.collector.take();
        match message {
            Some(_) => self.passed += 1,
            None => self.check_count(),
        }
        message
    }

    /// Reads on until no chunk that is left can have an earlier message than the one that is next.
    fn read_chunks(&mut self) {
        let Plan::ByLogTime(chunks) = &mut self.plan else { return };
        let Self { container, collector, .. } = self;
        while let Some(chunk) = chunks.front()
            && collector.queue.front().is_none_or(|next| chunk.message_start_time <= next.log_time_ns)
        {
            let at_byte = chunk.chunk_start_offset;
            collector.chunk_at_byte = at_byte;
            if let Err(damage) = container.section.chunk(at_byte, collector) {
                let scans = scans_in(chunk, &collector.channels, &mut container.section);
                self.skipped += scans.unwrap_or(0);
                self.passed += scans.unwrap_or(0);
                self.lost_uncounted |= scans.is_none();
                let kind = LossKind::Part { at_byte, scans, damage };
                self.losses.push(Loss { file: container.path.clone(), kind });
            }
            collector.sort();
            chunks.pop_front();
        }
    }

    /// Says so if there were fewer messages than the recording counts, and nothing that is known explains it.
    fn check_count(&mut self) {
        let count = self.left();
        if count > 0 && self.is_by_log_time() && !self.lost_uncounted {
            self.passed += count;
            let known = &self.container.catalogue.channels;
            let topic = self.collector.channels.iter().find_map(|id| known.get(id)).map(|topic| topic.name.clone());
            let kind = LossKind::Missing { topic: topic.unwrap_or_default(), count };
            self.losses.push(Loss { file: self.container.path.clone(), kind });
        }
    }

    /// How many messages are still to come, as the recording counts them.
    pub(crate) fn left(&self) -> u64 {
        self.container.count(&self.collector.channels).unwrap_or(0).saturating_sub(self.passed)
    }

    /// Takes back the buffer of a message.
    pub(crate) fn recycle(&mut self, message: Message) {
        self.collector.spare.push(message.data);
    }

    /// How many messages were lost since the last call, as far as that is known.
    pub(crate) fn take_skipped(&mut self) -> u64 {
        mem::take(&mut self.skipped)
    }

    /// What was lost since the last call.
    pub(crate) fn take_losses(&mut self) -> Vec<Loss> {
        mem::take(&mut self.losses)
    }

    /// Whether messages come by log time, so that none after one that is too late can be in time.
    pub(crate) fn is_by_log_time(&self) -> bool {
        matches!(self.plan, Plan::ByLogTime(_))
    }
}

/// Number of scans in a chunk, by the message indexes behind it.
fn scans_in(chunk: &ChunkIndex, channels: &BTreeSet<u16>, section: &mut DataSection) -> Option<u64> {
    if chunk.message_index_offsets.is_empty() {
        return None;
    }
    let mut scans = 0;
    for at_byte in channels.iter().filter_map(|id| chunk.message_index_offsets.get(id)) {
        let Ok(Record::MessageIndex(index)) = section.record(*at_byte, op::MESSAGE_INDEX) else { return None };
        scans += index.records.len() as u64;
    }
    Some(scans)
}

/// Keeps the messages of the topic in the chunks that were read.
#[derive(Default)]
struct Collector {
    channels: BTreeSet<u16>,
    queue: VecDeque<Message>,
    /// How many of the queue are known to be whole.
    settled: usize,
    spare: Vec<Vec<u8>>,
    chunk_at_byte: u64,
    seen: u64,
}

impl Collector {
    fn sort(&mut self) {
        self.queue.make_contiguous().sort_by_key(|message| (message.log_time_ns, message.order));
    }

    fn take(&mut self) -> Option<Message> {
        let message = self.queue.pop_front();
        self.settled = self.queue.len();
        message
    }
}

impl Visitor for Collector {
    fn schema(&mut self, _: SchemaHeader) {}

    fn channel(&mut self, _: Channel) {}

    fn wants(&self, header: &MessageHeader) -> bool {
        self.channels.contains(&header.channel_id)
    }

    fn message(&mut self, header: &MessageHeader, body: &mut Vec<u8>) {
        if !self.wants(header) {
            return;
        }
        let data = mem::replace(body, self.spare.pop().unwrap_or_default());
        self.seen += 1;
        let order = (self.chunk_at_byte, self.seen);
        self.queue.push_back(Message { log_time_ns: header.log_time, order, data });
    }

    fn settle(&mut self, whole: bool) {
        if !whole {
            self.queue.truncate(self.settled);
        }
        self.settled = self.queue.len();
    }
}
