//! One MCAP file: what it holds, and its scan messages in order.
//!
//! Records are told apart here and taken apart by the `mcap` crate. Its own readers stop at the first damaged chunk, do
//! not check the checksum of a chunk that was found by the index, and do not say where a fault is; a damaged recording
//! has to give all that is whole.

mod catalogue;
mod chunk;
mod data_section;
mod records;
mod resting_file;
mod summary;
mod topic_reader;

use std::collections::BTreeSet;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use mcap::records::{ChunkIndex, Record, op};

use self::catalogue::{Catalogue, Survey};
use self::data_section::DataSection;
use self::resting_file::RestingFile;
use self::summary::Summary;
use crate::{Found, IngestError, Loss, LossKind};

pub(crate) use self::catalogue::Topic;
pub(crate) use self::topic_reader::{Message, TopicReader};

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
    section: DataSection,
}

impl Container {
    pub(crate) fn open(path: &Path) -> Result<Self, IngestError> {
        let failed = |source| IngestError::Open { path: path.to_owned(), source };
        if !std::fs::metadata(path).map_err(failed)?.is_file() {
            return Err(IngestError::NotAFile { path: path.to_owned() });
        }
        let mut file = File::open(path).map_err(failed)?;
        let length = file.metadata().map_err(failed)?.len();
        let mut start = Vec::new();
        (&mut file).take(SNIFFED_BYTES).read_to_end(&mut start).map_err(failed)?;
        if !start.starts_with(mcap::MAGIC) {
            return Err(IngestError::NotMcap { path: path.to_owned(), found: Found::in_file(&start) });
        }
        let mut section = DataSection::new(RestingFile::new(path.to_owned(), file), length).map_err(failed)?;
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
                if let (Some(damage), Some(end_of_data)) = (index_damage, survey.end_of_data) {
                    lost(match section.end_of_recording(end_of_data) {
                        Some(at_byte) if at_byte < length => LossKind::Behind { at_byte, bytes: length - at_byte },
                        _ => LossKind::Index { damage },
                    });
                }
                if chunks.is_empty() {
                    survey.losses.into_iter().for_each(lost);
                }
                catalogue = survey.catalogue;
            }
        }
        section.rest().map_err(failed)?;
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
