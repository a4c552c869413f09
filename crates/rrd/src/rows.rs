//! The rows of one entity by revolution, whatever the chunks that they were written in.

use std::collections::VecDeque;
use std::fs::File;

use rerun::log::Chunk;

use crate::cell::{Cell, cells, stamps_ns, times};
use crate::messages::chunk_at;
use crate::recording::{ChunkLocation, RecordedEntity, Recording};
use crate::{ReadError, Value};

/// The values of an entity at one revolution.
#[derive(Debug)]
pub struct Row<'a> {
    entity: &'a str,
    /// The revolution.
    pub revolution: i64,
    /// The sensor's stamp, nanoseconds since the epoch.
    pub stamp_ns: Option<i64>,
    pub(crate) cells: Vec<Cell>,
    fixed: &'a [Cell],
}

impl Row<'_> {
    /// The components of this row. One that was logged several times at this revolution occurs as often.
    pub fn components(&self) -> impl Iterator<Item = &str> {
        self.cells.iter().map(|cell| cell.component.as_str())
    }

    /// The value of a component.
    ///
    /// A picture of W or L comes as numbers: level v of a picture whose brightest level is m stands for
    /// 10^(16 (v / m - 1)), right to half a level. Level 0 stands for 1e-16 or less, and comes as 0. Rows and columns
    /// are those of the picture.
    ///
    /// # Errors
    /// When the row lacks the component, or it holds neither numbers nor words.
    pub fn value(&self, component: &str) -> Result<Value, ReadError> {
        self.values(component).next().unwrap_or_else(|| {
            Err(ReadError::NoSuchComponent {
                entity: self.entity.to_owned(),
                component: component.to_owned(),
                known: self.components().map(str::to_owned).collect(),
            })
        })
    }

    /// Every value of a component that was logged at this revolution, in the order of logging.
    pub fn values(&self, component: &str) -> impl Iterator<Item = Result<Value, ReadError>> {
        self.cells.iter().filter(move |cell| cell.component == component).map(|cell| {
            let beside = [&self.cells, self.fixed].concat();
            Value::of(cell, &beside).map_err(|cause| ReadError::NotAValue {
                entity: self.entity.to_owned(),
                component: cell.component.clone(),
                cause,
            })
        })
    }
}

/// The rows of an entity by revolution. At any time only the chunks that cover the next revolution are in memory.
#[derive(Debug)]
pub struct Rows<'a> {
    recording: &'a Recording,
    name: &'a str,
    entity: &'a RecordedEntity,
    /// The file that was read last, and its index.
    file: Option<(usize, File)>,
    waiting: VecDeque<ChunkLocation>,
    open: Vec<OpenChunk>,
}

#[derive(Debug)]
struct OpenChunk {
    chunk: Chunk,
    /// The rows that are left, by revolution.
    left: VecDeque<usize>,
}

impl Recording {
    /// The rows of an entity by revolution.
    ///
    /// # Errors
    /// When there is no such entity.
    pub fn rows(&self, entity: &str) -> Result<Rows<'_>, ReadError> {
        let Some((name, found)) = self.entities().get_key_value(entity) else {
            let step = |name: &str| name.split('/').nth(1).unwrap_or_default().to_owned();
            let mut near: Vec<_> = self.entities().keys().filter(|name| step(name) == step(entity)).cloned().collect();
            if near.is_empty() {
                near.extend(self.entities().keys().cloned());
            }
            return Err(ReadError::NoSuchEntity { entity: entity.to_owned(), near });
        };
        Ok(Rows::new(self, name, found))
    }
}

impl<'a> Rows<'a> {
    pub(crate) fn new(recording: &'a Recording, name: &'a str, entity: &'a RecordedEntity) -> Self {
        let mut waiting = entity.chunks.clone();
        waiting.sort_by_key(|chunk| chunk.first); // stable: what was logged first comes first
        Self { recording, name, entity, file: None, waiting: waiting.into(), open: Vec::new() }
    }

    fn next_revolution(&self) -> Option<i64> {
        let open = self.open.iter().filter_map(OpenChunk::next_revolution);
        open.chain(self.waiting.front().map(|chunk| chunk.first)).min()
    }

    fn load(&mut self, chunk: ChunkLocation) -> Result<(), ReadError> {
        let part = &self.recording.parts[chunk.part];
        let changed = |cause: String| ReadError::Changed { path: part.path.clone(), cause };
        if self.file.as_ref().is_none_or(|(open, _)| *open != chunk.part) {
            let file = File::open(&part.path).map_err(|e| changed(e.to_string()))?;
            self.file = Some((chunk.part, file));
        }
        let (_, file) = self.file.as_mut().expect("opened above");
        let chunk = chunk_at(file, chunk.location, part.version).map_err(changed)?;
        let mut left: Vec<usize> = (0..times(&chunk).len()).collect();
        left.sort_by_key(|&row| times(&chunk)[row]);
        self.open.push(OpenChunk { chunk, left: left.into() });
        Ok(())
    }

    /// Everything that was logged at a revolution, from all chunks that cover it.
    fn row(&mut self, revolution: i64) -> Row<'a> {
        let (mut all, mut stamp_ns) = (Vec::new(), None);
        for open in &mut self.open {
            while open.next_revolution() == Some(revolution)
                && let Some(row) = open.left.pop_front()
            {
                all.extend(cells(&open.chunk, row));
                stamp_ns = stamp_ns.or_else(|| stamps_ns(&open.chunk).get(row).copied());
            }
        }
        self.open.retain(|open| !open.left.is_empty());
        Row { entity: self.name, revolution, stamp_ns, cells: all, fixed: &self.entity.fixed }
    }
}

impl OpenChunk {
    fn next_revolution(&self) -> Option<i64> {
        self.left.front().map(|&row| times(&self.chunk)[row])
    }
}

impl<'a> Iterator for Rows<'a> {
    type Item = Result<Row<'a>, ReadError>;

    fn next(&mut self) -> Option<Self::Item> {
        let revolution = self.next_revolution()?;
        while let Some(chunk) = self.waiting.pop_front_if(|chunk| chunk.first <= revolution) {
            if let Err(error) = self.load(chunk) {
                return Some(Err(error));
            }
        }
        Some(Ok(self.row(revolution)))
    }
}
