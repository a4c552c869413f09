//! The edges of a graph, row by row, however W is stored.

use crosscut_stage::{Affinity, Csr, StageError, Weights};

/// W and D of sound affinities, and what is made of them.
#[derive(Clone, Copy)]
pub(crate) struct Graph<'a> {
    /// W, by rows.
    pub(crate) edges: &'a Csr,
    pub(crate) degrees: &'a [f64],
    /// The diagonal of D^-1/2.
    pub(crate) inverse_sqrt_degrees: &'a [f64],
    /// W_ij / √(D_ii D_jj) of the first entries of each row of `edges`, which are those of j <= i; row by row.
    scaled: &'a [f64],
    /// Where each row starts in `scaled`, and the end.
    starts: &'a [usize],
}

/// What a graph is made in; holds its buffers.
#[derive(Clone, Debug, Default)]
pub(crate) struct GraphBuffers {
    inverse_sqrt_degrees: Vec<f64>,
    /// Those of a dense W.
    edges: Csr,
    scaled: Vec<f64>,
    starts: Vec<usize>,
}

impl GraphBuffers {
    /// The graph of an affinity whose degrees are sound.
    ///
    /// # Errors
    /// When a weight is not finite.
    pub(crate) fn graph<'a>(&'a mut self, affinity: &'a Affinity) -> Result<Graph<'a>, StageError> {
        let Self { inverse_sqrt_degrees, edges: buffer, scaled, starts } = self;
        inverse_sqrt_degrees.clear();
        inverse_sqrt_degrees.extend(affinity.degrees.iter().map(|degree| degree.sqrt().recip()));
        let edges = edges(&affinity.weights, buffer)?;
        scaled.clear();
        starts.clear();
        starts.push(0);
        for (i, scale) in inverse_sqrt_degrees.iter().enumerate() {
            let (others, weights) = edges.row(i);
            let lower =
                others.iter().zip(weights).map(|(&j, weight)| (j as usize, weight)).take_while(|&(j, _)| j <= i);
            scaled.extend(lower.map(|(j, weight)| weight * (scale * inverse_sqrt_degrees[j])));
            starts.push(scaled.len());
        }
        Ok(Graph { edges, degrees: &affinity.degrees, inverse_sqrt_degrees, scaled, starts })
    }
}

impl Graph<'_> {
    /// The edges of return `i` to earlier ones, and to itself, with W_ij / √(D_ii D_jj).
    #[inline]
    pub(crate) fn scaled_edges(&self, i: usize) -> impl Iterator<Item = (usize, f64)> {
        let scaled = &self.scaled[self.starts[i]..self.starts[i + 1]];
        self.edges.row(i).0.iter().map(|&j| j as usize).zip(scaled.iter().copied())
    }
}

/// W by its nonzero entries: `weights` itself if it is sparse, else copied into `buffer`.
///
/// # Errors
/// When a weight is not finite.
fn edges<'a>(weights: &'a Weights, buffer: &'a mut Csr) -> Result<&'a Csr, StageError> {
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
