//! Sparse graphs, written row by row.

use crosscut_stage::Affinity;

/// Writes the sparse graph of n returns in which W_ij = 1 for every j that `row(i, &mut columns)` puts into the empty
/// `columns`, ascending, i among them.
pub(crate) fn write_edges(out: &mut Affinity, n: usize, mut row: impl FnMut(usize, &mut Vec<u32>)) {
    let csr = out.weights.make_sparse();
    out.degrees.clear();
    let mut columns = Vec::new();
    for i in 0..n {
        columns.clear();
        row(i, &mut columns);
        columns.iter().for_each(|&j| csr.push(j, 1.0));
        csr.end_row();
        out.degrees.push(columns.len() as f64);
    }
}

/// Bytes of a graph of n returns with `edges_per_return` entries in each row, diagonal included.
pub(crate) fn edges_bytes(n: usize, edges_per_return: usize) -> u64 {
    // An entry is a column and a value; a row has its start and its degree.
    let row = (edges_per_return as u64).saturating_mul(4 + 8).saturating_add(8 + 8);
    row.saturating_mul(n as u64).saturating_add(8)
}
