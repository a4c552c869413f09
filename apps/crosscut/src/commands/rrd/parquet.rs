//! Apache Parquet: the table that a CSV file is, with types. Plain columns without compression, in groups of rows.

use std::fs::File;
use std::sync::Arc;

use anyhow::{Context as _, bail};
use crosscut_recorder::{Numbers, Value};
use parquet::basic::{LogicalType, Repetition, Type as PhysicalType};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, FloatType, Int64Type};
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::Type;

use super::table::{self, Item};
use crate::exit::UsageError;

/// A group of rows is written when there are so many.
const GROUP_ROWS: usize = 1 << 20;

/// The rows of one column that are not yet written.
enum Rows {
    I64(Vec<i64>),
    F32(Vec<f32>),
    F64(Vec<f64>),
    Text(Vec<ByteArray>),
}

impl Rows {
    /// For what the value holds.
    fn of(value: &Value) -> anyhow::Result<Self> {
        let of_numbers = |numbers: &Numbers| match numbers {
            Numbers::F64(_) => Self::F64(Vec::new()),
            Numbers::F32(_) => Self::F32(Vec::new()),
            Numbers::I64(_) => Self::I64(Vec::new()),
        };
        Ok(match value {
            Value::Numbers(array) => of_numbers(&array.numbers),
            Value::Lists(lists) => lists.first().map_or(Self::F32(Vec::new()), |list| of_numbers(&list.numbers)),
            Value::Texts(_) => Self::Text(Vec::new()),
            other => bail!("{other} cannot be written as a table"),
        })
    }

    fn push(&mut self, item: Item) -> anyhow::Result<()> {
        match (self, item) {
            (Self::I64(rows), Item::I64(i)) => rows.push(i),
            (Self::F32(rows), Item::F32(x)) => rows.push(x),
            (Self::F64(rows), Item::F64(x)) => rows.push(x),
            (Self::Text(rows), Item::Text(text)) => rows.push(ByteArray::from(text)),
            _ => return Err(columns_differ()),
        }
        Ok(())
    }

    fn len(&self) -> usize {
        match self {
            Self::I64(rows) => rows.len(),
            Self::F32(rows) => rows.len(),
            Self::F64(rows) => rows.len(),
            Self::Text(rows) => rows.len(),
        }
    }

    /// The column's type in the file.
    fn schema(&self, name: &str) -> anyhow::Result<Type> {
        let (physical, logical) = match self {
            Self::I64(_) => (PhysicalType::INT64, None),
            Self::F32(_) => (PhysicalType::FLOAT, None),
            Self::F64(_) => (PhysicalType::DOUBLE, None),
            Self::Text(_) => (PhysicalType::BYTE_ARRAY, Some(LogicalType::String)),
        };
        let column = Type::primitive_type_builder(name, physical).with_logical_type(logical);
        Ok(column.with_repetition(Repetition::REQUIRED).build()?)
    }

    /// Writes the rows and forgets them.
    fn write(&mut self, out: &mut SerializedColumnWriter<'_>) -> anyhow::Result<()> {
        match self {
            Self::I64(rows) => out.typed::<Int64Type>().write_batch(&std::mem::take(rows), None, None),
            Self::F32(rows) => out.typed::<FloatType>().write_batch(&std::mem::take(rows), None, None),
            Self::F64(rows) => out.typed::<DoubleType>().write_batch(&std::mem::take(rows), None, None),
            Self::Text(rows) => out.typed::<ByteArrayType>().write_batch(&std::mem::take(rows), None, None),
        }?;
        Ok(())
    }
}

/// A table that grows by rows. Its columns are those of the first value: `revolution`, `stamp_ns`, the indices,
/// `value`.
pub(super) struct ParquetFile {
    /// Until the first value tells the columns.
    file: Option<File>,
    writer: Option<SerializedFileWriter<File>>,
    names: Vec<String>,
    columns: Vec<Rows>,
}

impl ParquetFile {
    pub(super) fn new(file: File) -> Self {
        Self { file: Some(file), writer: None, names: Vec::new(), columns: Vec::new() }
    }

    /// One row for each number or text of the value.
    pub(super) fn add(&mut self, revolution: i64, stamp_ns: i64, value: &Value) -> anyhow::Result<()> {
        self.take_columns(value)?;
        table::for_each(value, |indices, item| {
            let indices = indices.iter().map(|&index| index as i64);
            let integers = [revolution, stamp_ns].into_iter().chain(indices).map(Item::I64);
            integers.chain([item]).zip(&mut self.columns).try_for_each(|(item, column)| column.push(item))
        })?;
        if self.columns[0].len() >= GROUP_ROWS { self.write_group() } else { Ok(()) }
    }

    /// Writes what is left, and what is where.
    pub(super) fn finish(mut self) -> anyhow::Result<()> {
        self.write_group()?;
        if let Some(writer) = self.writer {
            writer.close()?;
        }
        Ok(())
    }

    /// The columns of the first value; later ones have to have the same.
    fn take_columns(&mut self, value: &Value) -> anyhow::Result<()> {
        let names = || ["revolution", "stamp_ns"].into_iter().chain(table::dims(value)).chain(["value"]);
        let Some(file) = self.file.take() else {
            return if names().eq(self.names.iter().map(String::as_str)) { Ok(()) } else { Err(columns_differ()) };
        };
        self.names = names().map(str::to_owned).collect();
        self.columns = self.names[1..].iter().map(|_| Rows::I64(Vec::new())).collect();
        self.columns.push(Rows::of(value)?);
        let fields = self.names.iter().zip(&self.columns).map(|(name, column)| Ok(Arc::new(column.schema(name)?)));
        let fields = fields.collect::<anyhow::Result<_>>()?;
        let schema = Type::group_type_builder("crosscut").with_fields(fields).build()?;
        let properties = WriterProperties::builder().set_dictionary_enabled(false).build();
        self.writer = Some(SerializedFileWriter::new(file, Arc::new(schema), Arc::new(properties))?);
        Ok(())
    }

    fn write_group(&mut self) -> anyhow::Result<()> {
        let Some(writer) = &mut self.writer else { return Ok(()) };
        let mut group = writer.next_row_group()?;
        for column in &mut self.columns {
            let mut out = group.next_column()?.context("as many columns as the schema has")?;
            column.write(&mut out)?;
            out.close()?;
        }
        group.close()?;
        Ok(())
    }
}

fn columns_differ() -> anyhow::Error {
    UsageError("its dimensions or type differ from those before: take .csv or .jsonl".to_owned()).into()
}
