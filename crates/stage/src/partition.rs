//! Which cluster each return belongs to.

use faer::Mat;

/// The returns split into clusters, numbered by their first return in message beam order.
#[derive(Clone, Debug)]
pub struct Partition {
    /// Number of clusters; may be smaller than k when rows of U coincide.
    pub clusters: usize,
    /// Cluster of each return, n entries; `None` for a return that was left out.
    pub labels: Vec<Option<u32>>,
    /// Centre of each cluster in the space of U, clusters×k.
    pub centroids: Mat<f64>,
    /// f(C, U) = Σ_i min_c ‖u_i - c‖², the objective that k-means minimises.
    pub inertia: f64,
}

impl Default for Partition {
    fn default() -> Self {
        Self { clusters: 0, labels: Vec::new(), centroids: Mat::new(), inertia: 0.0 }
    }
}
