//! Distances between rows, each computed once.

use crate::rows::{Rows, distance_squared};

/// Larger tables are not kept: rows are then compared again each time.
const MOST_BYTES: usize = 1 << 28;

/// Squared distances between the rows of U. Restarts of k-means++ draw the same rows over and over: with many zeros every row
/// is drawn several times, and a distance is a sum of k squares.
#[derive(Clone, Debug, Default)]
pub(crate) struct RowDistances {
    /// n×n, by the row that was asked for; empty if rows are asked for too rarely to keep them.
    table: Vec<f64>,
    is_known: Vec<bool>,
    /// Distances to the latest row, where there is no table.
    latest: Vec<f64>,
}

impl RowDistances {
    /// Starts anew for other rows, of which about this many will be asked for.
    pub(crate) fn begin(&mut self, rows: &Rows, requests: usize) {
        let n = rows.len();
        let is_kept = requests > n && n.saturating_mul(n) <= MOST_BYTES / size_of::<f64>();
        self.is_known.clear();
        self.is_known.resize(if is_kept { n } else { 0 }, false);
        self.table.resize(self.is_known.len() * self.is_known.len(), 0.0);
    }

    /// The squared distance of each row to row `i`.
    pub(crate) fn to(&mut self, rows: &Rows, i: usize) -> &[f64] {
        let (n, row) = (rows.len(), rows.row(i));
        if self.is_known.is_empty() {
            self.latest.clear();
            self.latest.extend(rows.iter().map(|other| distance_squared(other, row)));
            return &self.latest;
        }
        if !self.is_known[i] {
            for j in 0..n {
                // ‖a - b‖² and ‖b - a‖² are the same bits.
                let known = self.is_known[j].then(|| self.table[j * n + i]);
                self.table[i * n + j] = known.unwrap_or_else(|| distance_squared(rows.row(j), row));
            }
            self.is_known[i] = true;
        }
        &self.table[i * n..][..n]
    }
}
