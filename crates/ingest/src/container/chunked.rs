//! Messages of a file that holds them in chunks: by log time if there is an index, else in file order.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::{io, mem};

use super::{ChannelId, Container, Contents, Message, Topic};
use crate::{Damage, Loss, LossKind, limits};

/// A file whose messages stand in chunks, one after the other.
pub(super) trait ChunkedFile: Send {
    /// Goes back to the first record.
    fn rewind(&mut self) -> io::Result<()>;

    /// Goes back to the first record, and closes the file until it is read again.
    fn rest(&mut self) -> io::Result<()>;

    /// Where the next record begins.
    fn at_byte(&self) -> u64;

    /// Hands the next record, or all records of the next chunk, to `visitor`, and settles it.
    fn step(&mut self, visitor: &mut impl Visitor) -> Progress;

    /// Hands all records of the chunk at `at_byte` to `visitor`, and settles it.
    fn chunk(&mut self, at_byte: u64, visitor: &mut impl Visitor) -> Result<(), Damage>;

    /// How many messages of these channels are in a chunk, by the index alone.
    fn messages_in(&mut self, chunk: &ChunkPlace, channels: &BTreeSet<ChannelId>) -> Option<u64>;

    /// Compares all bytes up to where the last step found the end with their checksum, if the file has one.
    fn check_whole(&mut self) -> Result<(), Damage> {
        Ok(())
    }
}

/// A chunk, as the index of its file describes it.
#[derive(Clone, Debug)]
pub(super) struct ChunkPlace {
    pub(super) at_byte: u64,
    /// Its earliest log time.
    pub(super) first_log_time_ns: u64,
    /// For each channel in it, what its file needs to count its messages there. Empty if the index does not say which
    /// channels are in it.
    pub(super) channels: BTreeMap<ChannelId, u64>,
}

/// What one step through a file came to.
pub(super) enum Progress {
    /// A record or a chunk was read whole.
    Whole,
    /// A record or a chunk gave nothing; the next one can be read.
    Lost { at_byte: u64, damage: Damage },
    /// There are no more messages.
    End { at_byte: u64 },
    /// Nothing more can be read; [`Damage::Ended`] if the file is cut off here.
    Stopped { at_byte: u64, damage: Damage },
}

impl Progress {
    /// What the record at `at_byte` came to once it was visited; `visitor` is settled by that. If the file ends in the
    /// record, what is whole in it is kept.
    pub(super) fn settled(
        visited: Result<(), Damage>,
        at_byte: u64,
        is_cut_off: bool,
        visitor: &mut impl Visitor,
    ) -> Self {
        match visited {
            Ok(()) | Err(Damage::Ended) if is_cut_off => {
                visitor.settle(true);
                Self::Stopped { at_byte, damage: Damage::Ended }
            }
            Ok(()) => {
                visitor.settle(true);
                Self::Whole
            }
            Err(damage) => {
                visitor.settle(false);
                Self::Lost { at_byte, damage }
            }
        }
    }
}

/// Receives what a file holds, record by record.
pub(crate) trait Visitor {
    /// A channel is defined.
    fn channel(&mut self, id: ChannelId, topic: Topic);
    /// Whether the bodies of this channel's messages are wanted.
    fn wants(&self, channel: ChannelId) -> bool;
    /// A message, whole; `body` is empty if it was not wanted, and may be taken away.
    fn message(&mut self, channel: ChannelId, log_time_ns: u64, body: &mut Vec<u8>);
    /// Everything since the last call is whole, or else is to be forgotten.
    fn settle(&mut self, whole: bool);
}

/// Reads a chunked file as a [`Container`]. Memory holds the messages of the chunks that overlap in time.
pub(super) struct Chunked<F> {
    file: F,
    contents: Contents,
    /// By log time, ties by place; empty if there is no index.
    chunks: Vec<ChunkPlace>,
    plan: Plan,
    collector: Collector,
    skipped: u64,
    /// It was reported already that nothing can be read from some place on.
    rest_is_lost: bool,
    losses: Vec<Loss>,
}

/// How messages are read.
enum Plan {
    ByLogTime(VecDeque<ChunkPlace>),
    InFileOrder { ended: bool },
}

impl<F: ChunkedFile> Chunked<F> {
    pub(super) fn new(file: F, contents: Contents, chunks: Vec<ChunkPlace>) -> Self {
        let rest_is_lost = contents.losses.iter().any(|loss| matches!(loss.kind, LossKind::Rest { .. }));
        let plan = if chunks.is_empty() { Plan::InFileOrder { ended: true } } else { Plan::ByLogTime(VecDeque::new()) };
        let collector = Collector::default();
        Self { file, contents, chunks, plan, collector, skipped: 0, rest_is_lost, losses: Vec::new() }
    }

    fn lose(&mut self, kind: LossKind) {
        self.losses.push(Loss { file: self.contents.path.clone(), kind });
    }

    /// Reads on until no chunk that is left can have an earlier message than the one that is next.
    fn read_chunks(&mut self) {
        while let Plan::ByLogTime(chunks) = &mut self.plan
            && let Some(chunk) = chunks.front()
            && self.collector.queue.front().is_none_or(|next| chunk.first_log_time_ns <= next.message.log_time_ns)
        {
            let Some(chunk) = chunks.pop_front() else { return };
            let at_byte = chunk.at_byte;
            self.collector.chunk_at_byte = at_byte;
            let read = self.file.chunk(at_byte, &mut self.collector);
            if !self.lose_refused(at_byte)
                && let Err(damage) = read
            {
                let scans = self.file.messages_in(&chunk, &self.collector.channels);
                self.skipped += scans.unwrap_or(0);
                self.lose(LossKind::Part { at_byte, scans, damage });
            }
            self.collector.sort();
        }
    }

    /// Reads on until there is a message or the file ends.
    fn read_steps(&mut self) {
        while let Plan::InFileOrder { ended: ended @ false } = &mut self.plan
            && self.collector.queue.is_empty()
        {
            let at_byte = self.file.at_byte();
            let progress = self.file.step(&mut self.collector);
            *ended = matches!(progress, Progress::End { .. } | Progress::Stopped { .. });
            // Damage was found when the file was looked through. Since then the file may have gone.
            if let Progress::Stopped { at_byte, damage: damage @ Damage::Unreadable(_) } = progress
                && !mem::replace(&mut self.rest_is_lost, true)
            {
                self.lose(LossKind::Rest { at_byte, damage });
            }
            self.lose_refused(at_byte);
        }
    }

    /// Reports messages of the chunk at `at_byte` for which there was no room; whether there were any.
    fn lose_refused(&mut self, at_byte: u64) -> bool {
        let refused = mem::take(&mut self.collector.refused);
        if refused > 0 {
            self.skipped += refused;
            let damage = Damage::TooLarge { bytes: self.collector.bytes, limit: self.collector.most_bytes };
            self.lose(LossKind::Part { at_byte, scans: Some(refused), damage });
        }
        refused > 0
    }
}

impl<F: ChunkedFile> Container for Chunked<F> {
    fn contents(&self) -> &Contents {
        &self.contents
    }

    fn contents_mut(&mut self) -> &mut Contents {
        &mut self.contents
    }

    fn limit_waiting(&mut self, bytes: u64) {
        self.collector.most_bytes = bytes;
    }

    fn select(&mut self, channels: &BTreeSet<ChannelId>) {
        let most_bytes = self.collector.most_bytes;
        self.collector = Collector { channels: channels.clone(), most_bytes, ..Collector::default() };
        let rested = self.file.rest();
        let ended = rested.is_err();
        if let Err(error) = rested {
            self.lose(LossKind::Rest { at_byte: 0, damage: error.into() });
        }
        let has_some = |chunk: &&ChunkPlace| {
            chunk.channels.is_empty() || channels.iter().any(|id| chunk.channels.contains_key(id))
        };
        self.plan = if self.chunks.is_empty() {
            Plan::InFileOrder { ended }
        } else {
            Plan::ByLogTime(self.chunks.iter().filter(has_some).cloned().collect())
        };
    }

    fn next(&mut self) -> Option<Message> {
        match self.plan {
            Plan::ByLogTime(_) => self.read_chunks(),
            Plan::InFileOrder { .. } => self.read_steps(),
        }
        self.collector.take()
    }

    fn recycle(&mut self, message: Message) {
        self.collector.spare.push(message.data);
    }

    fn is_by_log_time(&self) -> bool {
        matches!(self.plan, Plan::ByLogTime(_))
    }

    fn take_skipped(&mut self) -> u64 {
        mem::take(&mut self.skipped)
    }

    fn take_losses(&mut self) -> Vec<Loss> {
        mem::take(&mut self.losses)
    }
}

/// Keeps the messages of the selected channels in the chunks that were read.
struct Collector {
    channels: BTreeSet<ChannelId>,
    queue: VecDeque<Queued>,
    /// How many of the queue are known to be whole.
    settled: usize,
    /// Of the messages in the queue, and how many there may be.
    bytes: u64,
    most_bytes: u64,
    /// Messages for which there was no room since the last chunk.
    refused: u64,
    spare: Vec<Vec<u8>>,
    chunk_at_byte: u64,
    seen: u64,
}

/// A message that waits for its turn.
struct Queued {
    message: Message,
    /// Where its chunk is, then its place among those read: what decides between equal log times.
    order: (u64, u64),
}

impl Default for Collector {
    fn default() -> Self {
        Self {
            channels: BTreeSet::new(),
            queue: VecDeque::new(),
            settled: 0,
            bytes: 0,
            most_bytes: limits::WAITING_BYTES,
            refused: 0,
            spare: Vec::new(),
            chunk_at_byte: 0,
            seen: 0,
        }
    }
}

impl Collector {
    fn sort(&mut self) {
        self.queue.make_contiguous().sort_by_key(|queued| (queued.message.log_time_ns, queued.order));
    }

    fn take(&mut self) -> Option<Message> {
        let queued = self.queue.pop_front();
        self.settled = self.queue.len();
        let message = queued?.message;
        self.bytes -= message.data.len() as u64;
        Some(message)
    }
}

impl Visitor for Collector {
    fn channel(&mut self, _: ChannelId, _: Topic) {}

    fn wants(&self, channel: ChannelId) -> bool {
        self.channels.contains(&channel) && self.bytes < self.most_bytes
    }

    fn message(&mut self, channel: ChannelId, log_time_ns: u64, body: &mut Vec<u8>) {
        if !self.wants(channel) {
            self.refused += u64::from(self.channels.contains(&channel));
            return;
        }
        self.bytes += body.len() as u64;
        let data = mem::replace(body, self.spare.pop().unwrap_or_default());
        self.seen += 1;
        let order = (self.chunk_at_byte, self.seen);
        self.queue.push_back(Queued { message: Message { channel, log_time_ns, data, damage: None }, order });
    }

    fn settle(&mut self, whole: bool) {
        if !whole {
            let faulty = self.queue.drain(self.settled..);
            self.bytes -= faulty.map(|queued| queued.message.data.len() as u64).sum::<u64>();
        }
        self.settled = self.queue.len();
    }
}
