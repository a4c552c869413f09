//! The second eigenvalue of a block, and its eigenvector: the Fiedler pair.

use super::band::Band;
use crate::dot::dot;

/// The shift of the first step: L itself is singular.
const FIRST_SHIFT: f64 = -1e-9;
/// The largest distance of the two bounds, relative to the eigenvalue.
const PROVED: f64 = 1e-2;
/// The largest error of the upper bound by its residual, for each return.
const ROUNDING: f64 = 10.0 * f64::EPSILON;
/// The largest number of factorisations. Halving alone takes 2 to 2e-14 in 47.
const MOST_STEPS: usize = 100;
/// The share of noise in the start vector, in case the rest is orthogonal to the eigenvector.
const NOISE: f64 = 1e-2;

/// Finds the Fiedler pair; holds its buffers.
#[derive(Clone, Debug, Default)]
pub(crate) struct Fiedler {
    /// A unit vector, orthogonal to that of the first eigenvalue.
    vector: Vec<f64>,
    solution: Vec<f64>,
}

/// An eigenvalue between two numbers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Between {
    /// By the pivots at this shift.
    pub(crate) lower: f64,
    /// A Rayleigh quotient: the eigenvalue itself, up to rounding.
    pub(crate) upper: f64,
}

/// The Rayleigh quotient of a vector, and how far it may be from the eigenvalue.
struct Estimate {
    quotient: f64,
    error: f64,
}

impl Fiedler {
    /// The second eigenvalue λ of a block whose first is 0, with the unit eigenvector `zero`.
    ///
    /// Inverse iteration, orthogonal to `zero`. The Rayleigh quotient of the vector is at least λ, and λ is above every
    /// shift that has no more than one negative pivot (Sylvester). So both bound λ, whatever the vector converges to,
    /// and with shifts just below λ both approach it, as fast as Rayleigh quotient iteration does; where a shift turns
    /// out to be above λ, the next one halves what is between. Both are returned once the upper one has converged
    /// and two digits of it are proved, or once the two differ by rounding alone; `None` if they do not come that near.
    pub(crate) fn find(&mut self, matrix: &mut Band, zero: &[f64]) -> Option<Between> {
        self.start(zero);
        let rounding = ROUNDING * zero.len() as f64;
        let (mut below, mut above) = (FIRST_SHIFT, f64::INFINITY);
        matrix.solve(below, &mut self.solution);
        let mut estimate = self.step(zero, below);
        for _ in 0..MOST_STEPS {
            let upper = estimate.quotient.min(above);
            let is_of_lambda = estimate.quotient <= above;
            let converged = is_of_lambda && estimate.error <= rounding && upper - below <= PROVED * upper;
            if converged || upper - below <= 2.0 * rounding {
                return Some(Between { lower: below, upper });
            }
            let guess = upper - 2.0 * estimate.error - rounding;
            let shift = if is_of_lambda && guess > below { guess } else { 0.5 * (below + upper) };
            self.solution.clone_from(&self.vector);
            if matrix.solve(shift, &mut self.solution) > 1 {
                above = shift;
            } else {
                below = shift;
                estimate = self.step(zero, shift);
            }
        }
        None
    }

    /// Along a wall of even weights the eigenvector is D^1/2 times half a wave of a cosine: nearly a cubic that is flat
    /// at both ends.
    fn start(&mut self, zero: &[f64]) {
        let middle = 0.5 * zero.len() as f64;
        let mut state = 0x9E37_79B9_u32;
        self.vector.clear();
        self.vector.extend(zero.iter().enumerate().map(|(at, zero)| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let noise = f64::from(state) / f64::from(u32::MAX) - 0.5;
            let place = (at as f64 + 0.5) / middle - 1.0;
            zero * (0.5 * place * (3.0 - place * place) + NOISE * noise)
        }));
        make_orthogonal(&mut self.vector, zero);
        let norm = dot(&self.vector, &self.vector).sqrt();
        self.vector.iter_mut().for_each(|x| *x /= norm);
        self.solution.clone_from(&self.vector);
    }

    /// One step of inverse iteration: `solution`, y = (L - shift·I)⁻¹ x, is made orthogonal to `zero`. As
    /// (L - shift·I) y = x, the Rayleigh quotient of y is q = shift + xᵀy / yᵀy and its residual
    /// ‖Ly - qy‖² / yᵀy = xᵀx / yᵀy - (q - shift)². The error of q is at most residual² / (λ_3 - q) (Temple), where λ_3
    /// is taken to be 2q.
    fn step(&mut self, zero: &[f64], shift: f64) -> Estimate {
        make_orthogonal(&mut self.solution, zero);
        let square = dot(&self.solution, &self.solution);
        let above_shift = dot(&self.vector, &self.solution) / square;
        let scale = square.sqrt().recip();
        self.vector.iter_mut().zip(&self.solution).for_each(|(x, y)| *x = scale * y);
        let quotient = shift + above_shift;
        let residual_squared = (square.recip() - above_shift * above_shift).max(0.0);
        Estimate { quotient, error: residual_squared / quotient.abs() }
    }
}

fn make_orthogonal(vector: &mut [f64], unit: &[f64]) {
    let along = dot(vector, unit);
    vector.iter_mut().zip(unit).for_each(|(x, unit)| *x -= along * unit);
}
