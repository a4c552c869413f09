//! Which eigenvalues count as zero.

use crosscut_stage::{Number, Spectrum};

/// τ. The paper gives none; how far τ could be moved before k changes is the margin.
pub const ZERO_TOLERANCE: Number = Number::new("zero_tolerance", "", 1e-7)
    .from(1e-14)
    .to(2.0)
    .follows("affinity.leak")
    .doc("τ: eigenvalues of the Laplacian below it count as zero; at least 1e-14, as smaller ones are rounding");

/// Sets τ, k and the margin of a spectrum of n eigenvalues, of which all zeros are known, and the next, ascending.
pub(crate) fn count_zeros(spectrum: &mut Spectrum, n: usize, tolerance: f64) {
    spectrum.tolerance = tolerance;
    let below = spectrum.eigenvalues.partition_point(|&eigenvalue| eigenvalue < tolerance);
    // The first is 0, even if rounding has lifted it above τ.
    spectrum.k = below.max(spectrum.eigenvalues.len().min(1));
    spectrum.margin_decades = Spectrum::tolerance_margin_decades(&spectrum.eigenvalues, n, spectrum.k, tolerance);
}

/// Sets k, the margin and U of a full decomposition, of which U has the eigenvectors of the smallest eigenvalues, to those
/// of this τ. `false` if it counts more zeros than U has eigenvectors; the spectrum is then of no use.
#[must_use]
pub fn recount(spectrum: &mut Spectrum, tolerance: f64) -> bool {
    let n = spectrum.eigenvalues.len();
    count_zeros(spectrum, n, tolerance);
    let is_enough = spectrum.k <= spectrum.u.ncols();
    spectrum.u.truncate(n, spectrum.k.min(spectrum.u.ncols()));
    is_enough
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_eigenvalue_is_zero_whatever_rounding_made_of_it() {
        let k = |eigenvalues: &[f64]| {
            let mut spectrum = Spectrum { eigenvalues: eigenvalues.to_vec(), ..Spectrum::default() };
            count_zeros(&mut spectrum, eigenvalues.len(), 1e-14);
            spectrum.k
        };
        assert_eq!((k(&[2e-14, 1.0]), k(&[1e-15, 1e-15, 1.0]), k(&[])), (1, 2, 0));
    }
}
