//! One block's Laplacian as a band matrix, and its factorisation.

use crate::graph::Graph;
use crate::order::Order;
use crate::second::ShiftInvert;

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
    /// L - shift·I = M Δ Mᵀ: M below its unit diagonal.
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
        for (at, &i) in members.iter().enumerate() {
            let i = i as usize;
            self.entries[at * self.stride] += 1.0 - leaks[i] * (scale[i] * scale[i]);
            // W is symmetric: half of it is enough.
            for (j, weight) in graph.edges_from(i) {
                if order.block(j) == block {
                    let rank = order.rank(j);
                    let entry = at.min(rank) * self.stride + at.abs_diff(rank);
                    self.entries[entry] -= weight * (scale[i] * scale[j]);
                }
            }
        }
    }
}

impl ShiftInvert for Band {
    fn solve(&mut self, shift: f64, x: &mut Vec<f64>) -> usize {
        let Self { n, stride, ref entries, ref mut factor } = *self;
        x.resize(n + stride, 0.0);
        factor.clone_from(entries);
        let negative = match stride {
            5 => solve_narrow::<5>(factor, x, n, shift),
            9 => solve_narrow::<9>(factor, x, n, shift),
            stride => solve_wide(factor, x, n, stride, shift),
        };
        x.truncate(n);
        negative
    }
}

/// 1 / (entry - shift), of an entry of the diagonal; where that is 0, as if it were next to it.
fn inverse_pivot(entry: f64, shift: f64) -> f64 {
    let pivot = entry - shift;
    if pivot.abs() < f64::MIN_POSITIVE { (f64::EPSILON * f64::EPSILON).recip() } else { pivot.recip() }
}

/// LDLᵀ of `columns` - shift·I in place, column by column, and the solution of that with `x` in place, which goes on beyond
/// its n entries. Returns the number of negative pivots. Elimination takes `x` along: a pivot has to wait for a division,
/// and meanwhile there is time for it.
fn solve_wide(columns: &mut [f64], x: &mut [f64], n: usize, stride: usize, shift: f64) -> usize {
    let mut negative = 0;
    for i in 0..n {
        let (pivot_column, rest) = columns[i * stride..].split_at_mut(stride);
        let inverse = inverse_pivot(pivot_column[0], shift);
        negative += usize::from(inverse < 0.0);
        let window = &mut x[i..i + stride];
        let top = window[0];
        for (a, column) in (1..stride).zip(rest.chunks_exact_mut(stride)) {
            let factor = pivot_column[a] * inverse;
            for (entry, below) in column.iter_mut().zip(&pivot_column[a..]) {
                *entry -= factor * below;
            }
            window[a] -= factor * top;
        }
        pivot_column[1..].iter_mut().for_each(|entry| *entry *= inverse);
        window[0] = top * inverse;
    }
    x[n..].fill(0.0);
    for (i, column) in columns.chunks_exact(stride).take(n).enumerate().rev() {
        let window = &mut x[i..i + stride];
        // The nearest, which was found last, is taken last.
        let below = window[1..].iter().zip(&column[1..]).rev();
        window[0] = below.fold(window[0], |top, (x, entry)| top - x * entry);
    }
    negative
}

/// The same for so few entries of a column that all columns that a pivot changes stay in registers. Products of entries do not
/// wait for the division.
fn solve_narrow<const STRIDE: usize>(columns: &mut [f64], x: &mut [f64], n: usize, shift: f64) -> usize {
    let (columns, _) = columns.as_chunks_mut::<STRIDE>();
    let mut negative = 0;
    // Columns i to i + STRIDE, and those entries of x, as far as they are eliminated.
    let mut window: [[f64; STRIDE]; STRIDE] = std::array::from_fn(|a| columns[a]);
    let mut right: [f64; STRIDE] = std::array::from_fn(|a| x[a]);
    for i in 0..n {
        let (pivot_column, top) = (window[0], right[0]);
        let inverse = inverse_pivot(pivot_column[0], shift);
        negative += usize::from(inverse < 0.0);
        columns[i] = pivot_column.map(|entry| entry * inverse);
        x[i] = top * inverse;
        // Each column moves up by one place in the window.
        for a in 1..STRIDE {
            for b in 0..STRIDE - a {
                window[a][b] -= pivot_column[a] * pivot_column[a + b] * inverse;
            }
            window[a - 1] = window[a];
            right[a - 1] = right[a] - pivot_column[a] * top * inverse;
        }
        (window[STRIDE - 1], right[STRIDE - 1]) = (columns[i + STRIDE], x[i + STRIDE]);
    }
    // Entries i to i + STRIDE of x, of which the first is not yet known.
    let mut solved = [0.0; STRIDE];
    for i in (0..n).rev() {
        // The nearest, which was found last, is taken last.
        solved[0] = (1..STRIDE).rev().fold(x[i], |top, a| top - columns[i][a] * solved[a]);
        x[i] = solved[0];
        for a in (1..STRIDE).rev() {
            solved[a] = solved[a - 1];
        }
    }
    negative
}
