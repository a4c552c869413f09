//! Full decompositions that a sweep has computed, for later ones over the same flights: a folder of MCAP files, each with what
//! one sweep found of one flight by one solver. They are written as they come: of a file that is damaged, or whose end is not
//! written yet, the intact chunks count, and a decomposition counts only for the W that it was made of.

use std::collections::BTreeMap;
use std::fs::File;
use std::hash::{BuildHasher as _, Hasher as _, RandomState};
use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use byteorder::LittleEndian;
use crosscut_messages::CDR_ENCODING;
use crosscut_pipeline::{Decompositions, Frame};
use crosscut_stage::{Embedding, Step, Weights};
use mcap::records::{MessageHeader, Record};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::write::NoSeek;
use mcap::{McapError, McapResult, WriteOptions};
use serde::{Deserialize, Serialize};
use siphasher::sip128::{Hasher128 as _, SipHasher13};

use super::store::hash;
use crate::diagnostics::Diagnostics;

/// At most this many eigenvectors of a decomposition are stored; a zero tolerance that counts more zeros needs a new one.
const MOST_COLUMNS: usize = 32;

/// A chunk that claims to be larger is damaged.
const MOST_CHUNK_BYTES: usize = 1 << 28;

/// The folder, how much may still be written, and what was done so far.
pub(super) struct Kept {
    folder: PathBuf,
    /// The program that wrote the files, as their names begin.
    program: String,
    most_mb: u64,
    room_bytes: AtomicU64,
    computed: AtomicU64,
    recalled: AtomicU64,
    not_kept: AtomicU64,
    /// Why writing failed first.
    error: Mutex<Option<String>>,
}

impl Kept {
    /// Files of another build of the program are of no use, and removed.
    pub(super) fn open(folder: PathBuf, program: &str, most_mb: u64) -> Self {
        let program = hash(&[program])[..8].to_owned();
        let mut room_bytes = most_mb.saturating_mul(1_000_000);
        for (path, name) in files(&folder) {
            if !name.starts_with(&program) {
                std::fs::remove_file(path).ok(); // it takes room, and does no other harm
            } else if let Ok(metadata) = path.metadata() {
                room_bytes = room_bytes.saturating_sub(metadata.len());
            }
        }
        let [computed, recalled, not_kept] = Default::default();
        let room_bytes = room_bytes.into();
        Self { folder, program, most_mb, room_bytes, computed, recalled, not_kept, error: Mutex::default() }
    }

    /// Those of one flight by one solver; `made_of` is all that they depend on beside the program.
    pub(super) fn of(self: &Arc<Self>, made_of: &[&str]) -> OfFlight {
        let name = format!("{}-{}", self.program, hash(made_of));
        let known = files(&self.folder).filter(|(_, known)| known.starts_with(&name));
        let known = known.filter_map(|(path, _)| File::open(path).ok()).map(Reading::new).collect();
        OfFlight { kept: self.clone(), name, known, recalled: None, writing: None }
    }

    /// What was computed and what was not, in a line; `None` if there was no full decomposition.
    pub(super) fn summary(&self) -> Option<String> {
        let [computed, recalled] = [&self.computed, &self.recalled].map(|count| count.load(Ordering::Relaxed));
        (computed + recalled > 0)
            .then(|| format!("{computed} full decompositions, and {recalled} taken from an earlier sweep"))
    }

    /// Reports decompositions that a later sweep has to compute again.
    pub(super) fn report(&self, diagnostics: &mut Diagnostics) {
        let error = self.error.lock().unwrap_or_else(PoisonError::into_inner).take();
        if let Some(error) = error {
            let (not_kept, folder) = (self.not_kept.load(Ordering::Relaxed), self.folder.display());
            diagnostics.note(format_args!("{not_kept} decompositions are not kept in {folder}: {error}"));
        }
    }
}

/// The decompositions of one flight by one solver.
pub(super) struct OfFlight {
    kept: Arc<Kept>,
    name: String,
    known: Vec<Reading>,
    /// The revolution that was recalled last.
    recalled: Option<u32>,
    writing: Option<Writing>,
}

/// A stored decomposition, encoded in CDR.
#[derive(Serialize, Deserialize)]
struct Decomposition {
    /// Hash of W.
    made_of: [u64; 2],
    /// How long it took.
    ns: u64,
    /// All n.
    eigenvalues: Vec<f64>,
    /// The first columns of U, one after the other.
    u: Vec<f64>,
}

impl Decompositions for OfFlight {
    fn recall(&mut self, frame: &mut Frame) -> bool {
        let number = number_of(frame);
        for reading in &mut self.known {
            let Some(bytes) = reading.take(number) else { continue };
            let Ok((found, _)) = cdr_encoding::from_bytes::<Decomposition, LittleEndian>(&bytes) else { continue };
            let n = frame.affinity.weights.n();
            if found.made_of != hash_of(&frame.affinity.weights) || found.eigenvalues.len() != n || n == 0 {
                continue;
            }
            let columns = frame.spectrum.u.make_dense(n, found.u.len() / n);
            for (j, column) in found.u.chunks_exact(n).enumerate() {
                columns.col_as_slice_mut(j).copy_from_slice(column);
            }
            frame.spectrum.eigenvalues = found.eigenvalues;
            frame.timings.set_ns(Step::Spectral, found.ns);
            self.kept.recalled.fetch_add(1, Ordering::Relaxed);
            self.recalled = Some(number);
            return true;
        }
        false
    }

    fn keep(&mut self, frame: &Frame) {
        self.kept.computed.fetch_add(1, Ordering::Relaxed);
        if self.recalled == Some(number_of(frame)) {
            self.kept.recalled.fetch_sub(1, Ordering::Relaxed); // its eigenvectors did not suffice
            return;
        }
        let Embedding::Dense(u) = &frame.spectrum.u else { return };
        if self.kept.most_mb == 0 {
            return;
        }
        let columns = (0..u.ncols().min(MOST_COLUMNS)).flat_map(|j| u.col_as_slice(j)).copied();
        let decomposition = Decomposition {
            made_of: hash_of(&frame.affinity.weights),
            ns: frame.timings.ns(Step::Spectral),
            eigenvalues: frame.spectrum.eigenvalues.clone(),
            u: columns.collect(),
        };
        if let Err(error) = self.write(frame, &decomposition) {
            self.kept.not_kept.fetch_add(1, Ordering::Relaxed);
            self.kept.error.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
        }
    }
}

impl OfFlight {
    /// # Errors
    /// Why it is not kept.
    fn write(&mut self, frame: &Frame, decomposition: &Decomposition) -> Result<(), String> {
        let bytes = cdr_encoding::to_vec::<_, LittleEndian>(decomposition).map_err(|error| error.to_string())?;
        let left = |room: u64| room.checked_sub(bytes.len() as u64);
        self.kept
            .room_bytes
            .fetch_update(Ordering::Relaxed, Ordering::Relaxed, left)
            .map_err(|_| format!("they would take more than --keep-mb {}", self.kept.most_mb))?;
        let file = match &mut self.writing {
            Some(file) => file,
            None => {
                let path = self.kept.folder.join(format!("{}-{}.mcap", self.name, unique()));
                let created = std::fs::create_dir_all(&self.kept.folder).map_err(McapError::from);
                let created = created.and_then(|()| Writing::create(&path)).map_err(|error| error.to_string());
                self.writing.insert(created?)
            }
        };
        file.add(number_of(frame), &bytes).map_err(|error| error.to_string())
    }
}

/// A file that is written. Its chunks are written as a whole, and what is left when it is dropped.
struct Writing {
    mcap: mcap::Writer<NoSeek<File>>,
    channel_id: u16,
}

impl Writing {
    fn create(path: &Path) -> McapResult<Self> {
        let options = WriteOptions::new().compression(None).disable_seeking(true).library("crosscut");
        let mut mcap = options.create(NoSeek::new(File::create(path)?))?;
        let channel_id = mcap.add_channel(0, "decompositions", CDR_ENCODING, &BTreeMap::new())?;
        Ok(Self { mcap, channel_id })
    }

    fn add(&mut self, sequence: u32, data: &[u8]) -> McapResult<()> {
        let header = MessageHeader { channel_id: self.channel_id, sequence, log_time: 0, publish_time: 0 };
        self.mcap.write_to_known_channel(&header, data)
    }
}

/// A file that is read, from its first message to its end or the first damage.
struct Reading {
    file: File,
    reader: LinearReader,
    /// The next message, with its number.
    next: Option<(u32, Vec<u8>)>,
    ended: bool,
}

impl Reading {
    fn new(file: File) -> Self {
        let options =
            LinearReaderOptions::default().with_prevalidate_chunk_crcs(true).with_record_length_limit(MOST_CHUNK_BYTES);
        Self { file, reader: LinearReader::new_with_options(options), next: None, ended: false }
    }

    /// The message of this number. Numbers ascend from call to call.
    fn take(&mut self, number: u32) -> Option<Vec<u8>> {
        while !self.ended && self.next.as_ref().is_none_or(|(next, _)| *next < number) {
            self.next = self.read().ok().flatten();
            self.ended = self.next.is_none();
        }
        self.next.take_if(|(next, _)| *next == number).map(|(_, data)| data)
    }

    fn read(&mut self) -> McapResult<Option<(u32, Vec<u8>)>> {
        while let Some(event) = self.reader.next_event() {
            match event? {
                LinearReadEvent::ReadRequest(bytes) => {
                    let read = self.file.read(self.reader.insert(bytes))?;
                    self.reader.notify_read(read);
                }
                LinearReadEvent::Record { opcode, data } => {
                    if let Record::Message { header, data } = mcap::parse_record(opcode, data)? {
                        return Ok(Some((header.sequence, data.into_owned())));
                    }
                }
            }
        }
        Ok(None)
    }
}

/// The files of decompositions in a folder, with their names; none if it cannot be read.
fn files(folder: &Path) -> impl Iterator<Item = (PathBuf, String)> + use<> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let named = entries.map(|entry| (entry.path(), entry.file_name().to_string_lossy().into_owned()));
    // PROGRAM-MADE_OF-UNIQUE.mcap, all three in hexadecimal digits.
    named.filter(|(_, name)| {
        let parts = name.strip_suffix(".mcap").into_iter().flat_map(|name| name.split('-'));
        parts.map(str::len).eq([8, 32, 16])
    })
}

fn number_of(frame: &Frame) -> u32 {
    u32::try_from(frame.revolution.seq).unwrap_or(u32::MAX)
}

/// Of W, which is symmetric.
fn hash_of(weights: &Weights) -> [u64; 2] {
    let mut hasher = SipHasher13::new();
    hasher.write_usize(weights.n());
    hasher.write_usize(weights.stored());
    let is_whole = weights.stored() == weights.n() * weights.n();
    weights.for_each(|i, j, value| {
        if i >= j {
            if !is_whole {
                hasher.write_usize(i);
                hasher.write_usize(j);
            }
            hasher.write_u64(value.to_bits());
        }
    });
    let hash = hasher.finish128();
    [hash.h1, hash.h2]
}

/// A part of a name that no other thread or process takes, also on another computer.
fn unique() -> String {
    format!("{:016x}", RandomState::new().hash_one(()))
}
