//! MCAP.
//!
//! Records are framed here and parsed by the `mcap` crate. Its own readers stop at the first damaged chunk, do not check
//! the checksum of a chunk that was found by the index, and do not say where a fault is; of a damaged recording,
//! everything that is whole must be read.

mod chunk;
mod data_section;
mod in_order;
mod records;
mod summary;

use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io;
use std::path::Path;

use crosscut_stage::counted;
use mcap::records::{ChunkIndex, Record, op};

pub(super) use self::data_section::DataSection;
pub(crate) use self::in_order::{FollowedMcap, PipedMcap, follow};
use self::records::topic_of;
use self::summary::Summary;
use super::chunked::{ChunkPlace, Chunked, ChunkedFile as _};
use super::contents::{Contents, TimeSample};
use super::resting_file::RestingFile;
use super::survey::Survey;
use crate::{Loss, LossKind};

/// The metadata record of this name in the file at `path`, if it is before the first message.
pub(crate) fn metadata(path: &Path, name: &str) -> io::Result<Option<BTreeMap<String, String>>> {
    let file = RestingFile::new(path.to_owned(), File::open(path)?);
    let bytes = file.length()?;
    Ok(DataSection::new(file, bytes)?.metadata(name))
}

/// Files of up to this many chunks have the log times of all messages sampled.
const FEW_CHUNKS: usize = 16;

/// Looks through `file`, which begins with the magic bytes; `path` names it in losses.
pub(super) fn open(path: &Path, file: RestingFile) -> io::Result<Chunked<DataSection>> {
    let bytes = file.length()?;
    let mut section = DataSection::new(file, bytes)?;
    let mut contents = Contents { path: path.to_owned(), bytes, format: "MCAP", ..Contents::default() };
    let mut losses = Vec::new();
    let mut lost = |kind| losses.push(Loss { file: path.to_owned(), kind });
    let (summary, index_damage) = match Summary::read(section.input(), bytes) {
        Ok(summary) => (summary.unwrap_or_default(), None),
        Err(damage) => (Summary::default(), Some(damage)),
    };
    let chunks = summary.chunks;
    for channel in summary.channels {
        let id = channel.id.into(); // the first definition holds
        contents.channels.entry(id).or_insert_with(|| topic_of(channel, &summary.schemas));
    }
    match summary.statistics {
        Some(statistics) if !contents.channels.is_empty() && !chunks.is_empty() => {
            sample_times(&mut section, &chunks, &mut contents.log_times_ns);
            let span_ns = [statistics.message_start_time, statistics.message_end_time];
            contents.log_times_ns.span_ns = (statistics.message_count > 0).then_some(span_ns);
            let counts = statistics.channel_message_counts.into_iter();
            contents.counts = Some(counts.map(|(id, count)| (id.into(), count)).collect());
        }
        _ => {
            let survey = Survey::of(&mut section);
            if let (Some(damage), Some(end_of_data)) = (index_damage, survey.end_of_data) {
                lost(match section.end_of_recording(end_of_data) {
                    Some(at_byte) if at_byte < bytes => LossKind::Behind { at_byte, bytes: bytes - at_byte },
                    _ => LossKind::Index { damage },
                });
            }
            if chunks.is_empty() {
                survey.losses.into_iter().for_each(lost);
            }
            contents.channels = survey.channels;
            contents.counts = Some(survey.counts);
            contents.log_times_ns = survey.log_times_ns;
        }
    }
    contents.losses = losses;
    contents.properties = properties(&mut section, &chunks);
    section.rest()?;
    Ok(Chunked::new(section, contents, chunks.into_iter().map(place_of).collect()))
}

/// Log times by the index: of files with few chunks those of all messages, else the first and last of each chunk.
fn sample_times(section: &mut DataSection, chunks: &[ChunkIndex], sample: &mut TimeSample) {
    for chunk in chunks {
        let before = sample.taken().len();
        if chunks.len() <= FEW_CHUNKS {
            for at_byte in chunk.message_index_offsets.values() {
                if let Ok(Record::MessageIndex(index)) = section.record(*at_byte, op::MESSAGE_INDEX) {
                    index.records.iter().for_each(|entry| sample.add(entry.log_time));
                }
            }
        }
        if sample.taken().len() == before {
            [chunk.message_start_time, chunk.message_end_time].into_iter().for_each(|ns| sample.add(ns));
        }
    }
}

fn place_of(chunk: ChunkIndex) -> ChunkPlace {
    ChunkPlace {
        at_byte: chunk.chunk_start_offset,
        first_log_time_ns: chunk.message_start_time,
        channels: chunk.message_index_offsets.into_iter().map(|(id, at_byte)| (id.into(), at_byte)).collect(),
    }
}

/// What the file says of itself: profile, library, index and compression.
fn properties(section: &mut DataSection, chunks: &[ChunkIndex]) -> Vec<(&'static str, String)> {
    let header = match section.record(mcap::MAGIC.len() as u64, op::HEADER) {
        Ok(Record::Header(header)) => Some((header.profile, header.library)),
        _ => None,
    };
    let (profile, library) = header.unwrap_or_default();
    let compression = |chunk: &ChunkIndex| match chunk.compression.as_str() {
        "" => "none".to_owned(),
        name => name.to_owned(),
    };
    let compressions: BTreeSet<String> = chunks.iter().map(compression).collect();
    let compressions: Vec<String> = compressions.into_iter().collect();
    let index = if chunks.is_empty() {
        "none: messages come in the order of the file".to_owned()
    } else {
        format!("{}, compression: {}", counted(chunks.len() as u64, "chunk"), compressions.join(", "))
    };
    vec![("profile", profile), ("writer", library), ("index", index)]
}
