//! The graph split into blocks along its weak edges, and the eigenvalues near zero that these edges make.

use crosscut_stage::{DisjointSets, StageError};
use faer::Mat;

use super::graph::{Edge, Graph};
use crate::decomposition::Decomposition;
use crate::degrees::sum_volumes;

/// A full decomposition of more rows, which would take 0.7 GB, is refused.
pub(super) const MOST_DECOMPOSED: usize = 4096;

/// The returns in m blocks, each connected by edges that are not weak, and the weak edges between them.
///
/// With Z (n×m) the columns D^1/2 1_B / ‖D^1/2 1_B‖ of the blocks B, and E = D^-1/2 (D_w - W_w) D^-1/2 the part of L
/// that the weak edges make (W_w their weights, D_w the degrees of W_w), L = L_0 + E. L_0 is block diagonal with
/// L_0 Z = 0, and E is positive semidefinite. The Laplacian of the graph of blocks,
///
/// Q = ZᵀLZ = ZᵀEZ: Q_AA = w(A, rest) / vol A, Q_AB = -w(A, B) / √(vol A · vol B),
///
/// has the eigenvalues θ_1 <= … <= θ_m. With μ the smallest eigenvalue of L_0 that is not one of its m zeros,
///
/// λ_m <= θ_m (Courant, Fischer) and μ <= λ_m+1 (Weyl, E >= 0).
///
/// So L has exactly m eigenvalues below τ if θ_m < τ <= μ. Blocks are therefore joined until θ_m < τ; μ is not
/// known here. With r = ‖EZ‖, θ_j - r² / (μ - θ_j) <= λ_j <= θ_j, and the sine of the largest angle between the columns
/// of Z and the eigenvectors is at most r / (μ - θ_m) (Davis, Kahan).
#[derive(Default)]
pub(crate) struct Split {
    sets: DisjointSets,
    /// Edges between blocks, which are set aside.
    pub(super) between: Vec<Edge>,
    /// Edges within blocks.
    pub(super) within: Vec<Edge>,
    /// The block of each return; blocks are numbered by their first return.
    pub(super) block_of_return: Vec<u32>,
    /// Σ D_ii over each of the m blocks.
    pub(super) volumes: Vec<f64>,
    /// Σ of the weights of the weak edges of each return.
    pub(super) leaks: Vec<f64>,
    /// The place in Q of each block that has weak edges.
    place: Vec<Option<usize>>,
    /// Of θ_1, …, θ_m, those that are not 0 because a block has no weak edges; ascending.
    pub(super) eigenvalues: Vec<f64>,
    decomposition: Decomposition,
}

impl Split {
    /// Splits the graph along its edges of W_ij / √(D_ii D_jj) < `weak`, and joins blocks again until
    /// θ_m < `tolerance`.
    ///
    /// # Errors
    /// When Q cannot be decomposed, or would take too much memory.
    pub(crate) fn form(&mut self, graph: &Graph, weak: f64, tolerance: f64) -> Result<(), StageError> {
        self.cut(graph, weak);
        loop {
            self.number_blocks(&graph.degrees);
            if self.between.is_empty() {
                self.eigenvalues.clear();
                return Ok(());
            }
            let q = self.quotient()?;
            // λ_max(Q) >= Q_AA: as long as there is such a block, it cannot stay alone.
            let mut leaking: Vec<usize> = (0..q.nrows()).filter(|&a| q[(a, a)] >= tolerance).collect();
            if leaking.is_empty() {
                self.decomposition.values(q.as_ref(), &mut self.eigenvalues)?;
                if self.eigenvalues.last().is_none_or(|&largest| largest < tolerance) {
                    return Ok(());
                }
                leaking.extend((0..q.nrows()).max_by(|&a, &b| q[(a, a)].total_cmp(&q[(b, b)])));
            }
            self.join(&q, &leaking);
        }
    }

    /// Joins the returns of edges that are not weak, and keeps the others.
    fn cut(&mut self, graph: &Graph, weak: f64) {
        let n = graph.degrees.len();
        self.sets.reset(n);
        self.between.clear();
        self.within.clear();
        for i in 0..n {
            for edge in graph.edges_back(i) {
                if edge.scaled >= weak {
                    self.sets.join(i, edge.to as usize);
                    self.within.push(edge);
                } else {
                    self.between.push(edge);
                }
            }
        }
    }

    /// Numbers the current blocks, and moves the weak edges within a block to the others.
    fn number_blocks(&mut self, degrees: &[f64]) {
        self.block_of_return.clear();
        self.block_of_return.extend_from_slice(self.sets.number_components());
        sum_volumes(&self.block_of_return, degrees, &mut self.volumes);
        let block = &self.block_of_return;
        let is_within = |edge: &mut Edge| block[edge.from as usize] == block[edge.to as usize];
        self.within.extend(self.between.extract_if(.., is_within));
        self.leaks.clear();
        self.leaks.resize(block.len(), 0.0);
        for edge in &self.between {
            self.leaks[edge.from as usize] += edge.weight;
            self.leaks[edge.to as usize] += edge.weight;
        }
    }

    /// Q of the blocks that have weak edges.
    fn quotient(&mut self) -> Result<Mat<f64>, StageError> {
        self.place.clear();
        self.place.resize(self.volumes.len(), None);
        let mut linked = 0;
        for (&block, &leak) in self.block_of_return.iter().zip(&self.leaks) {
            let place = &mut self.place[block as usize];
            if leak > 0.0 && place.is_none() {
                *place = Some(linked);
                linked += 1;
            }
        }
        if linked > MOST_DECOMPOSED {
            return Err(StageError::TooLarge(format!(
                "a graph of {linked} blocks with weak edges between them, more than {MOST_DECOMPOSED}, is not decomposed: \
                 choose an affinity without weak edges"
            )));
        }
        let mut q = Mat::zeros(linked, linked);
        for edge in &self.between {
            let [(a, volume_a), (b, volume_b)] = [edge.from, edge.to].map(|i| self.place_and_volume(i));
            q[(a, a)] += edge.weight / volume_a;
            q[(b, b)] += edge.weight / volume_b;
            let between = edge.weight / (volume_a.sqrt() * volume_b.sqrt());
            q[(a, b)] -= between;
            q[(b, a)] -= between;
        }
        Ok(q)
    }

    /// The place in Q and the volume of the block of return `i`, which has weak edges.
    fn place_and_volume(&self, i: u32) -> (usize, f64) {
        let block = self.block_of_return[i as usize] as usize;
        (self.place[block].expect("a block with weak edges has a place"), self.volumes[block])
    }

    /// Joins each of the `leaking` places of Q with the one to which its edge weighs most.
    fn join(&mut self, q: &Mat<f64>, leaking: &[usize]) {
        let mut strongest: Vec<Option<usize>> = vec![None; q.nrows()];
        for &a in leaking {
            let others = (0..q.nrows()).filter(|&b| b != a);
            strongest[a] = others.min_by(|&b, &c| q[(b, a)].total_cmp(&q[(c, a)]));
        }
        // The numbering consumed the sets.
        self.sets.reset(self.block_of_return.len());
        let mut first_return = vec![None; self.volumes.len()];
        for (i, &block) in self.block_of_return.iter().enumerate() {
            self.sets.join(i, *first_return[block as usize].get_or_insert(i));
        }
        for edge in &self.between {
            let (a, b) = (self.place_and_volume(edge.from).0, self.place_and_volume(edge.to).0);
            if strongest[a] == Some(b) || strongest[b] == Some(a) {
                self.sets.join(edge.from as usize, edge.to as usize);
            }
        }
    }
}
