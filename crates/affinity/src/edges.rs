//! Sparse graphs whose edges all weigh 1, written row by row.

use crosscut_stage::Affinity;

/// Writes the sparse graph of n returns in which W_ij = 1 for every j that `row(i, &mut columns)` puts into the empty
/// `columns`, ascending, i among them.
pub(crate) fn write_edges(out: &mut Affinity, n: usize, mut row: impl FnMut(usize, &mut Vec<u32>)) {
    let csr = out.weights.make_sparse();
    let mut columns = Vec::new();
    for i in 0..n {
        columns.clear();
        row(i, &mut columns);
        columns.iter().for_each(|&j| csr.push(j, 1.0));
        csr.end_row();
    }
}
