//! The messages of one .rrd file, one after the other, and what is wrong with the file.
//!
//! Rerun's own iterator takes the end of a file that was cut off for its proper end. This one reads each header (kind
//! and length) and message itself, so that it knows where each message lies and what is missing.

use std::cell::Cell;
use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::panic::{self, AssertUnwindSafe};
use std::path::{Path, PathBuf};
use std::sync::Once;

use rerun::StoreKind;
use rerun::external::arrow::ipc::{Buffer, RecordBatch, root_as_message};
use rerun::external::re_build_info::CrateVersion;
use rerun::external::re_log_encoding::external::lz4_flex;
use rerun::external::re_log_encoding::{
    CachingApplicationIdInjector, Compression, Decodable, DecoderEntrypoint, MessageHeader, MessageKind, StreamFooter,
    StreamHeader, ToApplication, ToTransport,
};
use rerun::external::re_log_types::{ArrowMsg, StoreId};
use rerun::log::{Chunk, LogMsg};

use crate::{Damage, ReadError};

/// A message as it stands in a file.
type Stored = <LogMsg as ToTransport>::Output;

/// The first bytes of every file.
const FILE_STARTS: &[u8] = b"RRF";

/// LZ4 compresses nothing to less than this share: one byte in so many.
const LZ4_MOST_RATIO: usize = 256;

/// Where a message says which entity it is about.
pub const ENTITY_PATH: &str = "rerun:entity_path";

/// What is reported of a message whose parts do not fit each other.
const CONTRADICTION: &str = "its content contradicts itself";

/// Where the content of a message lies in its file.
#[derive(Clone, Copy, Debug)]
pub struct Location {
    /// Its first byte.
    pub(crate) at: u64,
    /// Its length.
    pub(crate) bytes: u64,
}

/// One .rrd file, read from its start to its end or to where it is damaged.
pub struct Messages {
    path: PathBuf,
    file: BufReader<File>,
    version: CrateVersion,
    at: u64,
    end: u64,
    is_over: bool,
}

impl Messages {
    /// Opens a file at its first message.
    ///
    /// # Errors
    /// When the file cannot be opened or is no recording.
    pub fn open(path: &Path) -> Result<Self, ReadError> {
        let cannot = |cause: String| ReadError::Open { path: path.to_owned(), cause };
        let file = File::open(path).map_err(|e| cannot(e.to_string()))?;
        let end = file.metadata().map_err(|e| cannot(e.to_string()))?.len();
        let mut file = BufReader::with_capacity(1 << 20, file);
        let mut header = [0; StreamHeader::ENCODED_SIZE_BYTES];
        file.read_exact(&mut header).map_err(|_| cannot(format!("{end} bytes are not a recording")))?;
        if header.starts_with(b"\x89MCAP") {
            return Err(cannot("it is an MCAP recording; give what `crosscut run --save` made of it".to_owned()));
        }
        let (version, _) = StreamHeader::from_rrd_bytes(&header)
            .and_then(StreamHeader::to_version_and_options)
            .map_err(|e| cannot(e.to_string()))?;
        Ok(Self { path: path.to_owned(), file, version, at: header.len() as u64, end, is_over: false })
    }

    /// The version of Rerun that wrote the file.
    pub(crate) fn version(&self) -> CrateVersion {
        self.version
    }

    /// The recordings that a file holds: one, unless files were merged. Layouts do not count.
    ///
    /// # Errors
    /// As [`Messages::open`].
    pub fn recordings_in(path: &Path) -> Result<Vec<StoreId>, ReadError> {
        let mut messages = Self::open(path)?;
        let mut found = Vec::new();
        while let Ok(Some(header)) = messages.header() {
            if header.kind != MessageKind::SetStoreInfo {
                let bytes = i64::try_from(header.len).expect("no more than are left of the file");
                if messages.file.seek_relative(bytes).is_err() {
                    break;
                }
                messages.at += header.len;
            } else if let Ok((_, LogMsg::SetStoreInfo(info))) = messages.message(&header)
                && info.info.store_id.kind() == StoreKind::Recording
                && !found.contains(&info.info.store_id)
            {
                found.push(info.info.store_id);
            }
        }
        Ok(found)
    }

    /// Length of the file.
    pub(crate) fn bytes(&self) -> u64 {
        self.end
    }

    /// The header of the next message; `None` where the file says that it ends. Of files that were put together, each ends.
    fn header(&mut self) -> Result<Option<MessageHeader>, Damage> {
        loop {
            let header = self.header_or_end()?;
            if header.is_some() || self.at == self.end {
                return Ok(header);
            }
            let mut start = [0; StreamHeader::ENCODED_SIZE_BYTES];
            self.file.read_exact(&mut start).map_err(|_| self.cut_off())?;
            let footer = StreamFooter::ENCODED_SIZE_BYTES as u64;
            if !start.starts_with(FILE_STARTS) && self.end - self.at >= footer {
                // An end without content still has a footer.
                let left = footer.cast_signed() - start.len() as i64;
                self.file.seek_relative(left).map_err(|_| self.cut_off())?;
                self.at += footer;
                if self.at == self.end {
                    return Ok(None);
                }
                self.file.read_exact(&mut start).map_err(|_| self.cut_off())?;
            }
            let start = StreamHeader::from_rrd_bytes(&start).and_then(StreamHeader::to_version_and_options);
            (self.version, _) = start.map_err(|e| self.unreadable(format!("behind its end: {e}")))?;
            self.at += StreamHeader::ENCODED_SIZE_BYTES as u64;
        }
    }

    fn header_or_end(&mut self) -> Result<Option<MessageHeader>, Damage> {
        let at = self.at;
        if at == self.end {
            return Err(Damage::Unfinished { path: self.path.clone(), bytes: at, whole_to: None });
        }
        let mut header = [0; MessageHeader::ENCODED_SIZE_BYTES];
        if self.end - at < header.len() as u64 || self.file.read_exact(&mut header).is_err() {
            return Err(self.cut_off());
        }
        let header = MessageHeader::from_rrd_bytes(&header).map_err(|e| self.unreadable(e.to_string()))?;
        self.at += MessageHeader::ENCODED_SIZE_BYTES as u64;
        let is_end = header.kind == MessageKind::End;
        let after = if is_end && header.len > 0 { StreamFooter::ENCODED_SIZE_BYTES as u64 } else { 0 };
        if header.len.saturating_add(after) > self.end - self.at {
            return Err(self.cut_off());
        }
        if is_end {
            let bytes = i64::try_from(header.len + after).expect("no more than are left of the file");
            self.file.seek_relative(bytes).map_err(|_| self.cut_off())?;
            self.at += header.len + after;
        }
        Ok((!is_end).then_some(header))
    }

    /// The message that follows its header.
    fn message(&mut self, header: &MessageHeader) -> Result<(Location, LogMsg), Damage> {
        let location = Location { at: self.at, bytes: header.len };
        let message = read(&mut self.file, location.bytes, header.kind, self.version);
        let message = message.map_err(|cause| self.unreadable(cause));
        self.at += location.bytes;
        Ok((location, message?))
    }

    fn cut_off(&self) -> Damage {
        Damage::CutOff { path: self.path.clone(), at: self.at, bytes: self.end, whole_to: None }
    }

    fn unreadable(&self, cause: String) -> Damage {
        Damage::Unreadable { path: self.path.clone(), at: self.at, cause }
    }
}

impl Iterator for Messages {
    type Item = Result<(Location, LogMsg), Damage>;

    /// The next message. An unreadable one is reported and skipped; after an unreadable header nothing more is read.
    fn next(&mut self) -> Option<Self::Item> {
        if self.is_over {
            return None;
        }
        let header = self.header();
        self.is_over = !matches!(header, Ok(Some(_)));
        header.and_then(|header| header.map(|header| self.message(&header)).transpose()).transpose()
    }
}

/// Reads one chunk again.
pub(crate) fn chunk_at(file: &mut File, location: Location, version: CrateVersion) -> Result<Chunk, String> {
    file.seek(SeekFrom::Start(location.at)).map_err(|e| e.to_string())?;
    match read(file, location.bytes, MessageKind::ArrowMsg, version)? {
        LogMsg::ArrowMsg(_, message) => chunk_of(&message),
        _ => Err("it holds another message".to_owned()),
    }
}

/// The chunk in a message.
///
/// # Errors
/// When the message is damaged: what is wrong with it.
pub fn chunk_of(message: &ArrowMsg) -> Result<Chunk, String> {
    caught(|| Chunk::from_arrow_msg(message).map_err(|e| e.to_string()))
}

fn read(from: &mut impl Read, bytes: u64, kind: MessageKind, version: CrateVersion) -> Result<LogMsg, String> {
    let mut content = vec![0; usize::try_from(bytes).map_err(|e| e.to_string())?];
    from.read_exact(&mut content).map_err(|e| e.to_string())?;
    let span = Default::default(); // only for messages that say where they lie
    let ids = &mut CachingApplicationIdInjector::default();
    caught(|| {
        let stored = Stored::decode(content.into(), span, kind, ids, Some(version)).map_err(|e| e.to_string())?;
        let mut stored = stored.ok_or("an end in the middle")?;
        if let Stored::ArrowMsg(message) = &mut stored {
            if let Compression::LZ4 = message.compression().into() {
                let bytes = usize::try_from(message.uncompressed_size).map_err(|e| e.to_string())?;
                if bytes / LZ4_MOST_RATIO > message.payload.len() {
                    return Err(too_large(bytes));
                }
                let payload = lz4_flex::block::decompress(&message.payload, bytes).map_err(|e| e.to_string())?;
                message.payload = payload.into();
                message.set_compression(Compression::Off.into());
            }
            check_sizes(&message.payload)?;
        }
        stored.to_application((ids, Some(version))).map_err(|e| e.to_string())
    })
}

/// Checks every length and position that the messages of an Arrow stream state: Arrow allocates what they claim, which
/// can end the program, and panics on buffers outside their message.
fn check_sizes(mut stream: &[u8]) -> Result<(), String> {
    let ends = || "it ends in the middle".to_owned();
    while !stream.is_empty() {
        let mut word = || stream.split_off(..4).and_then(|word| word.try_into().ok()).map(u32::from_le_bytes);
        let metadata_bytes = word().and_then(|first| if first == u32::MAX { word() } else { Some(first) });
        let metadata_bytes = metadata_bytes.ok_or_else(ends)? as usize;
        if metadata_bytes == 0 {
            return Ok(()); // the end, as Arrow marks it
        }
        let metadata = stream.split_off(..metadata_bytes).ok_or_else(|| too_large(metadata_bytes))?.to_vec(); // aligned
        let message = root_as_message(&metadata).map_err(|_| CONTRADICTION.to_owned())?;
        let body_bytes = usize::try_from(message.bodyLength()).map_err(|e| e.to_string())?;
        stream.split_off(..body_bytes).ok_or_else(|| too_large(body_bytes))?;
        let batch = message.header_as_record_batch();
        let batch = batch.or_else(|| message.header_as_dictionary_batch().and_then(|dictionary| dictionary.data()));
        let mut buffers = batch.iter().flat_map(RecordBatch::buffers).flatten();
        let is_inside = |buffer: &Buffer| {
            let end = buffer.offset().checked_add(buffer.length());
            buffer.offset() >= 0 && buffer.length() >= 0 && end.is_some_and(|end| end <= message.bodyLength())
        };
        if !buffers.all(is_inside) {
            return Err(CONTRADICTION.to_owned());
        }
    }
    Ok(())
}

fn too_large(bytes: usize) -> String {
    format!("it claims {bytes} bytes, more than there are")
}

/// The result of `decode`, or an error where Arrow or Rerun panic: they do so on some damaged bytes that pass every
/// check of theirs and of ours. The error says it all: nothing is printed.
pub(crate) fn caught<T>(decode: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    static SILENCED: Once = Once::new();
    SILENCED.call_once(|| {
        let usual = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            if !IS_DECODING.get() {
                usual(info);
            }
        }));
    });
    let outer = IS_DECODING.replace(true);
    let decoded = panic::catch_unwind(AssertUnwindSafe(decode));
    IS_DECODING.set(outer);
    decoded.unwrap_or_else(|_| Err(CONTRADICTION.to_owned()))
}

thread_local! {
    /// Whether this thread decodes a message, so that a panic is the message's.
    static IS_DECODING: Cell<bool> = const { Cell::new(false) };
}
