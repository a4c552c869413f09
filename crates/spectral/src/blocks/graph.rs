//! The edges of a graph, row by row, however W is stored.

use crosscut_stage::{Affinity, Csr, StageError, Weights};

/// W and D of a sound affinity.
#[derive(Clone, Debug, Default)]
pub(crate) struct Graph {
    /// W, by rows.
    pub(crate) edges: Csr,
    pub(crate) degrees: Vec<f64>,
    /// The diagonal of D^-1/2.
    inverse_sqrt_degrees: Vec<f64>,
}

impl Graph {
    /// Takes an affinity whose degrees are sound.
    ///
    /// # Errors
    /// When a weight is not finite.
    pub(crate) fn fill(&mut self, affinity: &Affinity) -> Result<(), StageError> {
        let Self { edges, degrees, inverse_sqrt_degrees } = self;
        copy(&affinity.weights, edges);
        degrees.clone_from(&affinity.degrees);
        inverse_sqrt_degrees.clear();
        inverse_sqrt_degrees.extend(degrees.iter().map(|degree| degree.sqrt().recip()));
        let is_finite = |weights: &[f64]| weights.iter().fold(true, |finite, weight| finite & weight.is_finite());
        if is_finite(edges.values()) {
            return Ok(());
        }
        let index = (0..edges.n()).find(|&i| !is_finite(edges.row(i).1)).unwrap_or_default();
        Err(StageError::NotFinite { what: "the affinity", index })
    }

    /// The edges of return `i` to earlier ones, each with W_ij and W_ij / √(D_ii D_jj); an entry of W that is 0, or where
    /// that is 0, is none. A weight below the smallest normal number counts as 0.
    #[inline]
    pub(crate) fn edges_back(&self, i: usize) -> impl Iterator<Item = Edge> {
        let ((others, weights), scale) = (self.edges.row(i), self.inverse_sqrt_degrees[i]);
        let earlier = others.iter().zip(weights).take_while(move |&(&j, _)| (j as usize) < i);
        let edges = earlier.map(move |(&to, &weight)| {
            let scaled = weight * (scale * self.inverse_sqrt_degrees[to as usize]);
            Edge { from: i as u32, to, weight, scaled }
        });
        edges.filter(|edge| edge.scaled >= f64::MIN_POSITIVE)
    }

    /// L_ii, if edges of these weights in sum are set aside.
    #[inline]
    pub(crate) fn diagonal(&self, i: usize, leak: f64) -> f64 {
        let inverse_degree = self.inverse_sqrt_degrees[i] * self.inverse_sqrt_degrees[i];
        1.0 - leak * inverse_degree - inverse_degree
    }
}

/// An edge from a return to an earlier one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Edge {
    pub(crate) from: u32,
    pub(crate) to: u32,
    /// W_ij.
    pub(crate) weight: f64,
    /// W_ij / √(D_ii D_jj).
    pub(crate) scaled: f64,
}

/// W by its nonzero entries. W is symmetric: its columns, in which a dense one is stored, are its rows.
fn copy(weights: &Weights, out: &mut Csr) {
    if let Weights::Sparse(w) = weights {
        out.clone_from(w);
        return;
    }
    out.clear();
    weights.for_each(|i, j, weight| {
        while out.n() < j {
            out.end_row();
        }
        let is_nothing = weight.abs() < f64::MIN_POSITIVE;
        if !is_nothing {
            out.push(i as u32, weight);
        }
    });
    while out.n() < weights.n() {
        out.end_row();
    }
}
