//! W and U, sparse or with all their entries.

use crosscut_stage::Csr;
use pyo3::prelude::*;

use crate::columns::{Columns, Lists, wrong};

/// A matrix row by row: all entries, or those that are stored, with their columns and the start of each row.
#[derive(Default)]
pub(super) struct RowMajor {
    starts: Vec<u64>,
    columns: Vec<u32>,
    values: Vec<f64>,
}

impl RowMajor {
    /// Of a sparse matrix, its `rows`; of one with all entries, the values that `for_each` gives in any order.
    pub(super) fn of(
        rows: Option<&Csr>,
        [nrows, ncols]: [usize; 2],
        for_each: impl FnOnce(&mut dyn FnMut(usize, usize, f64)),
    ) -> Self {
        let mut this = Self::default();
        if let Some(rows) = rows {
            this.starts.push(0);
            for i in 0..nrows {
                let (columns, values) = rows.row(i);
                this.columns.extend_from_slice(columns);
                this.values.extend_from_slice(values);
                this.starts.push(this.values.len() as u64);
            }
        } else {
            this.values.resize(nrows * ncols, 0.0);
            for_each(&mut |i, j, value| this.values[i * ncols + j] = value);
        }
        this
    }
}

/// Row starts are an empty list for a matrix with all its entries.
pub(super) fn write_matrices(name: &str, matrices: &[RowMajor], out: &Columns<'_>) -> PyResult<()> {
    out.lists(&format!("{name}_row_start"), 1, matrices.iter().map(|m| m.starts.iter().copied()))?;
    out.lists(&format!("{name}_column"), 1, matrices.iter().map(|m| m.columns.iter().copied()))?;
    out.lists(&format!("{name}_value"), 1, matrices.iter().map(|m| m.values.iter().copied()))
}

/// The matrices of all rows.
pub(super) struct Matrices<'a> {
    name: &'a str,
    starts: Lists<u64>,
    columns: Lists<u32>,
    values: Lists<f64>,
}

impl<'a> Matrices<'a> {
    pub(super) fn read(name: &'a str, columns: &Columns<'_>, rows: usize) -> PyResult<Self> {
        Ok(Self {
            name,
            starts: columns.read_lists(&format!("{name}_row_start"), 1, rows)?,
            columns: columns.read_lists(&format!("{name}_column"), 1, rows)?,
            values: columns.read_lists(&format!("{name}_value"), 1, rows)?,
        })
    }

    /// The values of the matrix in row `row`; of a sparse one also the starts of its rows and the columns.
    #[expect(clippy::type_complexity)] // taken apart where it is called
    pub(super) fn row(&self, row: usize, [nrows, ncols]: [usize; 2]) -> PyResult<(Option<(&[u64], &[u32])>, &[f64])> {
        let (starts, columns, values) = (self.starts.row(row), self.columns.row(row), self.values.row(row));
        let shape = format!("is no matrix of {nrows} rows and {ncols} columns");
        if starts.is_empty() {
            let fits = nrows.checked_mul(ncols) == Some(values.len());
            return if fits { Ok((None, values)) } else { Err(wrong(&format!("{}_value", self.name), row, &shape)) };
        }
        let ends_fit = starts.len() == nrows + 1 && starts[0] == 0 && starts[nrows] as usize == values.len();
        let rows_fit = ends_fit && starts.is_sorted() && columns.len() == values.len();
        let ascending = rows_fit && spans(starts).all(|span| columns[span].is_sorted_by(|a, b| a < b));
        if !ascending || columns.iter().any(|&column| column as usize >= ncols) {
            return Err(wrong(&format!("{}_row_start", self.name), row, &shape));
        }
        Ok((Some((starts, columns)), values))
    }
}

pub(super) fn spans(starts: &[u64]) -> impl Iterator<Item = std::ops::Range<usize>> {
    starts.windows(2).map(|pair| pair[0] as usize..pair[1] as usize)
}
