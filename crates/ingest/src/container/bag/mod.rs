//! Bags of ROS 1, version 2.0: chunks of messages, with an index at the end if the recorder could write it.
//!
//! The crate `rosbag` maps a file into memory, needs the index, and ends at the first record that it cannot parse; of a
//! bag that was cut off or damaged, everything that is whole must be read.

mod chunk;
mod file;
mod index;
mod records;

use std::io;
use std::path::Path;

use crosscut_stage::counted;

pub(super) use self::file::BagFile;
use super::chunked::{Chunked, ChunkedFile as _};
use super::contents::Contents;
use super::resting_file::RestingFile;
use super::survey::Survey;
use crate::{Loss, LossKind};

/// Looks through `file`, which begins with [`ROS1_BAG_MAGIC`]; `path` names it in losses.
pub(super) fn open(path: &Path, file: RestingFile) -> io::Result<Chunked<BagFile>> {
    let bytes = file.length()?;
    let mut bag = BagFile::new(file, bytes)?;
    let mut contents = Contents { path: path.to_owned(), bytes, format: "ROS 1 bag", ..Contents::default() };
    let (index, index_damage) = match bag.index() {
        Ok(index) => (index, None),
        Err(damage) => (None, Some(damage)),
    };
    let mut chunks = Vec::new();
    let words = if let Some(index) = index {
        for chunk in &index.chunks {
            contents.log_times_ns.add(chunk.place.first_log_time_ns);
            contents.log_times_ns.add(chunk.last_log_time_ns);
        }
        contents.counts = Some(index.counts());
        contents.channels = index.channels;
        chunks = index.chunks;
        counted(chunks.len() as u64, "chunk")
    } else {
        let survey = Survey::of(&mut bag);
        let index_lost = index_damage.filter(|_| survey.end_of_data.is_some()).map(|damage| LossKind::Index { damage });
        let losses = index_lost.into_iter().chain(survey.losses);
        contents.losses.extend(losses.map(|kind| Loss { file: path.to_owned(), kind }));
        contents.channels = survey.channels;
        contents.counts = Some(survey.counts);
        contents.log_times_ns = survey.log_times_ns;
        "none: messages come in the order of the file".to_owned()
    };
    contents.properties = vec![("index", words)];
    bag.rest()?;
    Ok(Chunked::new(bag, contents, chunks.into_iter().map(|chunk| chunk.place).collect()))
}
