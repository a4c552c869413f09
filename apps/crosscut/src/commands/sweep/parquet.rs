//! The table with types, for pandas, Polars and DuckDB.

use std::path::Path;
use std::sync::Arc;

use anyhow::Context;
use crosscut_rrd::arrow::array::{ArrayRef, Float64Array, Int64Array, RecordBatch, StringArray};
use crosscut_rrd::arrow::datatypes::{Field, Schema};

use super::grid::Grid;
use super::output::{COUNTS, FIGURES, Row};
use crate::commands::rrd::parquet::ParquetFile;
use crate::unfinished::Unfinished;

pub(super) fn write(path: &Path, program: &str, grid: &Grid, rows: &[Row<'_>]) -> anyhow::Result<()> {
    let texts =
        |of: &dyn Fn(&Row<'_>) -> String| -> ArrayRef { Arc::new(StringArray::from_iter_values(rows.iter().map(of))) };
    let mut columns: Vec<(&str, ArrayRef)> = vec![
        ("flight", texts(&|row| row.flight.to_owned())),
        ("input_hash", texts(&|row| row.input.to_owned())),
        ("program", texts(&|_| program.to_owned())),
    ];
    for (place, key) in grid.keys.iter().enumerate() {
        let numbers: Option<Vec<f64>> = rows.iter().map(|row| row.point[place].parse().ok()).collect();
        let column = match numbers {
            Some(numbers) => Arc::new(Float64Array::from(numbers)),
            None => texts(&|row| row.point[place].clone()),
        };
        columns.push((key, column));
    }
    for name in FIGURES {
        let values = rows.iter().map(|row| row.figure(name));
        let column: ArrayRef = if COUNTS.contains(&name) {
            Arc::new(Int64Array::from_iter(values.map(|value| value.map(|value| value as i64))))
        } else {
            Arc::new(Float64Array::from_iter(values))
        };
        columns.push((name, column));
    }
    let fields = columns.iter().map(|(name, column)| Field::new(*name, column.data_type().clone(), true));
    let schema = Arc::new(Schema::new(fields.collect::<Vec<_>>()));
    let table = RecordBatch::try_new(schema, columns.into_iter().map(|(_, column)| column).collect())?;
    let cannot = || format!("cannot write {}", path.display());
    let unfinished = Unfinished::beside(path);
    let mut file = ParquetFile::new(unfinished.create().with_context(cannot)?);
    file.add(&table).and_then(|()| file.finish()).with_context(cannot)?;
    unfinished.finish().with_context(cannot)
}
