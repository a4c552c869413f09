//! One block's Laplacian as a band matrix, and its factorisation.

use crate::graph::Graph;
use crate::order::Order;
use crate::second::Factorise;

/// Strides that the kernels are compiled for: 4 neighbours on either side, as along a wall, and 8.
const USUAL_STRIDES: [usize; 2] = [5, 9];

/// The Laplacian of one block, the links to others set aside, by the columns of its lower triangle: entries stay near the
/// diagonal if rows stand in the order of returns along a wall.
#[derive(Clone, Debug, Default)]
pub(crate) struct Band {
    n: usize,
    /// Entries of a column: the diagonal and what is below it.
    stride: usize,
    entries: Vec<f64>,
    /// L - shift·I = M Δ Mᵀ: 1/Δ on the diagonal, M below its unit diagonal.
    factor: Vec<f64>,
}

impl Band {
    /// Takes one block of `graph`. `leaks` are the weights of each return's links to other blocks, which are set aside.
    pub(crate) fn form(&mut self, graph: &Graph<'_>, leaks: &[f64], order: &Order, block: usize) {
        let members = order.members(block);
        self.n = members.len();
        self.stride = order.width(block) + 1;
        let padded = USUAL_STRIDES.into_iter().find(|&usual| self.stride <= usual);
        self.stride = padded.unwrap_or(self.stride);
        self.entries.clear();
        // Columns of zeros at the end, so that every column has `stride` rows below it.
        self.entries.resize((self.n + self.stride) * self.stride, 0.0);
        let scale = graph.inverse_sqrt_degrees;
        for (at, (&i, column)) in members.iter().zip(self.entries.chunks_exact_mut(self.stride)).enumerate() {
            let i = i as usize;
            let (others, weights) = graph.edges.row(i);
            column[0] = 1.0 - leaks[i] * (scale[i] * scale[i]);
            for (&j, weight) in others.iter().zip(weights) {
                let j = j as usize;
                if order.block(j) == block && order.rank(j) >= at {
                    column[order.rank(j) - at] -= weight * (scale[i] * scale[j]);
                }
            }
        }
    }
}

impl Factorise for Band {
    fn factorise(&mut self, shift: f64) -> usize {
        self.factor.clone_from(&self.entries);
        match self.stride {
            5 => factorise(&mut self.factor, self.n, 5, shift),
            9 => factorise(&mut self.factor, self.n, 9, shift),
            stride => factorise(&mut self.factor, self.n, stride, shift),
        }
    }

    fn solve(&mut self, x: &mut Vec<f64>) {
        x.resize(self.n + self.stride, 0.0);
        match self.stride {
            5 => solve(&self.factor, x, self.n, 5),
            9 => solve(&self.factor, x, self.n, 9),
            stride => solve(&self.factor, x, self.n, stride),
        }
        x.truncate(self.n);
    }
}

/// LDLᵀ in place, column by column.
#[inline(always)]
fn factorise(columns: &mut [f64], n: usize, stride: usize, shift: f64) -> usize {
    let mut negative = 0;
    for i in 0..n {
        let (pivot_column, rest) = columns[i * stride..].split_at_mut(stride);
        let mut pivot = pivot_column[0] - shift;
        if pivot.abs() < f64::MIN_POSITIVE {
            pivot = f64::EPSILON * f64::EPSILON;
        }
        negative += usize::from(pivot < 0.0);
        let inverse = pivot.recip();
        for (a, column) in (1..stride).zip(rest.chunks_exact_mut(stride)) {
            let factor = pivot_column[a] * inverse;
            for (entry, below) in column.iter_mut().zip(&pivot_column[a..]) {
                *entry -= factor * below;
            }
        }
        pivot_column[0] = inverse;
        pivot_column[1..].iter_mut().for_each(|entry| *entry *= inverse);
    }
    negative
}

/// M Δ Mᵀ x = `x` in place; `x` goes on beyond its n entries.
#[inline(always)]
fn solve(columns: &[f64], x: &mut [f64], n: usize, stride: usize) {
    for (i, column) in columns.chunks_exact(stride).take(n).enumerate() {
        let window = &mut x[i..i + stride];
        let top = window[0];
        for (below, entry) in window[1..].iter_mut().zip(&column[1..]) {
            *below -= entry * top;
        }
        window[0] = top * column[0];
    }
    x[n..].fill(0.0);
    for (i, column) in columns.chunks_exact(stride).take(n).enumerate().rev() {
        let window = &mut x[i..i + stride];
        let below: f64 = window[1..].iter().zip(&column[1..]).map(|(x, entry)| x * entry).sum();
        window[0] -= below;
    }
}
