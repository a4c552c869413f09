//! The lowest eigenvalues of a dense block and their eigenvectors, by shift-and-invert.

use crosscut_stage::StageError;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};

use crate::decomposition::Decomposition;
use crate::dot::dot;
use crate::ldlt::Ldlt;

/// Blocks of columns at most.
const MOST_STEPS: usize = 16;
/// Residuals of eigenvalues that are not zeros: their errors are the squares, over the gap.
const RESIDUAL: f64 = 1e-8;
/// What is left of a column that depends on those before it.
const DEPENDENT: f64 = 1e-10;

/// Block Krylov spaces of (L - τI)⁻¹; holds its buffers.
#[derive(Default)]
pub(crate) struct Krylov {
    space: Space,
    small: Decomposition,
    values: Vec<f64>,
}

/// The lowest eigenvalues, ascending, and a unit eigenvector of each.
pub(crate) struct Lowest {
    pub(crate) eigenvalues: Vec<f64>,
    pub(crate) vectors: Mat<f64>,
}

/// The basis so far, and (L - τI)⁻¹ in it.
struct Space {
    /// n×dimension, orthonormal columns.
    basis: Mat<f64>,
    dimension: usize,
    /// VᵀXV, X = (L - τI)⁻¹, of all columns but those of the last block.
    projected: Mat<f64>,
    noise: u64,
}

impl Krylov {
    /// The `wanted` lowest eigenvalues of `laplacian` and their eigenvectors; `None` if they do not settle, or do not agree
    /// with the number of eigenvalues below τ that `factor`, that of L - τI, counts.
    ///
    /// Random columns, `start` among them, are multiplied by (L - τI)⁻¹ again and again, each time made orthonormal against all
    /// before (so an eigenvalue may be repeated as often as there are columns in a block). In their span the eigenvectors are
    /// approximated, first of (L - τI)⁻¹, until the residuals are small, then of L itself (Rayleigh, Ritz).
    ///
    /// # Errors
    /// When a small decomposition does not converge.
    pub(crate) fn lowest(
        &mut self,
        laplacian: MatRef<'_, f64>,
        factor: &Ldlt,
        wanted: usize,
        start: &[f64],
    ) -> Result<Option<Lowest>, StageError> {
        let n = laplacian.nrows();
        let columns = wanted.div_ceil(2).max(factor.below() + 2);
        self.space.begin(n, columns, start);
        let rounding = 100.0 * n as f64 * f64::EPSILON;
        while self.space.dimension + columns <= self.space.basis.ncols() {
            let remainder = self.space.grow(factor, columns);
            let dimension = self.space.dimension - columns;
            if dimension < wanted + 1 {
                continue;
            }
            let projected = self.space.projected.submatrix(0, 0, dimension, dimension);
            self.small.decompose(projected, &mut self.values)?;
            // λ = τ + 1/ν ascends as ν goes down from just below 0 to -∞, and on from ∞ to 0.
            let negative = self.values.partition_point(|&nu| nu < 0.0);
            let order: Vec<usize> = (0..negative).rev().chain((negative..dimension).rev()).take(wanted).collect();
            let settled = |(rank, &j): (usize, &usize)| {
                let last = &self.small.eigenvector(j)[dimension - columns..];
                let residual = norm_of_product(remainder.as_ref(), last) * 2.0 / self.values[j].abs();
                residual <= if rank < factor.below() { rounding } else { RESIDUAL }
            };
            if order.iter().enumerate().all(settled) {
                return self.refine(laplacian, dimension, &order, factor);
            }
        }
        Ok(None)
    }

    /// Rayleigh and Ritz with L itself in the span of the vectors at `order`.
    fn refine(
        &mut self,
        laplacian: MatRef<'_, f64>,
        dimension: usize,
        order: &[usize],
        factor: &Ldlt,
    ) -> Result<Option<Lowest>, StageError> {
        let (n, wanted) = (laplacian.nrows(), order.len());
        let chosen = Mat::from_fn(dimension, wanted, |i, j| self.small.eigenvector(order[j])[i]);
        let vectors = product(self.space.basis.subcols(0, dimension), chosen.as_ref());
        let image = product(laplacian, vectors.as_ref());
        let mut eigenvalues = Vec::new();
        self.small.decompose(product(vectors.transpose(), image.as_ref()).as_ref(), &mut eigenvalues)?;
        let turn = Mat::from_fn(wanted, wanted, |i, j| self.small.eigenvector(j)[i]);
        let (vectors, image) = (product(vectors.as_ref(), turn.as_ref()), product(image.as_ref(), turn.as_ref()));
        let below = eigenvalues.partition_point(|&eigenvalue| eigenvalue < factor.shift());
        let rounding = 100.0 * n as f64 * f64::EPSILON;
        let settled = eigenvalues.iter().enumerate().all(|(j, eigenvalue)| {
            let pairs = image.col_as_slice(j).iter().zip(vectors.col_as_slice(j));
            let residual = pairs.map(|(image, x)| (image - eigenvalue * x).powi(2)).sum::<f64>().sqrt();
            residual <= if j < below { rounding } else { 10.0 * RESIDUAL }
        });
        Ok((settled && below == factor.below().min(wanted)).then_some(Lowest { eigenvalues, vectors }))
    }
}

impl Default for Space {
    fn default() -> Self {
        Self { basis: Mat::new(), dimension: 0, projected: Mat::new(), noise: 0 }
    }
}

impl Space {
    /// Begins anew with random columns, `start` the first of them.
    fn begin(&mut self, n: usize, columns: usize, start: &[f64]) {
        let most = (columns * (MOST_STEPS + 1)).min(n - n % columns);
        self.basis.resize_with(n, most, |_, _| 0.0);
        self.projected.resize_with(most, most, |_, _| 0.0);
        self.dimension = 0;
        self.noise = 0x9E37_79B9_7F4A_7C15;
        let mut first = Mat::from_fn(n, columns, |_, _| random(&mut self.noise));
        first.col_as_slice_mut(0).copy_from_slice(start);
        self.append(first);
    }

    /// Multiplies the last block by (L - τI)⁻¹ and adds what is new in it as the next block. Returns that part in the new
    /// columns, which is the residual of the old ones.
    fn grow(&mut self, factor: &Ldlt, columns: usize) -> Mat<f64> {
        let from = self.dimension - columns;
        let mut image = self.basis.subcols(from, columns).to_owned();
        factor.solve(image.as_mut());
        let known = product(self.basis.subcols(0, self.dimension).transpose(), image.as_ref());
        for j in 0..columns {
            for i in 0..self.dimension {
                self.projected[(i, from + j)] = known[(i, j)];
                self.projected[(from + j, i)] = known[(i, j)];
            }
        }
        self.append(image)
    }

    /// Makes `block` orthonormal, against the basis too, and adds it; returns R, where the part of `block` that was new is the new
    /// columns times R.
    fn append(&mut self, mut block: Mat<f64>) -> Mat<f64> {
        let remainder = self.make_orthonormal(&mut block);
        // What was nearly dependent had little left, and rounding is large in it.
        self.make_orthonormal(&mut block);
        self.basis.subcols_mut(self.dimension, block.ncols()).copy_from(&block);
        self.dimension += block.ncols();
        remainder
    }

    fn make_orthonormal(&mut self, block: &mut Mat<f64>) -> Mat<f64> {
        let basis = self.basis.subcols(0, self.dimension);
        let along = product(basis.transpose(), block.as_ref());
        matmul(block.as_mut(), Accum::Add, basis, along.as_ref(), -1.0, Par::Seq);
        let mut triangle = Mat::zeros(block.ncols(), block.ncols());
        for j in 0..block.ncols() {
            let length = block.col(j).norm_l2();
            for i in 0..j {
                triangle[(i, j)] = take_out(block, i, j);
            }
            let left = block.col(j).norm_l2();
            if left > DEPENDENT * length {
                triangle[(j, j)] = left;
            } else {
                // Nothing new was left. The second time, what is put here is made orthogonal.
                block.col_as_slice_mut(j).iter_mut().for_each(|x| *x = random(&mut self.noise));
            }
            let scale = block.col(j).norm_l2().recip();
            block.col_as_slice_mut(j).iter_mut().for_each(|x| *x *= scale);
        }
        triangle
    }
}

/// In -0.5..0.5.
fn random(state: &mut u64) -> f64 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
}

/// Takes the part along the unit column `i` out of column `j`; how much it was.
fn take_out(block: &mut Mat<f64>, i: usize, j: usize) -> f64 {
    let along = dot(block.col_as_slice(i), block.col_as_slice(j));
    for row in 0..block.nrows() {
        let unit = block[(row, i)];
        block[(row, j)] -= along * unit;
    }
    along
}

fn product(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> Mat<f64> {
    let mut out = Mat::zeros(a.nrows(), b.ncols());
    matmul(out.as_mut(), Accum::Replace, a, b, 1.0, Par::Seq);
    out
}

/// ‖Ax‖.
fn norm_of_product(a: MatRef<'_, f64>, x: &[f64]) -> f64 {
    let row = |i: usize| x.iter().enumerate().map(|(j, x)| a[(i, j)] * x).sum::<f64>();
    (0..a.nrows()).map(|i| row(i).powi(2)).sum::<f64>().sqrt()
}
