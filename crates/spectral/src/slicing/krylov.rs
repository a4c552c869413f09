//! The lowest eigenvalues of a part and their eigenvectors, by shift-and-invert.

use crosscut_stage::StageError;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par, concat, unzip, zip};

use super::envelope::Envelope;
use super::normalised::{Normalised, product};
use crate::decomposition::Decomposition;
use crate::dot::dot;

/// The least number of columns of a block.
const COLUMNS: usize = 4;
/// Columns of a block beyond the number of eigenvalues below the shift.
const SPARE: usize = 2;
/// The space is first checked when it has this many blocks.
const LEAST_BLOCKS: usize = 4;
/// If more than the zeros and the next are wanted, the first check waits for this many further columns an eigenvalue.
const LEAST_SHARE: usize = 2;
/// The space is checked again when it has grown by this share.
const GROWTH: f64 = 0.1;
/// The largest number of columns of the space, for each eigenvalue.
const MOST_SHARE: usize = 6;
/// The largest number of columns of the space beyond that.
const MOST_BESIDE: usize = 48;
/// Largest error of an eigenvalue that is not zero.
const ERROR: f64 = 1e-13;
/// A column of which less than this share is left is made orthogonal once more.
const CANCELLED: f64 = 0.1;
/// The largest number of corrections of the eigenvectors, after an inaccurate factorisation.
const CORRECTIONS: usize = 2;
/// A column of which less than this share is left depends on those before it.
const DEPENDENT: f64 = 1e-10;

/// Block Krylov spaces of X = (L - shift·I)⁻¹; holds its buffers.
#[derive(Default)]
pub(crate) struct Krylov {
    space: Space,
    small: Decomposition,
}

/// The lowest eigenvalues, ascending, and a unit eigenvector of each.
pub(crate) struct Lowest {
    pub(crate) eigenvalues: Vec<f64>,
    pub(crate) vectors: Mat<f64>,
}

impl Krylov {
    /// The `wanted` lowest eigenvalues of the part of `l` that `envelope` has factorised at a shift above all zeros,
    /// and their eigenvectors; `None` if they do not settle, or do not agree with the number of eigenvalues below the
    /// shift.
    ///
    /// Random columns and D^1/2, which L maps to 0, are multiplied by X again and again, each time made orthonormal
    /// against all before (so an eigenvalue may be repeated as often as there are columns in a block). Their span V holds
    /// approximations of the eigenvectors. Once the wanted ones have small residuals, the eigenvalues are those of L itself
    /// in the span of their vectors (Rayleigh, Ritz), and the residuals are computed: whatever rounding the factorisation and
    /// the large values of X caused shows there.
    ///
    /// # Errors
    /// When a small decomposition does not converge.
    pub(crate) fn lowest(
        &mut self,
        l: &Normalised<'_>,
        envelope: &mut Envelope,
        wanted: usize,
    ) -> Result<Option<Lowest>, StageError> {
        let columns = (envelope.below + SPARE).max(COLUMNS);
        let beyond = if wanted > envelope.zeros() + 1 { LEAST_SHARE * wanted } else { 0 };
        let mut least = LEAST_BLOCKS * columns + beyond;
        self.space.begin(&envelope.roots, columns, MOST_SHARE * wanted + MOST_BESIDE);
        loop {
            let is_last = !self.space.grow(envelope);
            if !is_last && self.space.dimension < least {
                continue;
            }
            if let Some(candidates) = self.candidates(envelope, wanted)?
                && let Some(lowest) = self.settle(l, envelope, candidates)?
            {
                let below = lowest.eigenvalues.iter().filter(|&&eigenvalue| eigenvalue < envelope.shift).count();
                return Ok((below == envelope.below).then_some(lowest));
            }
            if is_last {
                return Ok(None);
            }
            least = self.space.dimension + (GROWTH * self.space.dimension as f64) as usize;
        }
    }

    /// Approximations of the eigenvectors in the current space, if their residuals are small.
    ///
    /// The eigenvectors y of H, H y = ν y, give λ = shift + 1/ν. One more step of inverse iteration needs no solution,
    ///
    /// z = X V y / ν = V y + (the next block) R y / ν, with (L - λ) z = (V y - z) / ν,
    ///
    /// so the residual of z is known before z is: ‖R y‖ / ν².
    fn candidates(&mut self, envelope: &Envelope, wanted: usize) -> Result<Option<Candidates>, StageError> {
        let Self { space, small } = self;
        let (dimension, columns) = (space.dimension - space.columns, space.columns);
        let mut values = Vec::new();
        small.decompose(space.projected.submatrix(0, 0, dimension, dimension), &mut values)?;
        // λ = shift + 1/ν ascends as ν descends from just below 0 to -∞, and then from ∞ to 0.
        let negative = values.partition_point(|&nu| nu < 0.0);
        let mut order = (0..negative).rev().chain((negative..dimension).rev());
        let chosen: Vec<usize> = order.by_ref().take(wanted).collect();
        let Some(outside) = order.next().map(|j| envelope.shift + values[j].recip()) else { return Ok(None) };
        let needed = Needed { n: envelope.members.len(), zeros: envelope.zeros().min(wanted), outside };

        let y = Mat::from_fn(dimension, wanted, |i, j| small.eigenvector(chosen[j])[i]);
        let mut beyond = product(space.remainder.as_ref(), y.subrows(dimension - columns, columns));
        for (j, &at) in chosen.iter().enumerate() {
            let inverse = values[at].recip();
            beyond.col_as_slice_mut(j).iter_mut().for_each(|x| *x *= inverse);
            if !needed.is_met(j, envelope.shift + inverse, norm(beyond.col_as_slice(j)) * inverse.abs()) {
                return Ok(None);
            }
        }
        let mut turn = concat![[y], [beyond]];
        make_orthonormal(&mut turn, &mut space.noise);
        let vectors = product(space.basis.subcols(0, space.dimension), turn.as_ref());
        Ok(Some(Candidates { vectors, needed }))
    }

    /// The eigenvalues of L in the span of the vectors (Rayleigh, Ritz), if their residuals r are small; else each vector
    /// is corrected first by (L - shift·I)⁻¹ r. As r is small, so is what an inaccurate factorisation makes of it.
    fn settle(
        &mut self,
        l: &Normalised<'_>,
        envelope: &mut Envelope,
        Candidates { mut vectors, needed }: Candidates,
    ) -> Result<Option<Lowest>, StageError> {
        let wanted = vectors.ncols();
        let mut eigenvalues = Vec::new();
        for _ in 0..=CORRECTIONS {
            let image = l.times(&envelope.members, &vectors);
            self.small.decompose(product(vectors.transpose(), image.as_ref()).as_ref(), &mut eigenvalues)?;
            let turn = Mat::from_fn(wanted, wanted, |i, j| self.small.eigenvector(j)[i]);
            vectors = product(vectors.as_ref(), turn.as_ref());
            let mut residuals = product(image.as_ref(), turn.as_ref());
            let mut settled = true;
            for (j, &eigenvalue) in eigenvalues.iter().enumerate() {
                zip!(residuals.col_mut(j), vectors.col(j)).for_each(|unzip!(image, x)| *image -= eigenvalue * x);
                settled &= needed.is_met(j, eigenvalue, norm(residuals.col_as_slice(j)));
            }
            if settled {
                return Ok(Some(Lowest { eigenvalues, vectors }));
            }
            envelope.solve(&mut residuals);
            vectors -= residuals;
            make_orthonormal(&mut vectors, &mut self.space.noise);
        }
        Ok(None)
    }
}

/// Approximate eigenvectors, orthonormal, and how small their residuals have to be.
struct Candidates {
    vectors: Mat<f64>,
    needed: Needed,
}

/// What residuals have to be.
struct Needed {
    n: usize,
    /// Eigenvalues that count as zero.
    zeros: usize,
    /// The next eigenvalue after those that are wanted.
    outside: f64,
}

impl Needed {
    /// Whether the residual of eigenvalue `j` is small enough. The span of the zeros is off by no more than their
    /// residuals over the gap. The others are off by their residual at most, and by residual² over the distance of what is
    /// outside.
    fn is_met(&self, j: usize, eigenvalue: f64, residual: f64) -> bool {
        if j < self.zeros {
            return residual <= 10.0 * self.n as f64 * f64::EPSILON;
        }
        residual <= ERROR || residual * residual <= ERROR * (self.outside - eigenvalue)
    }
}

/// The basis V, and X in it: X V = V H + (the next block) R.
struct Space {
    /// V, n×dimension, orthonormal columns.
    basis: Mat<f64>,
    /// H, of all columns but those of the last block.
    projected: Mat<f64>,
    /// R, of the last block.
    remainder: Mat<f64>,
    columns: usize,
    dimension: usize,
    noise: u64,
}

impl Default for Space {
    fn default() -> Self {
        Self { basis: Mat::new(), projected: Mat::new(), remainder: Mat::new(), columns: 0, dimension: 0, noise: 0 }
    }
}

impl Space {
    /// Starts with random columns after `start`.
    fn begin(&mut self, start: &[f64], columns: usize, most: usize) {
        let n = start.len();
        let most = most.min(n) / columns * columns;
        self.basis.resize_with(n, most, |_, _| 0.0);
        self.projected.resize_with(most, most, |_, _| 0.0);
        self.projected.fill(0.0);
        (self.columns, self.dimension, self.noise) = (columns, 0, 0x9E37_79B9_7F4A_7C15);
        let mut first = Mat::from_fn(n, columns, |_, _| random(&mut self.noise));
        first.col_as_slice_mut(0).copy_from_slice(start);
        self.append(first);
    }

    /// Multiplies the last block by X, and adds what is new in it as the next block; `false` if there is no room for
    /// that.
    fn grow(&mut self, envelope: &mut Envelope) -> bool {
        let Self { basis, projected, columns, dimension, .. } = self;
        if *dimension + *columns > basis.ncols() {
            return false;
        }
        let from = *dimension - *columns;
        let mut image = basis.subcols(from, *columns).to_owned();
        envelope.solve(&mut image);
        // X is symmetric: of the blocks before the last two there is no more in the image than what rounding leaves.
        let back = from.saturating_sub(*columns);
        let basis = basis.subcols(back, *dimension - back);
        let known = product(basis.transpose(), image.as_ref());
        for j in 0..*columns {
            for (i, row) in (back..*dimension).enumerate() {
                projected[(row, from + j)] = known[(i, j)];
                projected[(from + j, row)] = known[(i, j)];
            }
        }
        matmul(image.as_mut(), Accum::Add, basis, known.as_ref(), -1.0, Par::Seq);
        self.append(image);
        true
    }

    /// Makes `block` orthonormal, against the basis too, of which there is little left in it, and adds it.
    fn append(&mut self, mut block: Mat<f64>) {
        let basis = self.basis.subcols(0, self.dimension);
        let project = |block: &mut Mat<f64>| {
            let along = product(basis.transpose(), block.as_ref());
            matmul(block.as_mut(), Accum::Add, basis, along.as_ref(), -1.0, Par::Seq);
        };
        // X makes what rounding leaves of the zeros large again; once more is enough.
        project(&mut block);
        let lengths: Vec<f64> = (0..block.ncols()).map(|j| norm(block.col_as_slice(j))).collect();
        self.remainder = make_orthonormal(&mut block, &mut self.noise);
        if (0..block.ncols()).any(|j| self.remainder[(j, j)] < CANCELLED * lengths[j]) {
            project(&mut block);
            make_orthonormal(&mut block, &mut self.noise);
        }
        self.basis.subcols_mut(self.dimension, block.ncols()).copy_from(&block);
        self.dimension += block.ncols();
    }
}

/// Makes the columns of `block` orthonormal; returns R, `block` was what it is now times R. A column in which nothing
/// is left is random instead, and R has a 0 there.
fn make_orthonormal(block: &mut Mat<f64>, noise: &mut u64) -> Mat<f64> {
    let mut triangle = Mat::zeros(block.ncols(), block.ncols());
    for j in 0..block.ncols() {
        let length = norm(block.col_as_slice(j));
        for i in 0..j {
            triangle[(i, j)] = take_out(block, i, j);
        }
        let left = norm(block.col_as_slice(j));
        if left > DEPENDENT * length {
            triangle[(j, j)] = left;
        } else {
            block.col_as_slice_mut(j).iter_mut().for_each(|x| *x = random(noise));
        }
        let scale = norm(block.col_as_slice(j)).recip();
        block.col_as_slice_mut(j).iter_mut().for_each(|x| *x *= scale);
    }
    triangle
}

/// Takes the part along the unit column `i` out of column `j`, i < j; how much it was.
fn take_out(block: &mut Mat<f64>, i: usize, j: usize) -> f64 {
    let along = dot(block.col_as_slice(i), block.col_as_slice(j));
    let (units, rest) = block.as_mut().split_at_col_mut(j);
    zip!(rest.col_mut(0), units.as_ref().col(i)).for_each(|unzip!(x, unit)| *x -= along * unit);
    along
}

/// ‖x‖, of numbers whose squares are neither too large nor too small. The library's norm, which takes any, costs a fifth of
/// the solver.
fn norm(x: &[f64]) -> f64 {
    dot(x, x).sqrt()
}

/// In -0.5..0.5.
fn random(state: &mut u64) -> f64 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
}
