//! The components of a row of a chunk.

use rerun::external::arrow::array::ArrayRef;
use rerun::log::Chunk;

/// One component of one row, as Rerun holds it.
#[derive(Clone, Debug)]
pub(crate) struct Cell {
    pub(crate) component: String,
    /// Rerun's name of its type.
    pub(crate) type_name: String,
    pub(crate) values: ArrayRef,
}

/// The components of a row of a chunk, by name.
pub(crate) fn cells(chunk: &Chunk, row: usize) -> Vec<Cell> {
    let columns = chunk.components().values();
    let cell = |column: &rerun::SerializedComponentColumn| {
        let descriptor = &column.descriptor;
        let values = chunk.component_batch_raw(descriptor.component, row)?.ok()?;
        let type_name = descriptor.component_type.map_or_else(String::new, |name| name.to_string());
        Some(Cell { component: descriptor.component.to_string(), type_name, values })
    };
    let mut cells: Vec<Cell> = columns.filter_map(cell).collect();
    cells.sort_by(|a, b| a.component.cmp(&b.component));
    cells
}

/// The revolution of each row; empty for values of the whole flight.
pub(crate) fn times(chunk: &Chunk) -> &[i64] {
    column(chunk, "revolution")
}

/// The stamp of each row.
pub(crate) fn stamps_ns(chunk: &Chunk) -> &[i64] {
    column(chunk, "stamp")
}

fn column<'a>(chunk: &'a Chunk, timeline: &'static str) -> &'a [i64] {
    chunk.timelines().get(&timeline.into()).map_or(&[], rerun::TimeColumn::times_raw)
}
