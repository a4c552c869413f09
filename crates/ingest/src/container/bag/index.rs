//! The index at the end of a bag: its connections, and where each chunk is.

use std::collections::BTreeMap;
use std::io::Read;

use super::records::{Head, op, read_data, topic_of};
use crate::container::chunked::ChunkPlace;
use crate::container::{ChannelId, Topic};
use crate::{Damage, limits};

/// The index of a bag.
#[derive(Default)]
pub(super) struct Index {
    pub(super) channels: BTreeMap<ChannelId, Topic>,
    /// By log time, ties by place.
    pub(super) chunks: Vec<Chunk>,
}

/// A chunk, as the index describes it: for each channel, its place holds how many messages there are.
pub(super) struct Chunk {
    pub(super) place: ChunkPlace,
    pub(super) last_log_time_ns: u64,
}

impl Index {
    /// Reads an index of this many records, which stands behind all chunks, at `index_at`.
    pub(super) fn read(input: &mut impl Read, connections: u32, chunks: u32, index_at: u64) -> Result<Self, Damage> {
        if connections as usize > limits::CHANNELS {
            return Err(Damage::Record(format!("it has {connections} connections, more than {}", limits::CHANNELS)));
        }
        let mut index = Self::default();
        let (mut head, mut data) = (Head::default(), Vec::new());
        for _ in 0..u64::from(connections) + u64::from(chunks) {
            if !head.read(input)? {
                return Err(Damage::Ended);
            }
            read_data(input, head.data_bytes, &mut data)?;
            match head.op()? {
                op::CONNECTION => {
                    index.channels.entry(head.u32("conn")?).or_insert(topic_of(&head, &data)?);
                }
                op::CHUNK_INFO => index.chunks.push(chunk_of(&head, &data)?),
                other => return Err(Damage::Record(format!("a record of type {other} is in it"))),
            }
        }
        let is_placed = |chunk: &Chunk| chunk.place.at_byte < index_at;
        if index.chunks.len() != chunks as usize || !index.chunks.iter().all(is_placed) {
            return Err(Damage::Record(format!("it does not have {chunks} chunks, all of them before it")));
        }
        index.chunks.sort_by_key(|chunk| (chunk.place.first_log_time_ns, chunk.place.at_byte));
        index.chunks.dedup_by_key(|chunk| chunk.place.at_byte);
        Ok(index)
    }

    /// Messages of each channel.
    pub(super) fn counts(&self) -> BTreeMap<ChannelId, u64> {
        let mut counts = BTreeMap::new();
        for (&id, &count) in self.chunks.iter().flat_map(|chunk| &chunk.place.channels) {
            *counts.entry(id).or_default() += count;
        }
        counts
    }
}

fn chunk_of(head: &Head, data: &[u8]) -> Result<Chunk, Damage> {
    let (entries, rest) = data.as_chunks::<8>();
    if !rest.is_empty() || entries.len() != head.u32("count")? as usize {
        return Err(Damage::Record("a chunk info does not fit its length".to_owned()));
    }
    let pair = |[a, b, c, d, e, f, g, h]: &[u8; 8]| {
        (u32::from_le_bytes([*a, *b, *c, *d]), u64::from(u32::from_le_bytes([*e, *f, *g, *h])))
    };
    let place = ChunkPlace {
        at_byte: head.u64("chunk_pos")?,
        first_log_time_ns: head.time_ns("start_time")?,
        channels: entries.iter().map(pair).collect(),
    };
    Ok(Chunk { place, last_log_time_ns: head.time_ns("end_time")? })
}
