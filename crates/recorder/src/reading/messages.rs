//! The messages of one .rrd file, one after the other, and what is wrong with the file.
//!
//! Rerun's own iterator takes the end of a file that was cut off for its proper end. This one walks the frames itself
//! (a header with kind and length, then the message), so that it knows where each message lies and what is missing.

use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

use rerun::external::re_build_info::CrateVersion;
use rerun::external::re_log_encoding::{
    CachingApplicationIdInjector, Decodable, DecoderEntrypoint, MessageHeader, MessageKind, StreamFooter, StreamHeader,
};
use rerun::external::re_log_types::{ArrowMsg, StoreId};
use rerun::log::{Chunk, LogMsg};

use super::{Damage, ReadError};

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
    let message = caught(|| LogMsg::decode(content.into(), span, kind, ids, Some(version)).map_err(|e| e.to_string()))?;
    message.ok_or_else(|| "an end in the middle".to_owned())
}

/// What `decode` returns; Arrow panics on some damaged bytes, as offsets outside their buffer.
pub(super) fn caught<T>(decode: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(decode)).unwrap_or_else(|_| Err("its content contradicts itself".to_owned()))
}
