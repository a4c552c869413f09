//! Rows that wait for the next flush. The rows of an entity are sent together, as one chunk.
//!
//! `RecordingStream::log` hands each row to another thread, which costs more than the row. Only viewers, which show
//! rows between two flushes, get them that way.

use std::collections::BTreeMap;

use rerun::external::arrow::array::{Array as _, ArrayRef};
use rerun::external::re_arrow_util::arrays_to_list_array_opt;
use rerun::log::TimeColumn;
use rerun::{
    AsComponents, ComponentDescriptor, RecordingStream, RecordingStreamError, RecordingStreamResult,
    SerializedComponentBatch, SerializedComponentColumn,
};

use crate::schema::Entity;

/// Collects the rows of all entities.
pub(crate) struct Rows {
    rec: RecordingStream,
    /// Rows are sent at once, as viewers are connected.
    at_once: bool,
    /// Revolution and stamp of the rows to come; `None` before the first revolution.
    time: Option<[i64; 2]>,
    /// The rows that wait, by path.
    waiting: BTreeMap<&'static str, Waiting>,
    /// Bytes of all rows that wait.
    bytes: usize,
    /// The first error so far.
    failed: Option<RecordingStreamError>,
}

/// The rows of one entity.
#[derive(Default)]
struct Waiting {
    revolutions: Vec<i64>,
    stamps_ns: Vec<i64>,
    columns: Vec<Column>,
}

/// The values of one component by row; `None` where a row lacks it.
struct Column {
    descriptor: ComponentDescriptor,
    cells: Vec<Option<ArrayRef>>,
}

impl Rows {
    pub(crate) fn new(rec: RecordingStream, at_once: bool) -> Self {
        Self { rec, at_once, time: None, waiting: BTreeMap::new(), bytes: 0, failed: None }
    }

    /// Sets the time of the rows to come.
    pub(crate) fn set_time(&mut self, revolution: u64, stamp_ns: u64) {
        let [revolution, stamp_ns] = [revolution, stamp_ns].map(u64::cast_signed);
        self.time = Some([revolution, stamp_ns]);
        self.rec.set_time_sequence("revolution", revolution);
        self.rec.set_timestamp_nanos_since_epoch("stamp", stamp_ns);
    }

    /// Adds a row of an entity. Before the first revolution it holds for the whole recording.
    pub(crate) fn log(&mut self, entity: &Entity, values: &(impl AsComponents + ?Sized)) {
        self.log_at(entity.path, values);
    }

    /// Adds a row at a path.
    pub(crate) fn log_at(&mut self, path: &'static str, values: &(impl AsComponents + ?Sized)) {
        let batches = values.as_serialized_batches();
        let Some(time) = self.time.filter(|_| !self.at_once) else {
            let logged = self.rec.log_serialized_batches(path, self.time.is_none(), batches);
            self.failed = self.failed.take().or(logged.err());
            return;
        };
        self.bytes += batches.iter().map(|batch| batch.array.get_buffer_memory_size()).sum::<usize>();
        self.waiting.entry(path).or_default().push(time, batches);
    }

    /// Bytes of all rows that wait.
    pub(crate) fn bytes(&self) -> usize {
        self.bytes
    }

    /// Sends all rows that wait.
    ///
    /// # Errors
    /// When Rerun refused a row.
    pub(crate) fn send(&mut self) -> RecordingStreamResult<()> {
        self.bytes = 0;
        for (path, waiting) in std::mem::take(&mut self.waiting) {
            let times = [
                TimeColumn::new_sequence("revolution", waiting.revolutions),
                TimeColumn::new_timestamp_nanos_since_epoch("stamp", waiting.stamps_ns),
            ];
            self.rec.send_columns(path, times, waiting.columns.into_iter().filter_map(Column::into_serialized))?;
        }
        self.failed.take().map_or(Ok(()), Err)
    }
}

impl Waiting {
    fn push(&mut self, [revolution, stamp_ns]: [i64; 2], batches: Vec<SerializedComponentBatch>) {
        let row = self.revolutions.len();
        self.revolutions.push(revolution);
        self.stamps_ns.push(stamp_ns);
        for (at, SerializedComponentBatch { descriptor, array }) in batches.into_iter().enumerate() {
            let is_same = |column: &Column| column.descriptor == descriptor;
            // A row mostly has the components of the one before.
            let known = self.columns.get(at).is_some_and(is_same).then_some(at);
            let known = known.or_else(|| self.columns.iter().position(is_same));
            let column = known.unwrap_or_else(|| {
                self.columns.push(Column { descriptor, cells: Vec::new() });
                self.columns.len() - 1
            });
            let cells = &mut self.columns[column].cells;
            cells.resize(row, None);
            cells.push(Some(array));
        }
        for column in &mut self.columns {
            column.cells.resize(row + 1, None);
        }
    }
}

impl Column {
    fn into_serialized(self) -> Option<SerializedComponentColumn> {
        let cells: Vec<_> = self.cells.iter().map(Option::as_deref).collect();
        Some(SerializedComponentColumn::new(arrays_to_list_array_opt(&cells)?, self.descriptor))
    }
}
