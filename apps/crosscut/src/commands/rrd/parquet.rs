//! Apache Parquet: the table that a CSV file holds, with types. Plain columns without compression.

use std::fs::File;

use crosscut_rrd::arrow::array::RecordBatch;
use crosscut_rrd::arrow::datatypes::SchemaRef;
use parquet::arrow::ArrowWriter;
use parquet::file::properties::WriterProperties;

use crate::exit::UsageError;

/// A table that grows by rows. Its columns are those of the first value.
pub(in crate::commands) struct ParquetFile {
    file: File,
    /// Opened by the first value, which sets the columns.
    writer: Option<(SchemaRef, ArrowWriter<File>)>,
}

impl ParquetFile {
    pub(in crate::commands) fn new(file: File) -> Self {
        Self { file, writer: None }
    }

    /// The rows of one more value.
    pub(in crate::commands) fn add(&mut self, rows: &RecordBatch) -> anyhow::Result<()> {
        let (columns, writer) = match &mut self.writer {
            Some(opened) => opened,
            None => {
                let properties = WriterProperties::builder().set_dictionary_enabled(false).build();
                let writer = ArrowWriter::try_new(self.file.try_clone()?, rows.schema(), Some(properties))?;
                self.writer.insert((rows.schema(), writer))
            }
        };
        if *columns != rows.schema() {
            let text = "its dimensions or type differ from those before: take .csv or .jsonl";
            return Err(UsageError(text.to_owned()).into());
        }
        Ok(writer.write(rows)?)
    }

    /// Writes what is left, and the index of the file.
    pub(in crate::commands) fn finish(self) -> anyhow::Result<()> {
        if let Some((_, writer)) = self.writer {
            writer.close()?;
        }
        Ok(())
    }
}
