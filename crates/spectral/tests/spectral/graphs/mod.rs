//! Random graphs whose components are known by search, and an eigenvalue method simple enough to trust.

use std::ops::Range;

use crosscut_stage::Affinity;
use faer::Mat;
use proptest::collection::vec;
use proptest::prelude::{Strategy, any};

/// A symmetric weighted graph with ones on its diagonal.
#[derive(Clone, Debug)]
pub(crate) struct Graph {
    pub(crate) n: usize,
    weights: Mat<f64>,
}

/// A graph of up to `n` nodes in up to four pieces: each node with an edge to an earlier one of its piece, and some more edges.
/// Weights are at least 0.05, so that the smallest nonzero eigenvalue is far above rounding.
pub(crate) fn graph(n: Range<usize>) -> impl Strategy<Value = Graph> {
    vec((0..4usize, any::<[u16; 2]>(), [0.05..1.0f64, 0.05..1.0f64]), n).prop_map(|nodes| {
        let mut graph = Graph::complete(nodes.len(), 0.0);
        for (i, (piece, ties, weights)) in nodes.iter().enumerate() {
            let earlier: Vec<usize> = (0..i).filter(|&j| nodes[j].0 == *piece).collect();
            for (tie, weight) in ties.iter().zip(weights).filter(|_| !earlier.is_empty()) {
                let j = earlier[usize::from(*tie) % earlier.len()];
                (graph.weights[(i, j)], graph.weights[(j, i)]) = (*weight, *weight);
            }
        }
        graph
    })
}

impl Graph {
    /// An edge of the same weight between every two of `n` nodes; none if it is 0.
    pub(crate) fn complete(n: usize, weight: f64) -> Self {
        Self { n, weights: Mat::from_fn(n, n, |i, j| if i == j { 1.0 } else { weight }) }
    }

    /// This graph with an edge of at least `weight` between every two nodes.
    pub(crate) fn leaking(&self, weight: f64) -> Self {
        Self { n: self.n, weights: Mat::from_fn(self.n, self.n, |i, j| self.weights[(i, j)].max(weight)) }
    }

    fn degrees(&self) -> Vec<f64> {
        (0..self.n).map(|j| self.weights.col(j).iter().sum()).collect()
    }

    pub(crate) fn dense(&self) -> Affinity {
        let mut affinity = Affinity { degrees: self.degrees(), ..Affinity::default() };
        affinity.weights.make_dense(self.n).copy_from(&self.weights);
        affinity
    }

    pub(crate) fn sparse(&self) -> Affinity {
        let mut affinity = Affinity { degrees: self.degrees(), ..Affinity::default() };
        let csr = affinity.weights.make_sparse();
        for i in 0..self.n {
            for j in (0..self.n).filter(|&j| self.weights[(i, j)] != 0.0) {
                csr.push(j as u32, self.weights[(i, j)]);
            }
            csr.end_row();
        }
        affinity
    }

    /// The component of each node, by search along the edges; components numbered by their first node.
    fn component_of_node(&self) -> Vec<usize> {
        let mut component = vec![usize::MAX; self.n];
        let mut next = 0;
        for start in 0..self.n {
            if component[start] == usize::MAX {
                let mut open = vec![start];
                while let Some(i) = open.pop() {
                    if component[i] == usize::MAX {
                        component[i] = next;
                        open.extend((0..self.n).filter(|&j| self.weights[(i, j)] != 0.0));
                    }
                }
                next += 1;
            }
        }
        component
    }

    pub(crate) fn components(&self) -> usize {
        self.component_of_node().iter().max().map_or(0, |last| last + 1)
    }

    /// D^1/2 1_C / ‖D^1/2 1_C‖ of each component C, n×components: an exact basis of the null space of L.
    pub(crate) fn indicators(&self) -> Mat<f64> {
        let (component, degrees) = (self.component_of_node(), self.degrees());
        let mut volume = vec![0.0; self.components()];
        for (&c, degree) in component.iter().zip(&degrees) {
            volume[c] += degree;
        }
        let entry = |i: usize, c: usize| if component[i] == c { (degrees[i] / volume[c]).sqrt() } else { 0.0 };
        Mat::from_fn(self.n, volume.len(), entry)
    }
}

/// Eigenvalues of a symmetric matrix, ascending, by cyclic Jacobi rotations.
pub(crate) fn jacobi_eigenvalues(matrix: &Mat<f64>) -> Vec<f64> {
    let (mut a, n) = (matrix.clone(), matrix.nrows());
    for _sweep in 0..30 {
        for p in 0..n {
            for q in p + 1..n {
                if a[(p, q)] != 0.0 {
                    rotate_away(&mut a, p, q);
                }
            }
        }
    }
    let mut eigenvalues: Vec<f64> = a.diagonal().column_vector().iter().copied().collect();
    eigenvalues.sort_by(f64::total_cmp);
    eigenvalues
}

/// A ← JᵀAJ with the rotation J of the plane (p, q) that makes A_pq zero (Golub and Van Loan, section 8.5).
fn rotate_away(a: &mut Mat<f64>, p: usize, q: usize) {
    let theta = (a[(q, q)] - a[(p, p)]) / (2.0 * a[(p, q)]);
    let t = 1.0f64.copysign(theta) / (theta.abs() + theta.hypot(1.0));
    let c = t.hypot(1.0).recip();
    let s = t * c;
    for i in 0..a.nrows() {
        let (x, y) = (a[(i, p)], a[(i, q)]);
        (a[(i, p)], a[(i, q)]) = (c * x - s * y, s * x + c * y);
    }
    for i in 0..a.nrows() {
        let (x, y) = (a[(p, i)], a[(q, i)]);
        (a[(p, i)], a[(q, i)]) = (c * x - s * y, s * x + c * y);
    }
    // Rounding leaves something there; the rotation has made it zero.
    (a[(p, q)], a[(q, p)]) = (0.0, 0.0);
}
