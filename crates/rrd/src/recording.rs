//! A recording, and where the chunks of each of its entities lie.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use rerun::StoreKind;
use rerun::external::re_build_info::CrateVersion;
use rerun::external::re_log_types::StoreId;
use rerun::log::{Chunk, LogMsg};

use crate::cell::{Cell, cells, stamps_ns, times};
use crate::messages::{Location, Messages, chunk_of};
use crate::parts::{Marks, files_named_like_parts};
use crate::schema::{self, Entity};
use crate::{Damage, ReadError, Value};

/// A recording that can be read by entity and revolution: a file, and those of its later parts.
#[derive(Debug)]
pub struct Recording {
    pub(crate) parts: Vec<Part>,
    entities: BTreeMap<String, RecordedEntity>,
    damages: Vec<Damage>,
    /// Part numbers, as the parts state them.
    marks: Marks,
    /// The one that is read, if the file names any.
    store: Option<StoreId>,
    /// The file holds others beside it.
    is_chosen: bool,
}

/// One file of a recording.
#[derive(Debug)]
pub(crate) struct Part {
    pub(crate) path: PathBuf,
    pub(crate) version: CrateVersion,
    bytes: u64,
}

/// What a recording holds of one entity.
#[derive(Debug, Default)]
pub struct RecordedEntity {
    /// How many rows belong to a revolution.
    pub rows: u64,
    /// How many bytes all its rows take in the file.
    pub bytes: u64,
    /// First and last revolution; `None` if it only has values for the whole flight.
    pub revolutions: Option<[i64; 2]>,
    /// The earliest and the latest stamp, nanoseconds since the epoch.
    pub stamps_ns: Option<[i64; 2]>,
    /// Its components by name.
    pub components: BTreeMap<String, Component>,
    /// Where its changing chunks are, in the order of the file.
    pub(crate) chunks: Vec<ChunkLocation>,
    /// The latest values for the whole flight.
    pub(crate) fixed: Vec<Cell>,
}

/// One component of an entity.
#[derive(Debug, Default)]
pub struct Component {
    /// How many rows have it.
    pub rows: u64,
    /// Type and shape of its first value.
    pub first: String,
}

/// Whether a component is a picture of a matrix. Its numbers are right to half a decade. Those of W are all 0 at a
/// revolution without a picture: one without returns, or with more than 1024.
pub fn is_picture(component: &str) -> bool {
    component == schema::AFFINITY_W.values
}

/// Where a chunk lies, and its first revolution.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ChunkLocation {
    /// Index of its file.
    pub(crate) part: usize,
    pub(crate) location: Location,
    pub(crate) first: i64,
}

impl Recording {
    /// Goes through the file once, and through the files of later parts: FLIGHT-2.rrd after FLIGHT.rrd. The layout,
    /// which is a recording of its own within the file, is skipped.
    ///
    /// # Errors
    /// When the file cannot be opened, is no recording, or holds several. Damage is no error, see
    /// [`Recording::damages`].
    pub fn open(path: &Path) -> Result<Self, ReadError> {
        Self::open_chosen(path, &[], None)
    }

    /// As [`Recording::open`], of files that are given one by one; those of later parts are looked for beside a single one.
    ///
    /// # Errors
    /// As [`Recording::open`], for each file.
    pub fn open_parts(paths: &[PathBuf]) -> Result<Self, ReadError> {
        Self::open_chosen(&paths[0], &paths[1..], None)
    }

    /// Opens the recording with this identifier, of a file that holds several.
    ///
    /// # Errors
    /// As [`Recording::open`], and when the file holds no such recording.
    pub fn open_one(path: &Path, id: &str) -> Result<Self, ReadError> {
        Self::open_chosen(path, &[], Some(id))
    }

    fn open_chosen(path: &Path, further: &[PathBuf], id: Option<&str>) -> Result<Self, ReadError> {
        let recordings = Messages::recordings_in(path)?;
        let is_chosen = |store: &&StoreId| id.is_none_or(|id| store.recording_id().as_str() == id);
        let store = recordings.iter().find(is_chosen);
        let ids = || recordings.iter().map(|store| store.recording_id().to_string()).collect();
        match id {
            None if recordings.len() > 1 => return Err(ReadError::Several { path: path.to_owned(), ids: ids() }),
            Some(id) if store.is_none() => {
                return Err(ReadError::NoSuchRecording { path: path.to_owned(), id: id.to_owned(), ids: ids() });
            }
            _ => {}
        }
        let mut recording = Self {
            parts: Vec::new(),
            entities: BTreeMap::new(),
            damages: Vec::new(),
            marks: Marks::default(),
            store: store.cloned(),
            is_chosen: recordings.len() > 1,
        };
        recording.read_part(path, Messages::open(path)?);
        for part in further {
            recording.read_part(part, Messages::open(part)?);
        }
        for part in if further.is_empty() { files_named_like_parts(path) } else { Vec::new() } {
            if Messages::recordings_in(&part).is_ok_and(|others| others.first() == store)
                && let Ok(messages) = Messages::open(&part)
            {
                recording.read_part(&part, messages);
            }
        }
        let whole = recording.whole_to();
        for damage in &mut recording.damages {
            if let Damage::Unfinished { whole_to, .. } | Damage::CutOff { whole_to, .. } = damage {
                *whole_to = whole;
            }
        }
        recording.damages.extend(recording.marks.missing(path));
        Ok(recording)
    }

    /// What a viewer knows it by; `None` if the file does not begin with that.
    pub fn id(&self) -> Option<&str> {
        self.store.as_ref().map(|store| store.recording_id().as_str())
    }

    /// As above, with its application.
    pub fn store(&self) -> Option<&StoreId> {
        self.store.as_ref()
    }

    fn read_part(&mut self, path: &Path, messages: Messages) {
        let (version, bytes) = (messages.version(), messages.bytes());
        self.parts.push(Part { path: path.to_owned(), version, bytes });
        for message in messages {
            match message {
                Ok((location, LogMsg::ArrowMsg(store, message)))
                    if store.kind() == StoreKind::Recording
                        && (!self.is_chosen || self.store.as_ref() == Some(&store)) =>
                {
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

    /// What is missing or unreadable; empty for a complete recording.
    pub fn damages(&self) -> &[Damage] {
        &self.damages
    }

    /// The last revolution that every entity has which is written at every revolution.
    fn whole_to(&self) -> Option<i64> {
        let always = |path: &str| Entity::of(path).is_some_and(|entity| entity.when == schema::When::Revolution);
        let written = self.entities.iter().filter(|(path, _)| always(path));
        written.filter_map(|(_, entity)| entity.revolutions).map(|[_, last]| last).min()
    }

    /// Every entity by its path, which starts with a slash.
    pub fn entities(&self) -> &BTreeMap<String, RecordedEntity> {
        &self.entities
    }

    /// The component that holds the values of an entity; the others are drawings of them. `None` without any.
    pub fn values_component(&self, entity: &str) -> Option<&str> {
        let components = &self.entities.get(entity)?.components;
        let mut known = Entity::of(entity).into_iter().chain(schema::ENTITIES).map(|entity| entity.values);
        known.find(|name| components.contains_key(*name)).or_else(|| components.keys().next().map(String::as_str))
    }

    /// The resolved configuration as TOML, if it is in the recording.
    pub fn config_toml(&self) -> Option<String> {
        match self.value_throughout(schema::CONFIG.path, schema::CONFIG.values) {
            Ok(Some(Value::Texts(texts))) => texts.into_iter().next(),
            _ => None,
        }
    }

    /// The value of a component for the whole flight; `None` if its values belong to revolutions, or there are none.
    ///
    /// # Errors
    /// When the component holds neither numbers nor words.
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
        if name == schema::PART.path {
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
