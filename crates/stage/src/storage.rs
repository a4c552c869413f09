//! How W is stored, and the memory that follows from it.

use crate::Params;

/// How an affinity stores W.
#[derive(Clone, Copy, Debug)]
pub enum Storage {
    /// All n×n entries.
    Dense,
    /// The nonzero entries. Of n returns, a row has on average at most this many, the one on the diagonal included.
    Sparse(fn(&Params, usize) -> usize),
}

impl Storage {
    /// Bytes that W and D of n returns take in a frame; `u64::MAX` where they cannot be counted.
    pub fn bytes(self, params: &Params, n: usize) -> u64 {
        let of_f64 = size_of::<f64>() as u64;
        match self {
            // Columns of a dense matrix start on multiples of 64 bytes.
            Self::Dense => {
                let (rows, n) = (n.next_multiple_of(8) as u64, n as u64);
                rows.saturating_mul(n).saturating_add(n).saturating_mul(of_f64)
            }
            Self::Sparse(entries_per_row) => {
                // An entry is a column and a value; a row has its start and its degree.
                let row = (entries_per_row(params, n) as u64).saturating_mul(4 + of_f64).saturating_add(8 + of_f64);
                row.saturating_mul(n as u64).saturating_add(8)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_size_that_cannot_be_counted_is_not_small() {
        let params = Params::defaults(&[]);
        for storage in [Storage::Dense, Storage::Sparse(|_, n| n), Storage::Sparse(|_, _| usize::MAX)] {
            assert_eq!(storage.bytes(&params, usize::MAX / 2), u64::MAX, "{storage:?}");
        }
        assert_eq!(Storage::Dense.bytes(&params, 3), 8 * 3 * 8 + 3 * 8, "W and D");
        assert_eq!(Storage::Sparse(|_, _| 2).bytes(&params, 3), 6 * 12 + 4 * 8 + 3 * 8, "W and D");
    }
}
