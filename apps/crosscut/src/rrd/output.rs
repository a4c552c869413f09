//! Values as files: NumPy arrays, CSV, JSON lines.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

use anyhow::{Context, bail};
use crosscut_recorder::{Array, Numbers, Value};

use super::npy::NpyFile;
use crate::exit::UsageError;

/// The file that values go to, by its ending.
pub(super) enum Output {
    /// One array; of several revolutions along its first dimension.
    Npy(NpyFile),
    /// One number or text a line, with revolution, stamp and indices before it.
    Csv { file: Box<csv::Writer<File>>, columns: usize },
    /// One object a revolution.
    JsonLines(BufWriter<File>),
}

impl Output {
    /// Creates the file. An array of `one` revolution has no dimension for revolutions.
    pub(super) fn create(path: &Path, one: bool) -> anyhow::Result<Self> {
        let create = || File::create(path).with_context(|| format!("cannot write {}", path.display()));
        Ok(match path.extension().and_then(|ending| ending.to_str()) {
            Some("npy") => Self::Npy(NpyFile::new(create()?, one)?),
            Some("csv") => Self::Csv { file: Box::new(csv::Writer::from_writer(create()?)), columns: 0 },
            Some("jsonl") => Self::JsonLines(BufWriter::new(create()?)),
            _ => {
                let text = format!("{}: --out takes a file that ends in .npy, .csv or .jsonl", path.display());
                return Err(UsageError(text).into());
            }
        })
    }

    /// Adds the value of a revolution.
    pub(super) fn add(&mut self, revolution: i64, stamp_ns: Option<i64>, value: &Value) -> anyhow::Result<()> {
        self.write(revolution, stamp_ns, value).with_context(|| format!("revolution {revolution}"))
    }

    fn write(&mut self, revolution: i64, stamp_ns: Option<i64>, value: &Value) -> anyhow::Result<()> {
        match self {
            Self::Npy(file) => match value {
                Value::Numbers(array) => file.add(array),
                other => bail!(UsageError(format!("{other} is no array of numbers: take .csv or .jsonl"))),
            },
            Self::Csv { file, columns } => add_lines(file, columns, revolution, stamp_ns, value),
            Self::JsonLines(file) => {
                let line = serde_json::json!({"revolution": revolution, "stamp_ns": stamp_ns, "value": json(value)});
                Ok(writeln!(file, "{line}")?)
            }
        }
    }

    /// Brings everything to the disk.
    pub(super) fn finish(self) -> anyhow::Result<()> {
        match self {
            Self::Npy(file) => file.finish(),
            Self::Csv { mut file, .. } => Ok(file.flush()?),
            Self::JsonLines(mut file) => Ok(file.flush()?),
        }
    }
}

/// One line for each number or text. `columns` is how many the header has; 0 before it is written.
fn add_lines(
    file: &mut csv::Writer<File>,
    columns: &mut usize,
    revolution: i64,
    stamp_ns: Option<i64>,
    value: &Value,
) -> anyhow::Result<()> {
    let dims: Vec<&str> = match value {
        Value::Numbers(array) => array.dims.iter().map(String::as_str).collect(),
        Value::Lists(_) => vec!["list", "item", "axis"],
        _ => vec!["item"],
    };
    if *columns == 0 {
        file.write_record(["revolution", "stamp_ns"].into_iter().chain(dims.iter().copied()).chain(["value"]))?;
        *columns = dims.len() + 3;
    }
    let [revolution, stamp_ns] = [revolution.to_string(), stamp_ns.map_or_else(String::new, |ns| ns.to_string())];
    let mut line = |indices: &[usize], text: &str| -> anyhow::Result<()> {
        let indices: Vec<String> = indices.iter().map(ToString::to_string).collect();
        let start = [revolution.as_str(), &stamp_ns].into_iter();
        Ok(file.write_record(start.chain(indices.iter().map(String::as_str)).chain([text]))?)
    };
    match value {
        Value::Numbers(array) => (0..array.numbers.len())
            .try_for_each(|at| line(&indices(&array.shape, at), &number_text(&array.numbers, at))),
        Value::Lists(lists) => lists.iter().enumerate().try_for_each(|(list, array)| {
            (0..array.numbers.len()).try_for_each(|at| {
                let indices: Vec<usize> = [list].into_iter().chain(indices(&array.shape, at)).collect();
                line(&indices, &number_text(&array.numbers, at))
            })
        }),
        Value::Texts(texts) => texts.iter().enumerate().try_for_each(|(item, text)| line(&[item], text)),
        other => bail!("{other} cannot be written as CSV"),
    }
}

/// Where number `at` of an array stands: one index a dimension.
fn indices(shape: &[usize], mut at: usize) -> Vec<usize> {
    let mut indices: Vec<usize> = shape.iter().rev().map(|&size| (at % size, at /= size).0).collect();
    indices.reverse();
    indices
}

/// The shortest text that reads back as the same number.
fn number_text(numbers: &Numbers, at: usize) -> String {
    match numbers {
        Numbers::F64(values) => format!("{:?}", values[at]),
        Numbers::F32(values) => format!("{:?}", values[at]),
        Numbers::I64(values) => values[at].to_string(),
    }
}

/// Nested lists; JSON has no infinity and no NaN, they become null.
fn json(value: &Value) -> serde_json::Value {
    match value {
        Value::Numbers(array) => json_array(array),
        Value::Lists(lists) => lists.iter().map(json_array).collect(),
        Value::Texts(texts) => texts.clone().into(),
        other => other.to_string().into(),
    }
}

fn json_array(array: &Array) -> serde_json::Value {
    let mut values: Vec<serde_json::Value> = match &array.numbers {
        Numbers::F64(values) => values.iter().map(|&x| x.into()).collect(),
        Numbers::F32(values) => values.iter().map(|&x| x.into()).collect(),
        Numbers::I64(values) => values.iter().map(|&i| i.into()).collect(),
    };
    let Some((_, inner)) = array.shape.split_first() else {
        return values.pop().unwrap_or_default();
    };
    for &size in inner.iter().rev() {
        values = values.chunks(size.max(1)).map(|row| row.to_vec().into()).collect();
    }
    values.into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn indices_run_fastest_along_the_last_dimension() {
        let all: Vec<Vec<usize>> = (0..6).map(|at| indices(&[2, 3], at)).collect();
        assert_eq!(all, [[0, 0], [0, 1], [0, 2], [1, 0], [1, 1], [1, 2]]);
        assert_eq!(indices(&[], 0), [0; 0]);
    }

    #[test]
    fn nested_lists_have_the_shape_of_the_array() {
        let array = |shape: &[usize], numbers| Array { shape: shape.to_vec(), dims: vec![], numbers };
        let json = |shape, numbers| json_array(&array(shape, numbers)).to_string();
        assert_eq!(json(&[2, 3], Numbers::I64((0..6).collect())), "[[0,1,2],[3,4,5]]");
        assert_eq!(json(&[0, 3], Numbers::I64(vec![])), "[]");
        assert_eq!(json(&[], Numbers::F32(vec![0.5])), "0.5");
        assert_eq!(json(&[2], Numbers::F64(vec![f64::INFINITY, 1e-16])), "[null,1e-16]");
    }
}
