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

/// Edges of weight 1 along walls: of each return to the next one of its wall, and to the one before.
#[derive(Debug, Default)]
pub(crate) struct Neighbours(Vec<[Option<u32>; 2]>);

impl Neighbours {
    /// n returns without edges.
    pub(crate) fn reset(&mut self, n: usize) {
        self.0.clear();
        self.0.resize(n, [None; 2]);
    }

    /// An edge from return `i` to `j`, the next of its wall.
    pub(crate) fn connect(&mut self, i: u32, j: u32) {
        (self.0[i as usize][0], self.0[j as usize][1]) = (Some(j), Some(i));
    }

    /// Writes the graph.
    pub(crate) fn write(&self, out: &mut Affinity) {
        write_edges(out, self.0.len(), |i, row| {
            row.extend([Some(i as u32), self.0[i][0], self.0[i][1]].into_iter().flatten());
            row.sort_unstable();
            row.dedup();
        });
    }
}
