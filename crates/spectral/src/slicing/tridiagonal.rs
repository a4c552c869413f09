//! A full decomposition of a small matrix whose eigenvectors are not formed.

use crosscut_stage::StageError;
use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::evd::tridiag::{tridiag_in_place, tridiag_in_place_scratch};
use faer::{Mat, MatRef, Par, Spec};

use crate::decomposition::make_room;
use crate::dot::dot;

/// The largest number of sweeps for each eigenvalue.
const SWEEPS: usize = 30;

/// H = Y N Yᵀ of a symmetric H, m×m, N its eigenvalues, ascending. Y is kept as a product: the reflections Q that
/// make H tridiagonal (Householder), the rotations G that make that diagonal (implicit QR with Wilkinson's shift; Golub
/// and Van Loan, Matrix Computations, 8.3), and the order of the eigenvalues. A few columns or rows of Y then cost little;
/// all of them would cost most of a decomposition.
pub(crate) struct Tridiagonal {
    /// Below its subdiagonal the reflections: column k has that of the rows from k + 1 on, without its leading 1.
    reflections: Mat<f64>,
    /// The divisor of each reflection, 1×(m - 1).
    divisors: Mat<f64>,
    rotations: Vec<Rotation>,
    /// The place of each eigenvalue after the rotations, eigenvalues ascending.
    order: Vec<usize>,
    diagonal: Vec<f64>,
    off_diagonal: Vec<f64>,
    scratch: MemBuffer,
}

/// Columns `upper` and `upper` + 1 of Q G, x and y, become c·x + s·y and c·y - s·x.
#[derive(Clone, Copy)]
struct Rotation {
    upper: usize,
    cosine: f64,
    sine: f64,
}

impl Default for Tridiagonal {
    fn default() -> Self {
        Self {
            reflections: Mat::new(),
            divisors: Mat::new(),
            rotations: Vec::new(),
            order: Vec::new(),
            diagonal: Vec::new(),
            off_diagonal: Vec::new(),
            scratch: MemBuffer::new(StackReq::empty()),
        }
    }
}

impl Tridiagonal {
    /// Writes the eigenvalues of a symmetric matrix, ascending, of which the lower triangle is read.
    ///
    /// # Errors
    /// When it does not converge.
    pub(crate) fn decompose(&mut self, matrix: MatRef<'_, f64>, eigenvalues: &mut Vec<f64>) -> Result<(), StageError> {
        let m = matrix.nrows();
        self.reflections.resize_with(m, m, |_, _| 0.0);
        self.reflections.copy_from(matrix);
        self.divisors.resize_with(1, m.saturating_sub(1), |_, _| 0.0);
        make_room(&mut self.scratch, tridiag_in_place_scratch::<f64>(m, Par::Seq, Spec::default()));
        let scratch = MemStack::new(&mut self.scratch);
        tridiag_in_place(self.reflections.as_mut(), self.divisors.as_mut(), Par::Seq, scratch, Spec::default());
        self.diagonal.clear();
        self.diagonal.extend((0..m).map(|i| self.reflections[(i, i)]));
        self.off_diagonal.clear();
        self.off_diagonal.extend((1..m).map(|i| self.reflections[(i, i - 1)]));
        self.rotations.clear();
        for last in (1..m).rev() {
            let mut sweeps = 0;
            while let Some(first) = self.coupled_with(last) {
                if sweeps == SWEEPS {
                    return Err(StageError::NoConvergence { n: m });
                }
                self.sweep(first, last);
                sweeps += 1;
            }
        }
        self.order.clear();
        self.order.extend(0..m);
        self.order.sort_by(|&i, &j| self.diagonal[i].total_cmp(&self.diagonal[j]));
        eigenvalues.clear();
        eigenvalues.extend(self.order.iter().map(|&i| self.diagonal[i]));
        Ok(())
    }

    /// The first row that is coupled with row `last`, if another one is.
    fn coupled_with(&self, last: usize) -> Option<usize> {
        let Self { diagonal, off_diagonal, .. } = self;
        let is_coupled = |&i: &usize| {
            let nothing = f64::EPSILON * (diagonal[i].abs() + diagonal[i + 1].abs());
            // NaN counts as coupled, so that it ends in an error.
            off_diagonal[i].abs().partial_cmp(&nothing).is_none_or(std::cmp::Ordering::is_gt)
        };
        let coupled = (0..last).rev().take_while(is_coupled).count();
        (coupled > 0).then_some(last - coupled)
    }

    /// One step of implicit QR on the rows `first..=last`.
    fn sweep(&mut self, first: usize, last: usize) {
        let Self { rotations, diagonal, off_diagonal, .. } = self;
        let half = (diagonal[last - 1] - diagonal[last]) / (2.0 * off_diagonal[last - 1]);
        let root = half.hypot(1.0).copysign(half);
        let shift = diagonal[last] - off_diagonal[last - 1] / (half + root);
        let (mut cosine, mut sine, mut taken) = (1.0, 1.0, 0.0);
        let mut bulge = diagonal[first] - shift;
        for upper in first..last {
            let (along, across) = (cosine * off_diagonal[upper], sine * off_diagonal[upper]);
            let length = (across * across + bulge * bulge).sqrt();
            if upper > first {
                off_diagonal[upper - 1] = length;
            }
            if length == 0.0 {
                // The rows so far are parted from the others.
                diagonal[upper] -= taken;
                return;
            }
            (sine, cosine) = (across / length, bulge / length);
            let rest = diagonal[upper] - taken;
            let turned = (diagonal[upper + 1] - rest) * sine + 2.0 * cosine * along;
            taken = sine * turned;
            diagonal[upper] = rest + taken;
            bulge = cosine * turned - along;
            rotations.push(Rotation { upper, cosine, sine });
        }
        diagonal[last] -= taken;
        off_diagonal[last - 1] = bulge;
    }

    /// Sums of the unit eigenvectors of the eigenvalues at `chosen`, m×few, by `weights`, chosen×few.
    pub(crate) fn sums(&self, chosen: &[usize], weights: MatRef<'_, f64>) -> Mat<f64> {
        let (m, few) = (self.order.len(), weights.ncols());
        let mut rows = vec![0.0; m * few];
        for (weights, &j) in weights.row_iter().zip(chosen) {
            let row = &mut rows[self.order[j] * few..][..few];
            row.iter_mut().zip(weights.iter()).for_each(|(x, weight)| *x = *weight);
        }
        for &Rotation { upper, cosine, sine } in self.rotations.iter().rev() {
            rotate(&mut rows[upper * few..][..2 * few], cosine, -sine);
        }
        let mut sums = Mat::from_fn(m, few, |i, j| rows[i * few + j]);
        for j in 0..few {
            (0..self.divisors.ncols()).rev().for_each(|k| self.reflect(k, sums.col_as_slice_mut(j)));
        }
        sums
    }

    /// The last `few` rows of the unit eigenvectors of the eigenvalues at `chosen`, few×chosen.
    pub(crate) fn last_rows(&self, few: usize, chosen: &[usize]) -> Mat<f64> {
        let m = self.order.len();
        let mut units = Mat::zeros(m, few);
        for j in 0..few {
            units[(m - few + j, j)] = 1.0;
            (0..self.divisors.ncols()).for_each(|k| self.reflect(k, units.col_as_slice_mut(j)));
        }
        let mut columns: Vec<f64> = units.row_iter().flat_map(|row| row.iter().copied()).collect();
        for &Rotation { upper, cosine, sine } in &self.rotations {
            rotate(&mut columns[upper * few..][..2 * few], cosine, sine);
        }
        Mat::from_fn(few, chosen.len(), |i, j| columns[self.order[chosen[j]] * few + i])
    }

    /// Reflection `k` of `x`.
    fn reflect(&self, k: usize, x: &mut [f64]) {
        let reflection = &self.reflections.col_as_slice(k)[k + 2..];
        let (first, rest) = x[k + 1..].split_first_mut().expect("a reflection has rows");
        let along = (*first + dot(reflection, rest)) / self.divisors[(0, k)];
        *first -= along;
        rest.iter_mut().zip(reflection).for_each(|(x, v)| *x -= along * v);
    }
}

/// Two columns, one after the other, x and y, become c·x + s·y and c·y - s·x.
fn rotate(both: &mut [f64], cosine: f64, sine: f64) {
    let (x, y) = both.split_at_mut(both.len() / 2);
    for (x, y) in x.iter_mut().zip(y) {
        (*x, *y) = (cosine * *x + sine * *y, cosine * *y - sine * *x);
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// A symmetric matrix of m rows whose entries shrink from a scale of 1 at its first row to the `grade` at
    /// its last.
    fn symmetric(entries: &[f64], m: usize, grade: f64) -> Mat<f64> {
        let scale = |i: usize| grade.powf(i as f64 / m as f64 / 2.0);
        Mat::from_fn(m, m, |i, j| entries[i.max(j) * m + i.min(j)] * scale(i) * scale(j))
    }

    proptest! {
        #[test]
        fn eigenvectors_are_orthonormal_and_diagonalise_the_matrix(
            m in 1..40usize,
            entries in prop::collection::vec(-1.0..1.0f64, 1600),
            grade in prop::sample::select(vec![1.0, 1e-4, 1e-8]),
            zeroed in 0..4usize,
        ) {
            // Some of its rows are uncoupled from all others and equal, so that eigenvalues repeat.
            let h = symmetric(&entries, m, grade);
            let h = Mat::from_fn(m, m, |i, j| match i.max(j) + zeroed >= m {
                true => f64::from(u8::from(i == j)),
                false => h[(i, j)],
            });
            let (mut tridiagonal, mut eigenvalues) = (Tridiagonal::default(), Vec::new());
            tridiagonal.decompose(h.as_ref(), &mut eigenvalues).expect("numbers");
            let all: Vec<usize> = (0..m).collect();
            let y = tridiagonal.sums(&all, Mat::<f64>::identity(m, m).as_ref());
            let rounding = 1e-14 * m as f64;
            prop_assert!(eigenvalues.is_sorted());
            prop_assert!((y.transpose() * &y - Mat::<f64>::identity(m, m)).norm_max() < rounding);
            let diagonal = Mat::from_fn(m, m, |i, j| if i == j { eigenvalues[i] } else { 0.0 });
            prop_assert!((&h * &y - &y * &diagonal).norm_max() < rounding * h.norm_max().max(1.0));

            let few = m.min(3);
            let some: Vec<usize> = (0..m).rev().step_by(2).collect();
            let last = tridiagonal.last_rows(few, &some);
            let expected = Mat::from_fn(few, some.len(), |i, j| y[(m - few + i, some[j])]);
            prop_assert!((last - expected).norm_max() < rounding);
        }
    }

    #[test]
    fn a_matrix_with_what_is_no_number_does_not_converge() {
        for m in [2, 5] {
            let mut h = Mat::<f64>::identity(m, m);
            h[(m - 1, 0)] = f64::NAN;
            let outcome = Tridiagonal::default().decompose(h.as_ref(), &mut Vec::new());
            assert!(matches!(outcome, Err(StageError::NoConvergence { n }) if n == m));
        }
    }
}
