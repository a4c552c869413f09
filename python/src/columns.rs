//! Columns of numbers, lists and texts, as arrays of numpy.

use numpy::{Element, PyArray1, PyReadonlyArray1};
use pyo3::exceptions::{PyKeyError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// A dictionary of columns.
pub(crate) struct Columns<'py>(pub(crate) Bound<'py, PyDict>);

impl Columns<'_> {
    pub(crate) fn numbers<T: Element>(&self, name: &str, values: impl Iterator<Item = T>) -> PyResult<()> {
        self.0.set_item(name, PyArray1::from_vec(self.0.py(), values.collect()))
    }

    /// Lists of entries of `width` values each.
    pub(crate) fn lists<T: Element, V: IntoIterator<Item = T>>(
        &self,
        name: &str,
        width: usize,
        rows: impl Iterator<Item = V>,
    ) -> PyResult<()> {
        let lists = Lists::of(width, rows)?;
        let py = self.0.py();
        self.0.set_item(name, (PyArray1::from_vec(py, lists.starts), PyArray1::from_vec(py, lists.values)))
    }

    pub(crate) fn texts<'t>(&self, name: &str, rows: impl Iterator<Item = &'t str>) -> PyResult<()> {
        self.lists(name, 1, rows.map(str::bytes))
    }

    pub(crate) fn lists_of_texts<'t, V: IntoIterator<Item = &'t str>>(
        &self,
        name: &str,
        rows: impl Iterator<Item = V>,
    ) -> PyResult<()> {
        let lists = Lists::of(1, rows)?;
        let texts = Lists::of(1, lists.values.into_iter().map(str::bytes))?;
        let py = self.0.py();
        let texts = (PyArray1::from_vec(py, texts.starts), PyArray1::from_vec(py, texts.values));
        self.0.set_item(name, (PyArray1::from_vec(py, lists.starts), texts))
    }

    #[cfg(feature = "rerun")]
    pub(crate) fn has(&self, name: &str) -> PyResult<bool> {
        self.0.contains(name)
    }

    fn column(&self, name: &str) -> PyResult<Bound<'_, PyAny>> {
        self.0.get_item(name)?.ok_or_else(|| PyKeyError::new_err(format!("frames have no column {name}")))
    }

    pub(crate) fn read_numbers<T: Element + Copy>(&self, name: &str, length: Option<usize>) -> PyResult<Vec<T>> {
        let values = vector(name, &self.column(name)?)?;
        if length.is_some_and(|length| length != values.len()) {
            return Err(PyValueError::new_err(format!("frames: column {name} has another length than the others")));
        }
        Ok(values)
    }

    pub(crate) fn read_lists<T: Element + Copy>(&self, name: &str, width: usize, rows: usize) -> PyResult<Lists<T>> {
        let (starts, values): (Bound<'_, PyAny>, Bound<'_, PyAny>) = self.column(name)?.extract()?;
        Lists { starts: vector(name, &starts)?, values: vector(name, &values)?, width }.checked(name, rows)
    }

    pub(crate) fn read_texts(&self, name: &str, rows: usize) -> PyResult<Vec<String>> {
        self.read_lists::<u8>(name, 1, rows)?.texts(name)
    }

    pub(crate) fn read_lists_of_texts(&self, name: &str, rows: usize) -> PyResult<Vec<Vec<String>>> {
        let (starts, texts): (Bound<'_, PyAny>, (Bound<'_, PyAny>, Bound<'_, PyAny>)) = self.column(name)?.extract()?;
        let texts: Lists<u8> = Lists { starts: vector(name, &texts.0)?, values: vector(name, &texts.1)?, width: 1 };
        let count = texts.starts.len().saturating_sub(1);
        let values = texts.checked(name, count)?.texts(name)?;
        let lists = Lists { starts: vector(name, &starts)?, values, width: 1 }.checked(name, rows)?;
        Ok((0..rows).map(|row| lists.row(row).to_vec()).collect())
    }
}

fn vector<T: Element + Copy>(name: &str, array: &Bound<'_, PyAny>) -> PyResult<Vec<T>> {
    let array: PyReadonlyArray1<'_, T> =
        array.extract().map_err(|_| PyValueError::new_err(format!("frames: column {name} is of another type")))?;
    Ok(array.as_array().iter().copied().collect())
}

/// A list for each row: where it starts among the entries of all rows, an entry being `width` values.
pub(crate) struct Lists<T> {
    starts: Vec<i32>,
    values: Vec<T>,
    width: usize,
}

impl<T> Lists<T> {
    fn of<V: IntoIterator<Item = T>>(width: usize, rows: impl Iterator<Item = V>) -> PyResult<Self> {
        let mut this = Self { starts: vec![0], values: Vec::new(), width };
        for row in rows {
            this.values.extend(row);
            let end = i32::try_from(this.values.len() / width);
            this.starts.push(end.map_err(|_| PyValueError::new_err("frames: more than 2^31 values in a column"))?);
        }
        Ok(this)
    }

    fn checked(self, name: &str, rows: usize) -> PyResult<Self> {
        let entries = self.values.len() / self.width;
        let in_range = self.starts.first().is_some_and(|first| *first >= 0)
            && self.starts.last().is_some_and(|last| *last as usize <= entries);
        if self.starts.len() == rows + 1 && self.starts.is_sorted() && in_range {
            return Ok(self);
        }
        Err(PyValueError::new_err(format!("frames: column {name} is no list for each of {rows} rows")))
    }

    pub(crate) fn row(&self, row: usize) -> &[T] {
        &self.values[self.width * self.starts[row] as usize..self.width * self.starts[row + 1] as usize]
    }
}

impl Lists<u8> {
    pub(crate) fn texts(&self, name: &str) -> PyResult<Vec<String>> {
        let text = |row: usize| String::from_utf8(self.row(row).to_vec()).map_err(|_| wrong(name, row, "is not UTF-8"));
        (0..self.starts.len() - 1).map(text).collect()
    }
}

/// The error that a column has a wrong value in a row.
pub(crate) fn wrong(column: &str, row: usize, what: &str) -> PyErr {
    PyValueError::new_err(format!("frames: column {column}, row {row}: it {what}"))
}
