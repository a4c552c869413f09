//! The edges of a graph, row by row, however W is stored.

use crosscut_stage::{Csr, StageError, Weights};

/// W and D of sound affinities.
#[derive(Clone, Copy)]
pub(crate) struct Graph<'a> {
    /// W, by rows.
    pub(crate) edges: &'a Csr,
    pub(crate) degrees: &'a [f64],
    /// The diagonal of D^-1/2.
    pub(crate) inverse_sqrt_degrees: &'a [f64],
}

impl Graph<'_> {
    /// The edges of return `i` to itself and to later ones.
    pub(crate) fn edges_from(&self, i: usize) -> impl Iterator<Item = (usize, f64)> {
        let (others, weights) = self.edges.row(i);
        let first = others.len() - others.iter().rev().take_while(|&&j| j as usize >= i).count();
        others[first..].iter().map(|&j| j as usize).zip(weights[first..].iter().copied())
    }
}

/// W by its nonzero entries: `weights` itself if it is sparse, else copied into `buffer`.
///
/// # Errors
/// When a weight is not finite.
pub(crate) fn edges<'a>(weights: &'a Weights, buffer: &'a mut Csr) -> Result<&'a Csr, StageError> {
    let edges = match weights {
        Weights::Sparse(w) => w,
        other => {
            copy(other, buffer);
            buffer
        }
    };
    let finite = |weights: &[f64]| weights.iter().fold(true, |finite, weight| finite & weight.is_finite());
    if finite(edges.values()) {
        return Ok(edges);
    }
    let index = (0..edges.n()).find(|&i| !finite(edges.row(i).1)).unwrap_or_default();
    Err(StageError::NotFinite { what: "the affinity", index })
}

/// W is symmetric: its columns, in which a dense one is stored, are its rows.
fn copy(weights: &Weights, out: &mut Csr) {
    out.clear();
    weights.for_each(|i, j, weight| {
        while out.n() < j {
            out.end_row();
        }
        if weight != 0.0 {
            out.push(i as u32, weight);
        }
    });
    while out.n() < weights.n() {
        out.end_row();
    }
}
