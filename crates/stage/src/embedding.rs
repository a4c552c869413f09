//! Points of Rᵏ, one a row: U, and the centroids among its rows.

use std::ops::Index;

use faer::Mat;

use crate::Csr;

/// A matrix of more columns than this is stored by its nonzero entries.
const MOST_DENSE_COLUMNS: usize = 64;

/// Entries that are checked together.
const CHUNK: usize = 8;

/// A matrix of points: U (n×k) or centroids (clusters×k).
///
/// A graph with very many components, such as a cloud whose floor returns are each on their own, has a U that is nearly
/// all 0. So beyond 64 columns [`Embedding::write_rows`] stores the nonzero entries of each row alone.
///
/// ```
/// use crosscut_stage::Embedding;
///
/// let mut u = Embedding::default();
/// u.write_rows(100_000, 100_000, |i, row| row.push((i as u32, 1.0)));
/// assert_eq!((u[(7, 7)], u[(7, 8)]), (1.0, 0.0));
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Embedding {
    /// All entries.
    Dense(Mat<f64>),
    /// The entries that are not 0, row by row.
    Sparse {
        /// Number of columns.
        columns: usize,
        /// The rows; not square.
        rows: Csr,
    },
}

impl Default for Embedding {
    fn default() -> Self {
        Self::Dense(Mat::new())
    }
}

impl From<Mat<f64>> for Embedding {
    fn from(dense: Mat<f64>) -> Self {
        Self::Dense(dense)
    }
}

impl Index<(usize, usize)> for Embedding {
    type Output = f64;

    fn index(&self, (i, j): (usize, usize)) -> &f64 {
        match self {
            Self::Dense(matrix) => &matrix[(i, j)],
            Self::Sparse { columns, rows } => {
                assert!(j < *columns, "column {j} of {columns}");
                let (present, values) = rows.row(i);
                present.binary_search(&(j as u32)).map_or(&0.0, |at| &values[at])
            }
        }
    }
}

impl Embedding {
    /// Number of points.
    pub fn nrows(&self) -> usize {
        match self {
            Self::Dense(matrix) => matrix.nrows(),
            Self::Sparse { rows, .. } => rows.n(),
        }
    }

    /// Their dimension.
    pub fn ncols(&self) -> usize {
        match self {
            Self::Dense(matrix) => matrix.ncols(),
            Self::Sparse { columns, .. } => *columns,
        }
    }

    /// Whether all entries are finite.
    pub fn is_finite(&self) -> bool {
        let all_finite = |values: &[f64]| values.iter().fold(true, |finite, value| finite & value.is_finite());
        match self {
            Self::Dense(matrix) => (0..matrix.ncols()).all(|j| all_finite(matrix.col_as_slice(j))),
            Self::Sparse { rows, .. } => all_finite(rows.values()),
        }
    }

    /// Column and value of each entry of row `i` that is stored, columns ascending. All others are 0.
    pub fn row(&self, i: usize) -> impl Iterator<Item = (usize, f64)> {
        let stored = match self {
            Self::Dense(matrix) => matrix.ncols(),
            Self::Sparse { rows, .. } => rows.row(i).0.len(),
        };
        (0..stored).map(move |at| match self {
            Self::Dense(matrix) => (at, matrix[(i, at)]),
            Self::Sparse { rows, .. } => (rows.row(i).0[at] as usize, rows.row(i).1[at]),
        })
    }

    /// Calls `entry(i, j, value)` for every stored entry: column by column for `Dense`, row by row for `Sparse`.
    pub fn for_each(&self, mut entry: impl FnMut(usize, usize, f64)) {
        match self {
            Self::Dense(matrix) => {
                for j in 0..matrix.ncols() {
                    matrix.col_as_slice(j).iter().enumerate().for_each(|(i, &value)| entry(i, j, value));
                }
            }
            Self::Sparse { rows, .. } => {
                for i in 0..rows.n() {
                    let (columns, values) = rows.row(i);
                    columns.iter().zip(values).for_each(|(&j, &value)| entry(i, j as usize, value));
                }
            }
        }
    }

    /// Calls `entry(i, j, value)` for every entry that is not 0, NaN among them.
    pub fn for_each_nonzero(&self, mut entry: impl FnMut(usize, usize, f64)) {
        let Self::Dense(matrix) = self else {
            return self.for_each(|i, j, value| {
                if value != 0.0 {
                    entry(i, j, value);
                }
            });
        };
        for j in 0..matrix.ncols() {
            // As a rule a column belongs to one wall and is 0 for long stretches.
            for (start, values) in (0..).step_by(CHUNK).zip(matrix.col_as_slice(j).chunks(CHUNK)) {
                if values.iter().fold(false, |any, &value| any | (value != 0.0)) {
                    let others = (start..).zip(values).filter(|(_, value)| **value != 0.0);
                    others.for_each(|(i, &value)| entry(i, j, value));
                }
            }
        }
    }

    /// Makes `self` a dense matrix, whose content is unspecified.
    pub fn make_dense(&mut self, nrows: usize, ncols: usize) -> &mut Mat<f64> {
        if !matches!(self, Self::Dense(_)) {
            *self = Self::default();
        }
        let Self::Dense(matrix) = self else { unreachable!("made dense above") };
        matrix.resize_with(nrows, ncols, |_, _| 0.0);
        matrix
    }

    /// Makes `self` nrows×ncols with, in row i, the columns and values that `row(i, &mut entries)` puts into the empty
    /// `entries`, columns ascending; 0 elsewhere. Dense up to 64 columns, sparse beyond.
    pub fn write_rows(&mut self, nrows: usize, ncols: usize, mut row: impl FnMut(usize, &mut Vec<(u32, f64)>)) {
        let mut entries = Vec::new();
        if ncols <= MOST_DENSE_COLUMNS {
            let matrix = self.make_dense(nrows, ncols);
            matrix.fill(0.0);
            for i in 0..nrows {
                entries.clear();
                row(i, &mut entries);
                entries.iter().for_each(|&(j, value)| matrix[(i, j as usize)] = value);
            }
            return;
        }
        if !matches!(self, Self::Sparse { .. }) {
            *self = Self::Sparse { columns: 0, rows: Csr::default() };
        }
        let Self::Sparse { columns, rows } = self else { unreachable!("made sparse above") };
        *columns = ncols;
        rows.clear();
        for i in 0..nrows {
            entries.clear();
            row(i, &mut entries);
            entries.iter().for_each(|&(j, value)| rows.push(j, value));
            rows.end_row();
        }
    }

    /// All nrows×ncols entries.
    pub fn to_dense(&self) -> Mat<f64> {
        match self {
            Self::Dense(matrix) => matrix.clone(),
            Self::Sparse { .. } => Mat::from_fn(self.nrows(), self.ncols(), |i, j| self[(i, j)]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Row i has i + 1 in column 2i and i - 1 in column 2i + 1.
    fn written(u: &mut Embedding, rows: usize) {
        u.write_rows(rows, 2 * rows, |i, row| {
            row.extend([(2 * i as u32, i as f64 + 1.0), (2 * i as u32 + 1, i as f64 - 1.0)]);
        });
    }

    #[test]
    fn one_entry_that_is_not_finite_is_found_however_it_is_stored() {
        let mut u = Embedding::default();
        for rows in [3, 40] {
            u.write_rows(rows, 2 * rows, |i, row| row.push((i as u32, if i == 2 { f64::NAN } else { 1.0 })));
            assert!(!u.is_finite(), "{rows} rows");
        }
    }

    #[test]
    fn few_columns_are_dense_and_many_are_not_and_both_read_the_same_also_in_a_used_buffer() {
        let mut u = Embedding::default();
        for rows in [40, 32, 33, 0, 3] {
            written(&mut u, rows);
            assert_eq!(matches!(u, Embedding::Sparse { .. }), 2 * rows > MOST_DENSE_COLUMNS, "{rows} rows");
            assert_eq!((u.nrows(), u.ncols()), (rows, 2 * rows));
            let dense = u.to_dense();
            for i in 0..rows {
                let expected = |j: usize| if j / 2 == i { i as f64 + [1.0, -1.0][j % 2] } else { 0.0 };
                assert!((0..2 * rows).all(|j| u[(i, j)] == expected(j) && dense[(i, j)] == expected(j)), "row {i}");
                assert!(
                    u.row(i).filter(|(j, _)| j / 2 == i).eq([(2 * i, i as f64 + 1.0), (2 * i + 1, i as f64 - 1.0)])
                );
                assert!(u.row(i).all(|(j, value)| value == expected(j)));
            }
            let mut sum = 0.0;
            u.for_each(|i, j, value| {
                assert_eq!(value, u[(i, j)]);
                sum += value;
            });
            assert_eq!(sum, (0..rows).map(|i| 2.0 * i as f64).sum::<f64>(), "every entry once");
            let (mut all, mut nonzero) = (Vec::new(), Vec::new());
            u.for_each(|i, j, value| all.push((i, j, value)));
            u.for_each_nonzero(|i, j, value| nonzero.push((i, j, value)));
            all.retain(|&(_, _, value)| value != 0.0);
            assert_eq!(nonzero, all);
            assert!(u.is_finite());
        }
    }
}
