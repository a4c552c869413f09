//! Sparse matrices of scipy, read by their arrays.
//!
//! scipy's own conversions trust these arrays and read or write beyond them where they are wrong, which ends the process. They
//! are therefore checked and converted here; of scipy, nothing is called but what numpy checks.

use numpy::{PyArrayDescrMethods, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::arrays::{Matrix, array, kind, not_a_matrix, vector};

/// The stored entries of a matrix in any order: row, column and value of each.
#[derive(Default)]
struct Entries {
    rows: Vec<i64>,
    columns: Vec<i64>,
    values: Vec<f64>,
}

/// Reads a matrix of any format of scipy. Of one whose shape does not fit, the shape alone is read.
pub(crate) fn read(matrix: &Bound<'_, PyAny>, fits: impl Fn([usize; 2]) -> bool) -> PyResult<Matrix> {
    let shape: [usize; 2] = matrix.getattr("shape")?.extract().map_err(|_| not_a_matrix(matrix))?;
    if !fits(shape) {
        return Ok(Matrix::without_entries(shape));
    }
    let [nrows, ncols] = shape;
    if nrows.max(ncols) > u32::MAX as usize {
        return Err(PyValueError::new_err(format!("{} is too large", kind(matrix))));
    }
    let format: String = matrix.getattr("format").and_then(|format| format.extract()).unwrap_or_default();
    let entries = match format.as_str() {
        "csr" => of_compressed(matrix, shape)?,
        "csc" => {
            let Entries { rows, columns, values } = of_compressed(matrix, [ncols, nrows])?;
            Entries { rows: columns, columns: rows, values }
        }
        "coo" => of_coordinates(matrix, shape)?,
        "lil" => of_lists(matrix)?,
        "bsr" => {
            check_blocks(matrix, shape)?;
            of_coordinates(&matrix.call_method0("tocoo")?, shape)?
        }
        _ => of_coordinates(&matrix.call_method0("tocoo")?, shape)?, // numpy checks what these formats hold
    };
    row_by_row(matrix, shape, entries)
}

/// Of CSR with `lines` rows of `length` columns; of CSC likewise, with rows and columns exchanged.
fn of_compressed(matrix: &Bound<'_, PyAny>, [lines, length]: [usize; 2]) -> PyResult<Entries> {
    let starts = whole_numbers(matrix, "indptr", lines.saturating_add(1))?;
    let most = lines.saturating_mul(length);
    let columns = whole_numbers(matrix, "indices", most)?;
    let values: Vec<f64> = vector(&matrix.getattr("data")?, most)?;
    let stored = checked_starts(matrix, &starts, lines, columns.len())?;
    if values.len() != columns.len() {
        return Err(wrong(matrix, "indices and data are not of one length"));
    }
    let mut rows = Vec::with_capacity(stored);
    for (line, span) in (0..).zip(starts.windows(2)) {
        rows.resize(span[1] as usize, line);
    }
    Ok(Entries { rows, columns: columns[..stored].to_vec(), values: values[..stored].to_vec() })
}

fn of_coordinates(matrix: &Bound<'_, PyAny>, [nrows, ncols]: [usize; 2]) -> PyResult<Entries> {
    let most = nrows.saturating_mul(ncols);
    Ok(Entries {
        rows: whole_numbers(matrix, "row", most)?,
        columns: whole_numbers(matrix, "col", most)?,
        values: vector(&matrix.getattr("data")?, most)?,
    })
}

/// Of a list of columns and a list of values for each row.
fn of_lists(matrix: &Bound<'_, PyAny>) -> PyResult<Entries> {
    let lists = |name: &str| matrix.getattr(name)?.call_method0("tolist");
    let columns: Vec<Vec<i64>> = lists("rows")?.extract()?;
    let values: Vec<Vec<f64>> = lists("data")?.extract()?;
    if !columns.iter().map(Vec::len).eq(values.iter().map(Vec::len)) {
        return Err(wrong(matrix, "rows and data are not of one length"));
    }
    let rows = (0..).zip(&columns).flat_map(|(row, of_row)| of_row.iter().map(move |_| row)).collect();
    Ok(Entries { rows, columns: columns.concat(), values: values.concat() })
}

/// What BSR trusts when it makes coordinates of its blocks.
fn check_blocks(matrix: &Bound<'_, PyAny>, [nrows, ncols]: [usize; 2]) -> PyResult<()> {
    let [height, width]: [usize; 2] = matrix.getattr("blocksize")?.extract()?;
    let lines = nrows.checked_div(height).unwrap_or(0);
    let blocks = lines.saturating_mul(ncols.checked_div(width).unwrap_or(0));
    let starts = whole_numbers(matrix, "indptr", lines + 1)?;
    let columns = whole_numbers(matrix, "indices", blocks)?;
    let stored = checked_starts(matrix, &starts, lines, columns.len())?;
    if stored != columns.len() || array(&matrix.getattr("data")?)?.shape() != [stored, height, width] {
        return Err(wrong(matrix, "indptr, indices and data are not of one length"));
    }
    Ok(())
}

/// The number of entries by the starts of `lines` lines.
fn checked_starts(matrix: &Bound<'_, PyAny>, starts: &[i64], lines: usize, entries: usize) -> PyResult<usize> {
    let last = starts.last().and_then(|&last| usize::try_from(last).ok()).filter(|&last| last <= entries);
    let is_right = starts.len() == lines + 1 && starts[0] == 0 && starts.is_sorted();
    last.filter(|_| is_right).ok_or_else(|| wrong(matrix, "indptr does not ascend from 0 to the number of its indices"))
}

/// An attribute with at most this many whole numbers.
fn whole_numbers(matrix: &Bound<'_, PyAny>, name: &str, most: usize) -> PyResult<Vec<i64>> {
    let numbers = matrix.getattr(name)?;
    if !matches!(array(&numbers)?.dtype().kind(), b'i' | b'u') {
        return Err(wrong(matrix, &format!("{name} has other than whole numbers")));
    }
    vector(&numbers, most)
}

/// Sorted by row and column; entries of one place are added up.
fn row_by_row(matrix: &Bound<'_, PyAny>, shape: [usize; 2], entries: Entries) -> PyResult<Matrix> {
    let [nrows, ncols] = shape;
    let Entries { rows, columns, values } = entries;
    if rows.len() != columns.len() || rows.len() != values.len() {
        return Err(wrong(matrix, "row, col and data are not of one length"));
    }
    let is_within = |number: i64, length: usize| usize::try_from(number).is_ok_and(|number| number < length);
    if !rows.iter().all(|&row| is_within(row, nrows)) || !columns.iter().all(|&column| is_within(column, ncols)) {
        return Err(wrong(matrix, "an entry is outside its shape"));
    }
    let mut order: Vec<usize> = (0..rows.len()).collect();
    order.sort_by_key(|&at| (rows[at], columns[at]));
    let (mut starts, mut of_column, mut of_value) = (vec![0; nrows + 1], Vec::<u32>::new(), Vec::<f64>::new());
    let mut before = None;
    for at in order {
        let place = (rows[at], columns[at]);
        if before == Some(place) {
            *of_value.last_mut().expect("the entry before") += values[at];
            continue;
        }
        before = Some(place);
        of_column.push(columns[at] as u32);
        of_value.push(values[at]);
        starts[rows[at] as usize + 1] = of_value.len();
    }
    for row in 0..nrows {
        starts[row + 1] = starts[row + 1].max(starts[row]); // a row without entries ends where it starts
    }
    Ok(Matrix::Sparse { shape, starts, columns: of_column, values: of_value })
}

fn wrong(matrix: &Bound<'_, PyAny>, what: &str) -> PyErr {
    PyValueError::new_err(format!("{} is damaged: {what}", kind(matrix)))
}
