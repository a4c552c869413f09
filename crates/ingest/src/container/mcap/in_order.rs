//! An MCAP that is read from its first byte to its last while it comes: a file that is still being written, or a pipe.

use std::fs::File;
use std::io::{self, BufRead, Read as _};
use std::path::{Path, PathBuf};

use mcap::records::op;

use super::chunk::visit_chunk;
use super::data_section::{DataSection, ends_data};
use super::records::{HEAD_BYTES, Schemas, read_head, skip, visit};
use crate::container::chunked::{ChunkedFile as _, Progress, Visitor};
use crate::container::resting_file::RestingFile;
use crate::{Damage, Following, Loss, LossKind};

/// What one step through it came to.
pub(crate) struct Read {
    pub(crate) loss: Option<Loss>,
    pub(crate) has_ended: bool,
}

impl Read {
    fn of(progress: Progress, path: &Path) -> Self {
        let (kind, has_ended) = match progress {
            Progress::Whole => (None, false),
            Progress::Lost { at_byte, damage } => (Some(LossKind::Part { at_byte, scans: None, damage }), false),
            Progress::End { .. } => (None, true),
            Progress::Stopped { at_byte, damage: Damage::Ended } => (Some(LossKind::CutOff { at_byte }), true),
            Progress::Stopped { at_byte, damage } => (Some(LossKind::Rest { at_byte, damage }), true),
        };
        Self { loss: kind.map(|kind| Loss { file: path.to_owned(), kind }), has_ended }
    }
}

/// A file that is still being written.
pub(crate) struct FollowedMcap {
    section: DataSection,
    path: PathBuf,
}

/// Opens a file that begins with the magic bytes.
pub(crate) fn follow(path: &Path, file: File, following: &Following) -> io::Result<FollowedMcap> {
    let file = RestingFile::new(path.to_owned(), file);
    let length = file.length()?;
    let mut section = DataSection::new(file, length)?;
    section.follow(following);
    Ok(FollowedMcap { section, path: path.to_owned() })
}

impl FollowedMcap {
    /// Hands the next record, or all of the next chunk, to `visitor`; waits until it is there.
    pub(crate) fn step(&mut self, visitor: &mut impl Visitor) -> Read {
        Read::of(self.section.step(visitor), &self.path)
    }
}

/// A pipe.
pub(crate) struct PipedMcap<R> {
    input: R,
    path: PathBuf,
    at_byte: u64,
    schemas: Schemas,
    body: Vec<u8>,
}

impl<R: BufRead> PipedMcap<R> {
    /// `input` is behind the magic bytes; `path` names it in losses.
    pub(crate) fn new(input: R, path: &Path) -> Self {
        let at_byte = mcap::MAGIC.len() as u64;
        Self { input, path: path.to_owned(), at_byte, schemas: Schemas::new(), body: Vec::new() }
    }

    /// Hands the next record, or all of the next chunk, to `visitor`; waits until it is there.
    pub(crate) fn step(&mut self, visitor: &mut impl Visitor) -> Read {
        Read::of(self.progress(visitor), &self.path)
    }

    fn progress(&mut self, visitor: &mut impl Visitor) -> Progress {
        let at_byte = self.at_byte;
        let (opcode, length) = match read_head(&mut self.input) {
            Ok(Some(head)) => head,
            Ok(None) => return Progress::Stopped { at_byte, damage: Damage::Ended },
            Err(damage) => return Progress::Stopped { at_byte, damage },
        };
        if ends_data((opcode, length)) {
            return Progress::End { at_byte };
        }
        if opcode == 0 {
            let damage = Damage::Record("a record of type 0 cannot be".to_owned());
            return Progress::Stopped { at_byte, damage };
        }
        let mut record = (&mut self.input).take(length);
        let visited = match opcode {
            op::CHUNK => visit_chunk(&mut record, (&mut self.schemas, &mut self.body), visitor),
            _ => visit((opcode, length), &mut record, (&mut self.schemas, &mut self.body), visitor),
        };
        let left = record.limit();
        let is_cut_off = skip(&mut record, left).is_err();
        self.at_byte = at_byte.saturating_add(HEAD_BYTES).saturating_add(length);
        Progress::settled(visited, at_byte, is_cut_off, visitor)
    }
}
