//! What is computed of the Laplacian: the smallest eigenvalues, how many are zero, and their eigenvectors.

use faer::Mat;

/// Eigenvalues of L = I - D^-1/2 W D^-1/2 and the embedding made of the eigenvectors of its zeros. A solver that leaves weak
/// edges out (`components`) gives those of the graph without them.
#[derive(Clone, Debug)]
pub struct Spectrum {
    /// λ ascending: the smallest that were computed, at least the k zeros, and the next if there is a margin (and a
    /// next).
    pub eigenvalues: Vec<f64>,
    /// τ: eigenvalues below it count as zero.
    pub tolerance: f64,
    /// k, the number of eigenvalues below τ.
    pub k: usize,
    /// How far, in decades, τ could be moved before k changes; `None` if no eigenvalue is known but exact zeros.
    pub margin_decades: Option<f64>,
    /// U, n×k: an orthonormal basis of what the eigenvectors of the k zeros span. Column j is the unit eigenvector of
    /// λ_j in a full decomposition; with a repeated eigenvalue only the span is defined.
    pub u: Mat<f64>,
}

impl Default for Spectrum {
    fn default() -> Self {
        Self { eigenvalues: Vec::new(), tolerance: 0.0, k: 0, margin_decades: None, u: Mat::new() }
    }
}

impl Spectrum {
    /// The margin of a zero count by a tolerance, in decades:
    /// min(log10(τ / max(λ_k, n·2.2e-16)), log10(λ_k+1 / τ)), a missing side skipped, `None` at n = 0.
    ///
    /// `eigenvalues` ascend and hold at least the k zeros and, if k < n, the next.
    pub fn tolerance_margin_decades(eigenvalues: &[f64], n: usize, k: usize, tolerance: f64) -> Option<f64> {
        let floor = n as f64 * f64::EPSILON;
        let below = k.checked_sub(1).map(|last| (tolerance / eigenvalues[last].max(floor)).log10());
        let above = eigenvalues.get(k).map(|next| (next / tolerance).log10());
        match (below, above) {
            (Some(below), Some(above)) => Some(below.min(above)),
            (below, above) => below.or(above),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn margin_is_the_nearer_side_and_missing_sides_are_skipped() {
        let margin =
            |eigenvalues: &[f64], k| Spectrum::tolerance_margin_decades(eigenvalues, eigenvalues.len(), k, 1e-8);
        assert_eq!(margin(&[], 0), None);
        assert!((margin(&[0.0, 1e-10, 1e-2], 2).expect("both sides") - 2.0).abs() < 1e-12, "the zero side is nearer");
        assert!((margin(&[0.0, 1e-10, 1e-7], 2).expect("both sides") - 1.0).abs() < 1e-12, "the next one is nearer");
        assert!((margin(&[1e-9], 1).expect("no next") - 1.0).abs() < 1e-12);
        assert!((margin(&[1e-5], 0).expect("no zero") - 3.0).abs() < 1e-12);
    }
}
