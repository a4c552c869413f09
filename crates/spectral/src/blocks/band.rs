//! One block's Laplacian as a band matrix, and its factorisation.

use super::graph::Graph;
use super::order::Order;

/// The longest edges that the kernels are compiled for: to 2 neighbours on either side, as along a wall, and to 4.
const USUAL_WIDTHS: [usize; 2] = [2, 4];
/// Entries of a column of such a band: the diagonal and what is below it.
const NARROW: usize = USUAL_WIDTHS[0] + 1;
const WIDER: usize = USUAL_WIDTHS[1] + 1;

/// The Laplacian of one block, the edges to others set aside, by the columns of its lower triangle: entries stay near
/// the diagonal if rows stand in the order of returns along a wall.
#[derive(Clone, Debug, Default)]
pub(crate) struct Band {
    n: usize,
    /// Entries of a column: the diagonal and what is below it.
    stride: usize,
    entries: Vec<f64>,
    /// L - shift·I = M Δ Mᵀ: the columns of M.
    factor: Vec<f64>,
}

impl Band {
    /// Forms one block of `graph`, in the order of its returns. `leaks` are the weights of each return's edges to other
    /// blocks, which are set aside.
    pub(crate) fn form(&mut self, graph: &Graph, leaks: &[f64], order: &Order, block: usize) {
        let (members, rank, width) = (order.members(block), order.ranks(block), order.longest[block]);
        self.n = members.len();
        self.stride = 1 + USUAL_WIDTHS.into_iter().find(|&usual| width <= usual).unwrap_or(width);
        self.entries.clear();
        // Columns of zeros at the end, so that every column has `stride` rows below it.
        self.entries.resize((self.n + self.stride) * self.stride, 0.0);
        for (at, &i) in members.iter().enumerate() {
            self.entries[at * self.stride] = graph.diagonal(i as usize, leaks[i as usize]);
            for edge in graph.edges_back(i as usize) {
                if let Some(rank) = rank(edge.to as usize) {
                    self.entries[at.min(rank) * self.stride + at.abs_diff(rank)] = -edge.scaled;
                }
            }
        }
    }

    /// Solves (L - shift·I) x = `x` in place by a factorisation; the number of its negative pivots, which is returned,
    /// is that of eigenvalues below the shift. `x` has n entries; longer parts are removed.
    pub(crate) fn solve(&mut self, shift: f64, x: &mut Vec<f64>) -> usize {
        let (n, stride) = (self.n, self.stride);
        self.factor.resize(n * stride, 0.0);
        x.resize(n + stride, 0.0);
        let negative = match stride {
            NARROW => solve_narrow::<NARROW>(&self.entries, shift, &mut self.factor, x),
            WIDER => solve_narrow::<WIDER>(&self.entries, shift, &mut self.factor, x),
            _ => {
                self.factor.clone_from(&self.entries);
                let negative = eliminate_wide(&mut self.factor, n, stride, shift, |i, column, inverse| {
                    forward(&mut x[i..], column, inverse);
                });
                x[n..].fill(0.0);
                let columns = self.factor.chunks_exact(stride).take(n).enumerate().rev();
                columns.for_each(|(i, column)| backward(&mut x[i..], column));
                negative
            }
        };
        x.truncate(n);
        negative
    }

    /// The number of eigenvalues below a shift, by the pivots alone.
    pub(crate) fn count_below(&mut self, shift: f64) -> usize {
        match self.stride {
            NARROW => eliminate_narrow::<NARROW>(&self.entries, self.n, shift, |_, _, _| ()),
            WIDER => eliminate_narrow::<WIDER>(&self.entries, self.n, shift, |_, _, _| ()),
            stride => {
                self.factor.clone_from(&self.entries);
                eliminate_wide(&mut self.factor, self.n, stride, shift, |_, _, _| ())
            }
        }
    }
}

/// One step down of M y = `x`, with a column of M from its diagonal on, and of Δ z = y, with the inverse of its pivot.
#[inline(always)] // for the length of a narrow column, which is then known
fn forward(x: &mut [f64], column: &[f64], inverse: f64) {
    let (top, below) = x[..column.len()].split_first_mut().expect("a column has a diagonal");
    below.iter_mut().zip(&column[1..]).for_each(|(x, entry)| *x -= entry * *top);
    *top *= inverse;
}

/// One step up of Mᵀ x = z.
#[inline(always)] // likewise
fn backward(x: &mut [f64], column: &[f64]) {
    let (top, below) = x[..column.len()].split_first_mut().expect("a column has a diagonal");
    // The nearest, which was found last, is taken last.
    *top = below.iter().zip(&column[1..]).rev().fold(*top, |top, (x, entry)| top - x * entry);
}

/// Solves (matrix - shift·I) x = `x` in place, with STRIDE entries of zero behind; returns the number of negative
/// pivots.
fn solve_narrow<const STRIDE: usize>(entries: &[f64], shift: f64, factor: &mut [f64], x: &mut [f64]) -> usize {
    let (factor, _) = factor.as_chunks_mut::<STRIDE>();
    let n = factor.len();
    let negative = eliminate_narrow::<STRIDE>(entries, n, shift, |i, column, inverse| {
        factor[i] = *column;
        forward(&mut x[i..], column, inverse);
    });
    x[n..].fill(0.0);
    factor.iter().enumerate().rev().for_each(|(i, column)| backward(&mut x[i..], column));
    negative
}

/// 1 / (entry - shift), of an entry of the diagonal; where that is 0, as if it were next to it.
fn inverse_pivot(entry: f64, shift: f64) -> f64 {
    let pivot = entry - shift;
    if pivot.abs() < f64::MIN_POSITIVE { (f64::EPSILON * f64::EPSILON).recip() } else { pivot.recip() }
}

/// LDLᵀ of a matrix - shift·I, M Δ Mᵀ, in place, column by column: calls `pivot(i, column, inverse)` with column i of
/// M, from its diagonal on, and the inverse of its pivot. Returns the number of negative pivots.
fn eliminate_wide(
    columns: &mut [f64],
    n: usize,
    stride: usize,
    shift: f64,
    mut pivot: impl FnMut(usize, &[f64], f64),
) -> usize {
    let mut negative = 0;
    for i in 0..n {
        let (column, rest) = columns[i * stride..].split_at_mut(stride);
        let inverse = inverse_pivot(column[0], shift);
        negative += usize::from(inverse < 0.0);
        for (a, later) in (1..stride).zip(rest.chunks_exact_mut(stride)) {
            let factor = column[a] * inverse;
            for (entry, below) in later.iter_mut().zip(&column[a..]) {
                *entry -= factor * below;
            }
        }
        column.iter_mut().for_each(|entry| *entry *= inverse);
        pivot(i, column, inverse);
    }
    negative
}

/// LDLᵀ as `eliminate_wide` makes it, of columns so short that the entries which a pivot changes stay in registers.
#[inline]
fn eliminate_narrow<const STRIDE: usize>(
    columns: &[f64],
    n: usize,
    shift: f64,
    mut pivot: impl FnMut(usize, &[f64; STRIDE], f64),
) -> usize {
    let (columns, _) = columns.as_chunks::<STRIDE>();
    let mut negative = 0;
    // Columns i to i + STRIDE, as far as the pivots before i reach down in them.
    let mut window: [[f64; STRIDE]; STRIDE] = std::array::from_fn(|a| columns[a]);
    for i in 0..n {
        let column = window[0];
        let inverse = inverse_pivot(column[0], shift);
        negative += usize::from(inverse < 0.0);
        let scaled = column.map(|entry| entry * inverse);
        pivot(i, &scaled, inverse);
        // Each column moves up by one place in the window, and gets the entry that the next pivot reaches.
        let later = &columns[i + 1..][..STRIDE];
        for a in 1..=STRIDE {
            for b in 0..STRIDE - a {
                window[a - 1][b] = window[a][b] - scaled[a] * column[a + b];
            }
            window[a - 1][STRIDE - a] = later[a - 1][STRIDE - a];
        }
    }
    negative
}
