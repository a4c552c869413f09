//! A recording, and where the chunks of each of its entities lie.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use rerun::external::re_build_info::CrateVersion;
use rerun::external::re_log_types::StoreId;
use rerun::log::{Chunk, LogMsg};
use rerun::{StoreKind, TextDocument};

use super::messages::{Location, Messages, chunk_of};
use super::rows::{Cell, Rows, cells, stamps_ns, times};
use super::{Damage, ReadError, Value};
use crate::parts::{MARK, Marks, called_like_parts};

/// A recording that can be read by entity and revolution: a file, and those that it goes on in.
#[derive(Debug)]
pub struct Recording {
    pub(super) parts: Vec<Part>,
    entities: BTreeMap<String, Entity>,
    damages: Vec<Damage>,
    /// What the parts say of themselves.
    marks: Marks,
}

/// One file of a recording.
#[derive(Debug)]
pub(super) struct Part {
    pub(super) path: PathBuf,
    pub(super) version: CrateVersion,
    bytes: u64,
    /// The recording that it says to belong to.
    store: Option<StoreId>,
}

/// What a recording holds of one entity.
#[derive(Debug, Default)]
pub struct Entity {
    /// Rows that belong to a revolution.
    pub rows: u64,
    /// Bytes that all its rows take in the file.
    pub bytes: u64,
    /// First and last revolution; `None` if it holds for the whole flight alone.
    pub revolutions: Option<[i64; 2]>,
    /// The earliest and the latest stamp, nanoseconds since the epoch.
    pub stamps_ns: Option<[i64; 2]>,
    /// Its components by name.
    pub components: BTreeMap<String, Component>,
    /// Where its changing chunks are, in the order of the file.
    pub(super) chunks: Vec<ChunkLocation>,
    /// The latest of what holds for the whole flight.
    pub(super) fixed: Vec<Cell>,
}

/// One component of an entity.
#[derive(Debug, Default)]
pub struct Component {
    /// Rows that have it.
    pub rows: u64,
    /// What the first of them holds, in a few words: type and shape.
    pub first: String,
}

/// W and L as pictures.
const PICTURE: &str = "EncodedDepthImage:blob";

/// Components that hold values rather than drawings of them, the first of an entity's before the others.
const VALUES: [&str; 9] = [
    "Tensor:data",
    "BarChart:values",
    "Scalars:scalars",
    PICTURE,
    "StateChange:state",
    "TextDocument:text",
    "TextLog:text",
    "Points3D:positions",
    "LineStrips3D:strips",
];

impl Entity {
    /// The component that holds its values: numbers stand beside what is drawn of them.
    pub fn values_component(&self) -> Option<&str> {
        let first = || self.components.keys().next().map(String::as_str);
        VALUES.into_iter().find(|name| self.components.contains_key(*name)).or_else(first)
    }
}

/// Whether a component is a picture of a matrix: its numbers are right to half a decade, and those of W all 0 where none is
/// drawn, of a revolution without returns or with more than 1024.
pub fn is_picture(component: &str) -> bool {
    component == PICTURE
}

/// Whether a component is there for the eye.
pub(super) fn is_drawing(component: &str) -> bool {
    !VALUES.contains(&component)
}

/// Where a chunk lies, and its first revolution.
#[derive(Clone, Copy, Debug)]
pub(super) struct ChunkLocation {
    /// Index of its file.
    pub(super) part: usize,
    pub(super) location: Location,
    pub(super) first: i64,
}

impl Recording {
    /// Goes through the file once, and through the files that the recording goes on in: FLIGHT-2.rrd after FLIGHT.rrd.
    /// The layout, which is a recording of its own within the file, is passed over.
    ///
    /// # Errors
    /// When the file cannot be opened or is no recording. Damage is no error, see [`Recording::damages`].
    pub fn open(path: &Path) -> Result<Self, ReadError> {
        let mut recording =
            Self { parts: Vec::new(), entities: BTreeMap::new(), damages: Vec::new(), marks: Marks::default() };
        recording.read_part(path, Messages::open(path)?);
        for next in called_like_parts(path) {
            if let Ok(mut messages) = Messages::open(&next)
                && messages.store() == recording.parts[0].store
            {
                recording.read_part(&next, messages);
            }
        }
        recording.damages.extend(recording.marks.missing(path));
        Ok(recording)
    }

    fn read_part(&mut self, path: &Path, mut messages: Messages) {
        let (version, bytes, store) = (messages.version(), messages.bytes(), messages.store());
        self.parts.push(Part { path: path.to_owned(), version, bytes, store });
        for message in messages {
            match message {
                Ok((location, LogMsg::ArrowMsg(store, message))) if store.kind() == StoreKind::Recording => {
                    match chunk_of(&message) {
                        Ok(chunk) => self.note(location, &chunk),
                        Err(cause) => {
                            self.damages.push(Damage::Unreadable { path: path.to_owned(), at: location.at, cause });
                        }
                    }
                }
                Ok(_) => {}
                Err(damage) => self.damages.push(damage),
            }
        }
    }

    /// The files, in order.
    pub fn paths(&self) -> impl Iterator<Item = &Path> {
        self.parts.iter().map(|part| part.path.as_path())
    }

    /// Length of all files.
    pub fn bytes(&self) -> u64 {
        self.parts.iter().map(|part| part.bytes).sum()
    }

    /// The version of Rerun that wrote it.
    pub fn rerun_version(&self) -> String {
        self.parts[0].version.to_string()
    }

    /// What is missing or unreadable; empty for a recording that is whole.
    pub fn damages(&self) -> &[Damage] {
        &self.damages
    }

    /// Every entity by its path, which starts with a slash.
    pub fn entities(&self) -> &BTreeMap<String, Entity> {
        &self.entities
    }

    /// The rows of an entity by revolution.
    ///
    /// # Errors
    /// When there is no such entity.
    pub fn rows(&self, entity: &str) -> Result<Rows<'_>, ReadError> {
        let Some((name, found)) = self.entities.get_key_value(entity) else {
            let step = |name: &str| name.split('/').nth(1).unwrap_or_default().to_owned();
            let mut near: Vec<_> = self.entities.keys().filter(|name| step(name) == step(entity)).cloned().collect();
            if near.is_empty() {
                near = self.entities.keys().cloned().collect();
            }
            return Err(ReadError::NoSuchEntity { entity: entity.to_owned(), near });
        };
        Ok(Rows::new(self, name, found))
    }

    /// The resolved configuration as TOML, if it is in the recording.
    pub fn config_toml(&self) -> Option<String> {
        match self.value_throughout("/config", TextDocument::descriptor_text().component.as_str()) {
            Ok(Some(Value::Texts(texts))) => texts.into_iter().next(),
            _ => None,
        }
    }

    /// What a component holds throughout the flight; `None` if it belongs to revolutions, or is not there.
    ///
    /// # Errors
    /// When it holds neither numbers nor words.
    pub fn value_throughout(&self, entity: &str, component: &str) -> Result<Option<Value>, ReadError> {
        let fixed = self.entities.get(entity).map_or(&[][..], |entity| &entity.fixed);
        let Some(cell) = fixed.iter().find(|cell| cell.component == component) else { return Ok(None) };
        Value::of(cell, fixed).map(Some).map_err(|cause| ReadError::NotAValue {
            entity: entity.to_owned(),
            component: component.to_owned(),
            cause,
        })
    }

    fn note(&mut self, location: Location, chunk: &Chunk) {
        let name = chunk.entity_path().to_string();
        if name == MARK {
            self.marks.read(chunk);
        }
        let entity = self.entities.entry(name).or_default();
        entity.bytes += location.bytes;
        let revolutions = times(chunk);
        for row in 0..chunk.num_rows() {
            let cells = cells(chunk, row);
            for cell in &cells {
                let component = entity.components.entry(cell.component.clone()).or_default();
                if component.rows == 0 {
                    component.first = Value::of(cell, &cells).map_or_else(|what| what, |value| value.to_string());
                }
                component.rows += 1;
            }
            if chunk.is_static() {
                entity.fixed.retain(|old| cells.iter().all(|new| new.component != old.component));
                entity.fixed.extend(cells);
            }
        }
        if let Some(&first) = revolutions.iter().min() {
            entity.rows += chunk.num_rows() as u64;
            entity.chunks.push(ChunkLocation { part: self.parts.len() - 1, location, first });
            widen(&mut entity.revolutions, revolutions);
            widen(&mut entity.stamps_ns, stamps_ns(chunk));
        }
    }
}

/// Makes `range` reach over all of `times`.
fn widen(range: &mut Option<[i64; 2]>, times: &[i64]) {
    for &time in times {
        let [first, last] = range.get_or_insert([time; 2]);
        (*first, *last) = ((*first).min(time), (*last).max(time));
    }
}
