//! 0/1 graphs, written row by row.

use crosscut_stage::Affinity;

/// Writes the sparse graph of n returns in which W_ij = 1 if j is in `row(i)`, which ascends and holds i.
pub(crate) fn write_edges<Row>(out: &mut Affinity, n: usize, row: impl Fn(usize) -> Row)
where
    Row: Iterator<Item = u32>,
{
    let csr = out.weights.make_sparse();
    out.degrees.clear();
    for i in 0..n {
        let mut degree = 0.0;
        for j in row(i) {
            csr.push(j, 1.0);
            degree += 1.0;
        }
        csr.end_row();
        out.degrees.push(degree);
    }
}

/// Bytes of a graph of n returns with `edges_per_return` entries in each row, diagonal included.
pub(crate) fn edges_bytes(n: usize, edges_per_return: usize) -> u64 {
    // An entry is a column and a value; a row has its start and its degree.
    let row = (edges_per_return as u64).saturating_mul(4 + 8).saturating_add(8 + 8);
    row.saturating_mul(n as u64).saturating_add(8)
}
