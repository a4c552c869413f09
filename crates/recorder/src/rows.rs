//! Rows that wait for the next flush. The rows of an entity are sent together, as one chunk.
//!
//! `RecordingStream::log` hands each row to another thread, which costs more than the row. Only viewers, which show
//! rows between two flushes, get them that way.

use std::collections::BTreeMap;

use rerun::external::arrow::array::{Array as _, ArrayRef, ListArray};
use rerun::external::arrow::buffer::{NullBuffer, OffsetBuffer};
use rerun::external::re_arrow_util::{arrays_to_list_array_opt, canonical_component_list_field};
use rerun::log::TimeColumn;
use rerun::{
    AsComponents, BarChart, ComponentBatch as _, ComponentDescriptor, Loggable, RecordingStream, RecordingStreamError,
    RecordingStreamResult, SerializationResult, SerializedComponentBatch, SerializedComponentColumn, Tensor,
    TensorData, components,
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
    cells: Vec<Option<Cell>>,
}

/// The value of a component in one row.
enum Cell {
    Array(ArrayRef),
    /// All tensors of a column become one array: an array for each, which has a child for every type of numbers, takes longer than
    /// its values.
    Tensor(TensorData),
}

impl Cell {
    fn bytes(&self) -> usize {
        match self {
            Self::Array(array) => array.get_buffer_memory_size(),
            Self::Tensor(tensor) => tensor.buffer.size_in_bytes(),
        }
    }
}

fn described(batch: SerializedComponentBatch) -> (ComponentDescriptor, Cell) {
    (batch.descriptor, Cell::Array(batch.array))
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
        self.push(path, time, batches.into_iter().map(described).collect());
    }

    /// Adds a row of an entity: a tensor, and what draws it.
    pub(crate) fn log_tensor(&mut self, entity: &Entity, tensor: TensorData, drawn: &[&dyn AsComponents]) {
        self.log_numbers(entity, Tensor::descriptor_data(), tensor, drawn);
    }

    /// Adds a row of an entity that is a chart of these numbers.
    pub(crate) fn log_chart(&mut self, entity: &Entity, numbers: TensorData) {
        self.log_numbers(entity, BarChart::descriptor_values(), numbers, &[]);
    }

    fn log_numbers(
        &mut self,
        entity: &Entity,
        is: ComponentDescriptor,
        numbers: TensorData,
        drawn: &[&dyn AsComponents],
    ) {
        let drawn = drawn.iter().flat_map(|drawn| drawn.as_serialized_batches());
        let Some(time) = self.time.filter(|_| !self.at_once) else {
            let batches = components::TensorData(numbers).serialized(is).into_iter().chain(drawn);
            let logged = self.rec.log_serialized_batches(entity.path, self.time.is_none(), batches);
            self.failed = self.failed.take().or(logged.err());
            return;
        };
        let numbers = (is, Cell::Tensor(numbers));
        self.push(entity.path, time, std::iter::once(numbers).chain(drawn.map(described)).collect());
    }

    fn push(&mut self, path: &'static str, time: [i64; 2], cells: Vec<(ComponentDescriptor, Cell)>) {
        self.bytes += cells.iter().map(|(_, cell)| cell.bytes()).sum::<usize>();
        self.waiting.entry(path).or_default().push(time, cells);
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
            let columns =
                waiting.columns.into_iter().map(Column::into_serialized).collect::<SerializationResult<Vec<_>>>()?;
            self.rec.send_columns(path, times, columns.into_iter().flatten())?;
        }
        self.failed.take().map_or(Ok(()), Err)
    }
}

impl Waiting {
    fn push(&mut self, [revolution, stamp_ns]: [i64; 2], row: Vec<(ComponentDescriptor, Cell)>) {
        let number = self.revolutions.len();
        self.revolutions.push(revolution);
        self.stamps_ns.push(stamp_ns);
        for (at, (descriptor, cell)) in row.into_iter().enumerate() {
            let is_same = |column: &Column| column.descriptor == descriptor;
            // A row mostly has the components of the one before.
            let known = self.columns.get(at).is_some_and(is_same).then_some(at);
            let known = known.or_else(|| self.columns.iter().position(is_same));
            let column = known.unwrap_or_else(|| {
                self.columns.push(Column { descriptor, cells: Vec::new() });
                self.columns.len() - 1
            });
            let cells = &mut self.columns[column].cells;
            cells.resize_with(number, || None);
            cells.push(Some(cell));
        }
        for column in &mut self.columns {
            column.cells.resize_with(number + 1, || None);
        }
    }
}

impl Column {
    fn into_serialized(self) -> SerializationResult<Option<SerializedComponentColumn>> {
        let is_tensor = |cell: &Option<Cell>| !matches!(cell, Some(Cell::Array(_)));
        let list = if self.cells.iter().all(is_tensor) { tensors(&self.cells)? } else { arrays(&self.cells)? };
        Ok(list.map(|list| SerializedComponentColumn::new(list, self.descriptor)))
    }
}

/// The cells of a column of tensors alone.
fn tensors(cells: &[Option<Cell>]) -> SerializationResult<Option<ListArray>> {
    let of = |cell: &Option<Cell>| match cell {
        Some(Cell::Tensor(tensor)) => Some(components::TensorData(tensor.clone())),
        _ => None,
    };
    let values = <components::TensorData as Loggable>::to_arrow(cells.iter().filter_map(of))?;
    let field = canonical_component_list_field(values.data_type().clone());
    let offsets = OffsetBuffer::from_lengths(cells.iter().map(|cell| usize::from(cell.is_some())));
    let nulls: NullBuffer = cells.iter().map(Option::is_some).collect();
    Ok(Some(ListArray::new(field.into(), offsets, values, Some(nulls))))
}

/// The cells of any other column.
fn arrays(cells: &[Option<Cell>]) -> SerializationResult<Option<ListArray>> {
    let array = |cell: &Option<Cell>| match cell {
        Some(Cell::Array(array)) => Ok(Some(ArrayRef::clone(array))),
        Some(Cell::Tensor(tensor)) => {
            <components::TensorData as Loggable>::to_arrow([components::TensorData(tensor.clone())]).map(Some)
        }
        None => Ok(None),
    };
    let arrays = cells.iter().map(array).collect::<SerializationResult<Vec<_>>>()?;
    Ok(arrays_to_list_array_opt(&arrays.iter().map(Option::as_deref).collect::<Vec<_>>()))
}
