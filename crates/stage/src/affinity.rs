//! The weighted graph over the returns: W and the degrees D.

use faer::Mat;

/// The similarity graph of one revolution: symmetric, non-negative, W_ii = 1.
#[derive(Clone, Debug, Default)]
pub struct Affinity {
    /// W, n×n.
    pub weights: Weights,
    /// D_ii = Σ_j W_ij, the diagonal of D; n entries, each at least 1.
    pub degrees: Vec<f64>,
    /// What was decided at gaps, by kinds that decide whether a wall ends there; no stage reads it.
    pub verdicts: Vec<Verdict>,
}

/// Whether a wall goes on across a gap between two returns that follow each other around the sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Verdict {
    /// The two returns, anticlockwise.
    pub returns: [u32; 2],
    /// The wall ends there: it is a way on.
    pub is_way: bool,
    /// The room that there is, divided by the room that a way on needs: the nearer to 1, the more doubtful.
    pub room_ratio: f64,
    /// What decides there, in a few words: the rule by which there is the most room, or why there is none.
    pub reason: &'static str,
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

    /// How many entries are stored.
    pub fn stored(&self) -> usize {
        match self {
            Self::Dense(w) => w.nrows() * w.ncols(),
            Self::Sparse(w) => w.nonzeros(),
        }
    }

    /// Bytes that the stored entries take.
    pub fn memory_bytes(&self) -> u64 {
        let entry_bytes = match self {
            Self::Dense(_) => size_of::<f64>(),
            Self::Sparse(_) => size_of::<f64>() + size_of::<u32>(),
        };
        (self.stored() * entry_bytes) as u64
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

    /// The dense n×n matrix in `self`, made so (and resized, its old content unspecified) if it is not.
    pub fn make_dense(&mut self, n: usize) -> &mut Mat<f64> {
        if !matches!(self, Self::Dense(_)) {
            *self = Self::Dense(Mat::new());
        }
        let Self::Dense(w) = self else { unreachable!("made dense above") };
        w.resize_with(n, n, |_, _| 0.0);
        w
    }

    /// The sparse matrix in `self`, made so and emptied (its buffers kept).
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
#[derive(Clone, Debug, PartialEq)]
pub struct Csr {
    row_start: Vec<usize>,
    columns: Vec<u32>,
    values: Vec<f64>,
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

    /// Number of stored entries.
    pub fn nonzeros(&self) -> usize {
        self.values.len()
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
    fn a_cleared_csr_is_as_good_as_new() {
        let mut csr = Csr::default();
        csr.push(0, 1.0);
        csr.push(2, 0.5);
        csr.end_row();
        csr.clear();
        csr.push(0, 2.0);
        csr.end_row();
        assert_eq!((csr.n(), csr.nonzeros(), csr.row(0)), (1, 1, (&[0u32][..], &[2.0][..])));
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
