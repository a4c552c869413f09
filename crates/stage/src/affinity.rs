//! The weighted graph over the returns: W and the degrees D.

use std::fmt;

use faer::Mat;

use crate::Dual;

/// The similarity graph of one revolution: symmetric, non-negative, W_ii = 1.
#[derive(Clone, Debug, Default)]
pub struct Affinity {
    /// W, n×n.
    pub weights: Weights,
    /// D_ii = Σ_j W_ij, the diagonal of D; n entries, each at least 1.
    pub degrees: Vec<f64>,
    /// The decisions at gaps, of kinds that decide whether a wall ends there.
    pub verdicts: Vec<Verdict>,
    /// The widths of the vehicle, about the configured one, for which there are as many walls, metres; `None` unless they
    /// were asked for, and of kinds for which the vehicle has no width.
    pub holds_for_width_m: Option<[f64; 2]>,
    /// Of kinds whose rows are directions: these, and the ways on; `None` where rows are returns.
    pub dual: Option<Dual>,
}

impl Affinity {
    /// Sets D_ii = Σ_j W_ij. Each sum runs over the stored entries in the order of their columns, so that its bits do
    /// not depend on the machine.
    pub fn sum_degrees(&mut self) {
        let Self { weights, degrees, .. } = self;
        degrees.clear();
        match weights {
            // W is symmetric: the entries of a column are those of the row.
            Weights::Dense(w) => degrees.extend((0..w.ncols()).map(|j| w.col_as_slice(j).iter().sum::<f64>())),
            Weights::Sparse(w) => degrees.extend((0..w.n()).map(|i| w.row(i).1.iter().sum::<f64>())),
        }
    }
}

/// Whether a wall continues across a gap between two returns that follow each other around the sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Verdict {
    /// The two returns, anticlockwise.
    pub returns: [u32; 2],
    /// The wall ends there: the gap is an opening.
    pub is_opening: bool,
    /// The room at the gap, divided by the room that an opening needs. The nearer to 1, the more doubtful.
    pub room_ratio: f64,
    /// p, the odds that a vehicle can pass, as a probability; `None` where too little is seen to say.
    pub p: Option<f64>,
    /// The rule that decides, in a few words: the one by which there is the most room, or why there is none.
    pub reason: &'static str,
    /// What that rule measured; `None` where too little is seen to measure, and of kinds that do not report it.
    pub measured: Option<Measured>,
}

/// What a verdict rests on, in words: "{what} 0.35 m; {against} 0.60 m".
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// What was measured, as the words before the value.
    pub what: &'static str,
    /// The value.
    pub value: f64,
    /// What it is compared with, as the words before that value.
    pub against: &'static str,
    /// The value it is compared with.
    pub limit: f64,
    /// The unit of both values: "m", "°" or "%".
    pub unit: &'static str,
}

impl Measured {
    /// A length compared with another one, metres.
    #[must_use]
    pub fn metres(what: &'static str, value: f64, against: &'static str, limit: f64) -> Self {
        Self { what, value, against, limit, unit: "m" }
    }

    /// The value over what it is compared with.
    #[must_use]
    pub fn ratio(&self) -> f64 {
        self.value / self.limit
    }
}

impl fmt::Display for Measured {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { what, value, against, limit, unit } = self;
        let (digits, space) = if *unit == "m" { (2, " ") } else { (0, if *unit == "°" { "" } else { " " }) };
        write!(f, "{what} {value:.digits$}{space}{unit}; {against} {limit:.digits$}{space}{unit}")
    }
}

/// W, stored densely or by its nonzero entries.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum Weights {
    /// All n×n entries.
    Dense(Mat<f64>),
    /// The nonzero entries, diagonal included, row by row.
    Sparse(Csr),
}

impl Default for Weights {
    fn default() -> Self {
        Self::Dense(Mat::new())
    }
}

impl Weights {
    /// Number of rows, n.
    pub fn n(&self) -> usize {
        match self {
            Self::Dense(w) => w.nrows(),
            Self::Sparse(w) => w.n(),
        }
    }

    /// Number of stored entries.
    pub fn stored(&self) -> usize {
        match self {
            Self::Dense(w) => w.nrows() * w.ncols(),
            Self::Sparse(w) => w.values.len(),
        }
    }

    /// Calls `entry(i, j, W_ij)` for every stored entry, row by row for `Sparse`, column by column for `Dense`.
    pub fn for_each(&self, mut entry: impl FnMut(usize, usize, f64)) {
        match self {
            Self::Dense(w) => {
                for j in 0..w.ncols() {
                    for (i, &value) in w.col_as_slice(j).iter().enumerate() {
                        entry(i, j, value);
                    }
                }
            }
            Self::Sparse(w) => {
                for i in 0..w.n() {
                    let (columns, values) = w.row(i);
                    for (&j, &value) in columns.iter().zip(values) {
                        entry(i, j as usize, value);
                    }
                }
            }
        }
    }

    /// All n×n entries.
    pub fn to_dense(&self) -> Mat<f64> {
        let mut w = Mat::zeros(self.n(), self.n());
        self.for_each(|i, j, value| w[(i, j)] += value);
        w
    }

    /// Makes `self` a dense n×n matrix, whose content is unspecified.
    pub fn make_dense(&mut self, n: usize) -> &mut Mat<f64> {
        if !matches!(self, Self::Dense(_)) {
            *self = Self::Dense(Mat::new());
        }
        let Self::Dense(w) = self else { unreachable!("made dense above") };
        w.resize_with(n, n, |_, _| 0.0);
        w
    }

    /// Makes `self` a sparse matrix without rows; its buffers are kept.
    pub fn make_sparse(&mut self) -> &mut Csr {
        if !matches!(self, Self::Sparse(_)) {
            *self = Self::Sparse(Csr::default());
        }
        let Self::Sparse(w) = self else { unreachable!("made sparse above") };
        w.clear();
        w
    }
}

/// A sparse matrix in compressed rows, for W a square one; columns ascend within a row.
#[derive(Debug, PartialEq)]
pub struct Csr {
    row_start: Vec<usize>,
    columns: Vec<u32>,
    values: Vec<f64>,
}

impl Clone for Csr {
    fn clone(&self) -> Self {
        let Self { row_start, columns, values } = self;
        Self { row_start: row_start.clone(), columns: columns.clone(), values: values.clone() }
    }

    /// Keeps the buffers.
    fn clone_from(&mut self, other: &Self) {
        self.row_start.clone_from(&other.row_start);
        self.columns.clone_from(&other.columns);
        self.values.clone_from(&other.values);
    }
}

impl Default for Csr {
    fn default() -> Self {
        Self { row_start: vec![0], columns: Vec::new(), values: Vec::new() }
    }
}

impl Csr {
    /// Number of rows, n.
    pub fn n(&self) -> usize {
        self.row_start.len() - 1
    }

    /// Columns and values of row `i`.
    #[inline]
    pub fn row(&self, i: usize) -> (&[u32], &[f64]) {
        let span = self.row_start[i]..self.row_start[i + 1];
        (&self.columns[span.clone()], &self.values[span])
    }

    /// The stored entries, row by row.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Removes all rows, keeping the buffers.
    pub fn clear(&mut self) {
        self.row_start.truncate(1);
        self.columns.clear();
        self.values.clear();
    }

    /// Adds an entry to the row being built. Columns of a row must ascend.
    #[inline]
    pub fn push(&mut self, column: u32, value: f64) {
        debug_assert!(
            self.columns.len() == self.row_start[self.n()] || self.columns.last() < Some(&column),
            "columns of a row must ascend"
        );
        self.columns.push(column);
        self.values.push(value);
    }

    /// Adds a row: as many values as columns, which ascend.
    #[inline]
    pub fn push_row(&mut self, columns: &[u32], values: &[f64]) {
        debug_assert!(columns.is_sorted_by(|a, b| a < b), "columns of a row must ascend");
        debug_assert_eq!(columns.len(), values.len(), "a value for each column");
        self.columns.extend_from_slice(columns);
        self.values.extend_from_slice(values);
        self.end_row();
    }

    /// Ends the row being built.
    #[inline]
    pub fn end_row(&mut self) {
        self.row_start.push(self.values.len());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn degrees_are_row_sums_however_w_is_stored() {
        let mut affinity = Affinity { degrees: vec![7.0; 5], ..Affinity::default() };
        affinity.weights.make_dense(2).copy_from(faer::mat![[1.0, 0.25], [0.25, 1.0]]);
        affinity.sum_degrees();
        assert_eq!(affinity.degrees, [1.25, 1.25]);
        let w = affinity.weights.make_sparse();
        w.push_row(&[0], &[1.0]);
        w.push_row(&[1, 2], &[1.0, 0.5]);
        w.push_row(&[1, 2], &[0.5, 1.0]);
        affinity.sum_degrees();
        assert_eq!(affinity.degrees, [1.0, 1.5, 1.5]);
    }

    #[test]
    fn a_cleared_csr_is_as_good_as_new() {
        let mut csr = Csr::default();
        csr.push(0, 1.0);
        csr.push(2, 0.5);
        csr.end_row();
        csr.clear();
        csr.push(0, 2.0);
        csr.end_row();
        assert_eq!((csr.n(), csr.values().len(), csr.row(0)), (1, 1, (&[0u32][..], &[2.0][..])));
    }

    #[test]
    fn weights_switch_between_dense_and_sparse_and_grow_and_shrink() {
        let mut weights = Weights::default();
        assert_eq!(weights.n(), 0);
        weights.make_dense(3)[(2, 1)] = 4.0;
        assert_eq!(weights.n(), 3);
        weights.make_dense(1);
        assert_eq!(weights.n(), 1);
        weights.make_sparse().end_row();
        assert_eq!(weights.n(), 1);
        assert_eq!(weights.make_dense(2).nrows(), 2);
    }
}
