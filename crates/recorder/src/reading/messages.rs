//! The messages of one .rrd file, one after the other, and what is wrong with the file.
//!
//! Rerun's own iterator takes the end of a file that was cut off for its proper end. This one walks the frames itself
//! (a header with kind and length, then the message), so that it knows where each message lies and what is missing.

use std::cell::Cell;
use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::panic::{self, AssertUnwindSafe};
use std::path::{Path, PathBuf};
use std::sync::Once;

use rerun::external::arrow::ipc::root_as_message;
use rerun::external::re_build_info::CrateVersion;
use rerun::external::re_log_encoding::external::lz4_flex;
use rerun::external::re_log_encoding::{
    CachingApplicationIdInjector, Compression, Decodable, DecoderEntrypoint, MessageHeader, MessageKind, StreamFooter,
    StreamHeader, ToApplication, ToTransport,
};
use rerun::external::re_log_types::{ArrowMsg, StoreId};
use rerun::log::{Chunk, LogMsg};

use super::{Damage, ReadError};

/// A message as it stands in a file.
type Stored = <LogMsg as ToTransport>::Output;

/// LZ4 makes nothing smaller than that.
const LZ4_MOST_RATIO: usize = 256;

/// Where the content of a message lies in its file.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Location {
    pub(super) at: u64,
    pub(super) bytes: u64,
}

/// One .rrd file, read from its start to its end or to where it is damaged.
pub(crate) struct Messages {
    path: PathBuf,
    file: BufReader<File>,
    version: CrateVersion,
    at: u64,
    end: u64,
    is_over: bool,
    /// Read ahead of the others.
    first: Option<<Self as Iterator>::Item>,
}

impl Messages {
    pub(crate) fn open(path: &Path) -> Result<Self, ReadError> {
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
        Ok(Self { path: path.to_owned(), file, version, at: header.len() as u64, end, is_over: false, first: None })
    }

    /// Rerun's version that wrote the file.
    pub(super) fn version(&self) -> CrateVersion {
        self.version
    }

    /// The recording that the file belongs to, as its first message says.
    pub(crate) fn store(&mut self) -> Option<StoreId> {
        if self.first.is_none() {
            self.first = self.next();
        }
        match &self.first {
            Some(Ok((_, LogMsg::SetStoreInfo(info)))) => Some(info.info.store_id.clone()),
            _ => None,
        }
    }

    /// Bytes of the file.
    pub(super) fn bytes(&self) -> u64 {
        self.end
    }

    /// The header of the next message; `None` where the file says that it ends.
    fn header(&mut self) -> Result<Option<MessageHeader>, Damage> {
        let at = self.at;
        if at == self.end {
            return Err(Damage::Unfinished { path: self.path.clone(), bytes: at });
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
        Ok((!is_end).then_some(header))
    }

    fn cut_off(&self) -> Damage {
        Damage::CutOff { path: self.path.clone(), at: self.at, bytes: self.end }
    }

    fn unreadable(&self, cause: String) -> Damage {
        Damage::Unreadable { path: self.path.clone(), at: self.at, cause }
    }
}

impl Iterator for Messages {
    type Item = Result<(Location, LogMsg), Damage>;

    /// The next message. One that cannot be read is passed over, as its length is known; without a length nothing
    /// more is read.
    fn next(&mut self) -> Option<Self::Item> {
        if let Some(first) = self.first.take() {
            return Some(first);
        }
        if self.is_over {
            return None;
        }
        let header = match self.header() {
            Ok(Some(header)) => header,
            Ok(None) => {
                self.is_over = true;
                return None;
            }
            Err(damage) => {
                self.is_over = true;
                return Some(Err(damage));
            }
        };
        let location = Location { at: self.at, bytes: header.len };
        let message = read(&mut self.file, location.bytes, header.kind, self.version);
        let message = message.map_err(|cause| self.unreadable(cause));
        self.at += location.bytes;
        Some(message.map(|message| (location, message)))
    }
}

/// Reads one chunk again.
pub(super) fn chunk_at(file: &mut File, location: Location, version: CrateVersion) -> Result<Chunk, String> {
    file.seek(SeekFrom::Start(location.at)).map_err(|e| e.to_string())?;
    match read(file, location.bytes, MessageKind::ArrowMsg, version)? {
        LogMsg::ArrowMsg(_, message) => chunk_of(&message),
        _ => Err("another message stands in this place".to_owned()),
    }
}

/// The chunk in a message.
pub(crate) fn chunk_of(message: &ArrowMsg) -> Result<Chunk, String> {
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

/// Goes through the messages of an Arrow stream: Arrow asks for as much memory as they say that they take, and ends the
/// program if there is not so much.
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
        let message = root_as_message(&metadata).map_err(|_| "its metadata contradicts itself".to_owned())?;
        let body_bytes = usize::try_from(message.bodyLength()).map_err(|e| e.to_string())?;
        stream.split_off(..body_bytes).ok_or_else(|| too_large(body_bytes))?;
    }
    Ok(())
}

fn too_large(bytes: usize) -> String {
    format!("{bytes} bytes are said to be in it, more than there are")
}

thread_local! {
    static CATCHING: Cell<bool> = const { Cell::new(false) };
}

/// What `decode` returns; Arrow panics on some damaged bytes, as offsets outside their buffer. That is told as an error,
/// not as a panic.
pub(super) fn caught<T>(decode: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    static SILENT: Once = Once::new();
    SILENT.call_once(|| {
        let tell = panic::take_hook();
        panic::set_hook(Box::new(move |panic| {
            if !CATCHING.get() {
                tell(panic);
            }
        }));
    });
    let outer = CATCHING.replace(true);
    let decoded = panic::catch_unwind(AssertUnwindSafe(decode));
    CATCHING.set(outer);
    decoded.unwrap_or_else(|_| Err("its content contradicts itself".to_owned()))
}
