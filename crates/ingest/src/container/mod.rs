//! Files of a flight, whatever their format: what each holds, and its messages in order.
//!
//! A format is one file or folder here and one line in [`open`]. It implements [`Container`] itself, or, where the
//! messages stand in chunks, [`ChunkedFile`](chunked::ChunkedFile), for which [`Chunked`](chunked::Chunked) does the
//! rest. The format is recognised by the first bytes of the file, never by its name.

mod bag;
mod carmen;
mod chunked;
mod contents;
mod lines;
mod mcap;
mod resting_file;
mod rosbag2;
mod single_cloud;
mod spool;
mod sqlite;
mod standard_input;
mod survey;
mod table;
mod topic_reader;

use std::fs::File;
use std::io::{Read, Seek};
use std::path::Path;
use std::sync::Arc;

use self::carmen::Carmen;
use self::lines::Lines;
use self::resting_file::RestingFile;
use self::rosbag2::Rosbag2;
use self::single_cloud::{Format, SingleCloud};
use self::spool::{Compression, Spooled};
use self::table::Table;
use crate::found::ROS1_BAG_MAGIC;
use crate::{CsvGeometry, Found, IngestError, Loss, LossKind};

pub(crate) use self::chunked::Visitor;
pub(crate) use self::mcap::{FollowedMcap, PipedMcap, follow as follow_mcap, metadata as mcap_metadata};
pub use self::spool::KeptStandardInput;
pub(crate) use self::spool::{Plain, keep_standard_input};
pub(crate) use self::standard_input::StandardInput;

pub(crate) use self::contents::{ChannelId, Container, Contents, Message, Topic, Wait};
pub(crate) use self::topic_reader::TopicReader;

/// This many bytes at the start of a file tell what it is.
const SNIFFED_BYTES: u64 = 4096;

/// What stands for standard input among paths.
const STANDARD_INPUT: &str = "-";

/// Opens a file and looks through it; `-` is standard input.
///
/// # Errors
/// When it cannot be opened, is no file, or is of a format that is not read here.
pub(crate) fn open(path: &Path, csv: &CsvGeometry) -> Result<Box<dyn Container>, IngestError> {
    let failed = |source| IngestError::cannot_open(path, source);
    if path == Path::new(STANDARD_INPUT) {
        let spooled = spool::standard_input().map_err(failed)?;
        return open_spooled(path, spooled, csv);
    }
    if !std::fs::metadata(path).map_err(failed)?.is_file() {
        return Err(IngestError::NotAFile { path: path.to_owned() });
    }
    let mut file = File::open(path).map_err(failed)?;
    let start = start_of(&mut file).map_err(failed)?;
    if let Some(compression) = Compression::of(&start) {
        let spooled = spool::decompress(path, file, compression).map_err(failed)?;
        return open_spooled(path, spooled, csv);
    }
    open_plain(path, path, RestingFile::new(path.to_owned(), file), &start, csv)
}

/// Opens what was opened before a second time, to read other messages of it at the same time.
pub(crate) fn reopen(container: &dyn Container, csv: &CsvGeometry) -> Result<Box<dyn Container>, IngestError> {
    container.again().map_or_else(|| reopen_file(container.contents(), csv), Ok)
}

/// Opens a file again that was opened before.
pub(crate) fn reopen_file(contents: &Contents, csv: &CsvGeometry) -> Result<Box<dyn Container>, IngestError> {
    let path = &contents.path;
    let failed = |source| IngestError::cannot_open(path, source);
    let (on_disk, mut file) = match &contents.temporary {
        Some(temporary) => (temporary.to_path_buf(), RestingFile::temporary(Arc::clone(temporary))),
        None => (path.clone(), RestingFile::new(path.clone(), File::open(path).map_err(failed)?)),
    };
    let start = start_of(&mut file).map_err(failed)?;
    open_plain(path, &on_disk, file, &start, csv)
}

/// Opens a temporary copy of `path`.
fn open_spooled(
    path: &Path,
    Spooled { path: temporary, compression, damage }: Spooled,
    csv: &CsvGeometry,
) -> Result<Box<dyn Container>, IngestError> {
    let failed = |source| IngestError::cannot_open(path, source);
    let name = temporary.to_path_buf();
    let mut file = RestingFile::temporary(Arc::clone(&temporary));
    let start = start_of(&mut file).map_err(failed)?;
    if Compression::of(&start).is_some() {
        return Err(IngestError::NotRecording { path: path.to_owned(), found: Found::CompressedTwice });
    }
    let mut container = open_plain(path, &name, file, &start, csv)?;
    let contents = container.contents_mut();
    contents.temporary = Some(temporary);
    if let Some(compression) = compression {
        contents.properties.push(("compressed", format!("as a whole, with {}", compression.name())));
    }
    contents.losses.extend(damage.map(|damage| {
        let kind = LossKind::Compressed { read_bytes: contents.bytes, damage };
        Loss { file: path.to_owned(), kind }
    }));
    Ok(container)
}

/// Opens a file that begins with `start`; `path` names it in losses, `on_disk` is where it is.
fn open_plain(
    path: &Path,
    on_disk: &Path,
    mut file: RestingFile,
    start: &[u8],
    csv: &CsvGeometry,
) -> Result<Box<dyn Container>, IngestError> {
    let failed = |source| IngestError::cannot_open(path, source);
    let no_recording = |found| IngestError::NotRecording { path: path.to_owned(), found };
    let unreadable = |damage| {
        let kind = LossKind::Rest { at_byte: 0, damage };
        IngestError::NothingReadable { losses: vec![Loss { file: path.to_owned(), kind }] }
    };
    if start.starts_with(::mcap::MAGIC) {
        Ok(Box::new(mcap::open(path, file).map_err(failed)?))
    } else if start.starts_with(ROS1_BAG_MAGIC) {
        Ok(Box::new(bag::open(path, file).map_err(failed)?))
    } else if start.starts_with(sqlite::MAGIC) {
        let bag = Rosbag2::open(path, on_disk, file).map_err(unreadable)?;
        Ok(Box::new(bag.ok_or_else(|| no_recording(Found::Sqlite))?))
    } else {
        match Found::in_file(start) {
            Found::Text | Found::Unknown(_) if carmen::is_log(&String::from_utf8_lossy(start)) => {
                Ok(Box::new(Lines::open(path, file, Carmen::new(csv.rate_hz)).map_err(failed)?))
            }
            Found::Text => {
                let table = Table::look(path, &mut file, csv)?;
                Ok(Box::new(Lines::open(path, file, table).map_err(failed)?))
            }
            Found::Pcd => Ok(Box::new(SingleCloud::open(path, file, Format::Pcd).map_err(unreadable)?)),
            Found::Ply => Ok(Box::new(SingleCloud::open(path, file, Format::Ply).map_err(unreadable)?)),
            found => Err(no_recording(found)),
        }
    }
}

/// The first bytes of a file, which is at its start again afterwards.
fn start_of(file: &mut (impl Read + Seek)) -> std::io::Result<Vec<u8>> {
    let mut start = Vec::new();
    file.by_ref().take(SNIFFED_BYTES).read_to_end(&mut start)?;
    file.rewind()?;
    Ok(start)
}
