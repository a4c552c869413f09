//! Apache Parquet: the table that a CSV file is, with types. Plain columns without compression, in groups of rows.
//!
//! Written here, as the official crate asks for another feature of a crate that Rerun stands on, so that a dozen of Rerun's
//! crates would be built anew, for what a flat table does not need. The cross-checks read these files with pyarrow.

use std::fs::File;
use std::io::{BufWriter, Write};

use anyhow::{Context as _, bail};
use crosscut_recorder::{Numbers, Value};

use super::table::{self, Item};
use super::thrift::Struct;
use crate::exit::UsageError;

const MAGIC: &[u8] = b"PAR1";
/// A group of rows is written when its values take so much memory.
const GROUP_BYTES: usize = 64 << 20;
/// Numbers of the format's own enumerations.
const REQUIRED: i32 = 0;
const UTF8: i32 = 0;
const PLAIN: i32 = 0;
const RLE: i32 = 3;
const UNCOMPRESSED: i32 = 0;
const DATA_PAGE: i32 = 0;

/// What a column holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    I64,
    F32,
    F64,
    Text,
}

impl Kind {
    fn of(value: &Value) -> anyhow::Result<Self> {
        let of_numbers = |numbers: &Numbers| match numbers {
            Numbers::F64(_) => Self::F64,
            Numbers::F32(_) => Self::F32,
            Numbers::I64(_) => Self::I64,
        };
        Ok(match value {
            Value::Numbers(array) => of_numbers(&array.numbers),
            Value::Lists(lists) => lists.first().map_or(Self::F32, |list| of_numbers(&list.numbers)),
            Value::Texts(_) => Self::Text,
            other => bail!("{other} cannot be written as a table"),
        })
    }

    /// The format's number of the type.
    fn number(self) -> i32 {
        match self {
            Self::I64 => 2,
            Self::F32 => 4,
            Self::F64 => 5,
            Self::Text => 6,
        }
    }
}

struct Column {
    name: String,
    kind: Kind,
    /// The values of the group that is not yet written.
    bytes: Vec<u8>,
}

/// A table that grows by rows. Its columns are those of the first value: `revolution`, `stamp_ns`, the indices, `value`.
pub(super) struct ParquetFile {
    file: BufWriter<File>,
    written: i64,
    columns: Vec<Column>,
    /// Rows of the group that is not yet written, and of those that are.
    rows: i64,
    rows_written: i64,
    groups: Vec<Struct>,
}

impl ParquetFile {
    pub(super) fn new(file: File) -> anyhow::Result<Self> {
        let mut file = BufWriter::new(file);
        file.write_all(MAGIC)?;
        let written = MAGIC.len() as i64;
        Ok(Self { file, written, columns: Vec::new(), rows: 0, rows_written: 0, groups: Vec::new() })
    }

    /// One row for each number or text of the value.
    pub(super) fn add(&mut self, revolution: i64, stamp_ns: Option<i64>, value: &Value) -> anyhow::Result<()> {
        let stamp_ns = stamp_ns.context("it has no stamp: take .csv or .jsonl")?;
        self.take_columns(value)?;
        table::for_each(value, |indices, item| {
            let indices = indices.iter().map(|&index| index as i64);
            for (number, column) in [revolution, stamp_ns].into_iter().chain(indices).zip(&mut self.columns) {
                column.bytes.extend(number.to_le_bytes());
            }
            let values = &mut self.columns.last_mut().expect("there is a column of values").bytes;
            match item {
                Item::F64(x) => values.extend(x.to_le_bytes()),
                Item::F32(x) => values.extend(x.to_le_bytes()),
                Item::I64(i) => values.extend(i.to_le_bytes()),
                Item::Text(text) => {
                    values.extend(u32::try_from(text.len())?.to_le_bytes());
                    values.extend(text.as_bytes());
                }
            }
            self.rows += 1;
            Ok(())
        })?;
        if self.columns.iter().map(|column| column.bytes.len()).sum::<usize>() >= GROUP_BYTES {
            self.write_group()?;
        }
        Ok(())
    }

    /// Writes what is left, and what is where.
    pub(super) fn finish(mut self) -> anyhow::Result<()> {
        self.write_group()?;
        let root = Struct::default().text(4, "crosscut").i32(5, i32::try_from(self.columns.len())?);
        let schema = self.columns.iter().map(|column| {
            let schema = Struct::default().i32(1, column.kind.number()).i32(3, REQUIRED).text(4, &column.name);
            if column.kind == Kind::Text { schema.i32(6, UTF8) } else { schema }
        });
        let footer = Struct::default()
            .i32(1, 1)
            .groups(2, std::iter::once(root).chain(schema))
            .i64(3, self.rows_written)
            .groups(4, self.groups)
            .text(6, concat!("crosscut ", env!("CARGO_PKG_VERSION")))
            .end();
        self.file.write_all(&footer)?;
        self.file.write_all(&u32::try_from(footer.len())?.to_le_bytes())?;
        self.file.write_all(MAGIC)?;
        Ok(self.file.flush()?)
    }

    /// The columns of the first value; later ones have to have the same.
    fn take_columns(&mut self, value: &Value) -> anyhow::Result<()> {
        let integers = ["revolution", "stamp_ns"].into_iter().chain(table::dims(value)).map(|name| (name, Kind::I64));
        let columns: Vec<(&str, Kind)> = integers.chain([("value", Kind::of(value)?)]).collect();
        let column = |&(name, kind): &(&str, Kind)| Column { name: name.to_owned(), kind, bytes: Vec::new() };
        if self.columns.is_empty() {
            self.columns = columns.iter().map(column).collect();
        }
        if !self.columns.iter().map(|column| (column.name.as_str(), column.kind)).eq(columns) {
            bail!(UsageError("its dimensions or type differ from those before: take .csv or .jsonl".to_owned()));
        }
        Ok(())
    }

    /// One page a column.
    fn write_group(&mut self) -> anyhow::Result<()> {
        if self.rows == 0 {
            return Ok(());
        }
        let (start, mut chunks) = (self.written, Vec::new());
        for column in &mut self.columns {
            let bytes = i32::try_from(column.bytes.len())?;
            let of_data = Struct::default().i32(1, i32::try_from(self.rows)?).i32(2, PLAIN).i32(3, RLE).i32(4, RLE);
            let header = Struct::default().i32(1, DATA_PAGE).i32(2, bytes).i32(3, bytes).group(5, of_data).end();
            self.file.write_all(&header)?;
            self.file.write_all(&column.bytes)?;
            let (at, size) = (self.written, header.len() as i64 + i64::from(bytes));
            let about = Struct::default()
                .i32(1, column.kind.number())
                .i32s(2, &[PLAIN, RLE])
                .texts(3, &[&column.name])
                .i32(4, UNCOMPRESSED)
                .i64(5, self.rows)
                .i64(6, size)
                .i64(7, size)
                .i64(9, at);
            chunks.push(Struct::default().i64(2, at).group(3, about));
            self.written += size;
            column.bytes.clear();
        }
        let group = Struct::default().groups(1, chunks).i64(2, self.written - start).i64(3, self.rows);
        self.groups.push(group);
        self.rows_written += self.rows;
        self.rows = 0;
        Ok(())
    }
}
