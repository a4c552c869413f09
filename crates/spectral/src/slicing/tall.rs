//! aᵀ x of tall matrices with a few columns, by the vector instructions that the processor has: a general product of so
//! little takes as long to be set up as to be done.

use std::array::from_fn;

use faer::traits::pulp::{Arch, Simd, WithSimd};
use faer::{MatMut, MatRef};

/// Columns of a, and of x, that are worked on together.
const OF_A: usize = 2;
const OF_X: usize = 4;

/// out += factor·aᵀ x, of n×m and n×few to m×few; the columns of a and x are contiguous.
pub(super) fn add_transposed(out: MatMut<'_, f64>, factor: f64, a: MatRef<'_, f64>, x: MatRef<'_, f64>) {
    Arch::new().dispatch(AddTransposed { out, factor, a, x });
}

struct AddTransposed<'a> {
    out: MatMut<'a, f64>,
    factor: f64,
    a: MatRef<'a, f64>,
    x: MatRef<'a, f64>,
}

impl WithSimd for AddTransposed<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let few = self.x.ncols();
        let together = few / OF_X * OF_X;
        (0..together).step_by(OF_X).for_each(|c| self.columns::<S, OF_X>(simd, c));
        (together..few).for_each(|c| self.columns::<S, 1>(simd, c));
    }
}

impl AddTransposed<'_> {
    /// Columns `c..c + C`.
    #[inline(always)]
    fn columns<S: Simd, const C: usize>(&mut self, simd: S, c: usize) {
        let m = self.a.ncols();
        let together = m / OF_A * OF_A;
        (0..together).step_by(OF_A).for_each(|row| self.block::<S, OF_A, C>(simd, row, c));
        (together..m).for_each(|row| self.block::<S, 1, C>(simd, row, c));
    }

    /// Rows `row..row + R` of them.
    #[inline(always)]
    fn block<S: Simd, const R: usize, const C: usize>(&mut self, simd: S, row: usize, c: usize) {
        let a: [_; R] = from_fn(|r| S::as_simd_f64s(contiguous(self.a, row + r)));
        let x: [_; C] = from_fn(|j| S::as_simd_f64s(contiguous(self.x, c + j)));
        let mut sums = [[simd.splat_f64s(0.0); C]; R];
        let mut add = |a: [S::f64s; R], x: [S::f64s; C]| {
            for (sums, a) in sums.iter_mut().zip(a) {
                for (sum, x) in sums.iter_mut().zip(x) {
                    *sum = simd.mul_add_e_f64s(a, x, *sum);
                }
            }
        };
        for i in 0..a[0].0.len() {
            add(a.map(|(whole, _)| whole[i]), x.map(|(whole, _)| whole[i]));
        }
        // What is left of the columns; nothing is 0.
        add(a.map(|(_, rest)| simd.partial_load_f64s(rest)), x.map(|(_, rest)| simd.partial_load_f64s(rest)));
        for (r, sums) in sums.into_iter().enumerate() {
            for (j, sum) in sums.into_iter().enumerate() {
                self.out[(row + r, c + j)] += self.factor * simd.reduce_sum_f64s(sum);
            }
        }
    }
}

#[inline(always)]
fn contiguous(matrix: MatRef<'_, f64>, j: usize) -> &[f64] {
    matrix.col(j).try_as_col_major().expect("columns are contiguous").as_slice()
}

#[cfg(test)]
mod tests {
    use faer::Mat;

    use super::*;

    #[test]
    fn products_of_every_shape_are_those_of_the_library() {
        for n in 0..11 {
            for (m, few) in (0..6).flat_map(|m| (0..7).map(move |few| (m, few))) {
                let a = Mat::from_fn(n, m, |i, j| (1.0 + i as f64 + 3.0 * j as f64).sin());
                let x = Mat::from_fn(n, few, |i, j| (2.0 + 5.0 * i as f64 - j as f64).cos());
                let mut out = Mat::from_fn(m, few, |i, j| i as f64 - j as f64);
                let expected = &out - 2.0 * (a.transpose() * &x);
                add_transposed(out.as_mut(), -2.0, a.as_ref(), x.as_ref());
                assert!((out - expected).norm_max() < 1e-13, "{n} rows, {m} and {few} columns");
            }
        }
    }
}
