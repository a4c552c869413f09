//! The partition of a spectrum without zeros, or without returns.

use crosscut_stage::NoteCode::N073;
use crosscut_stage::{Notes, Partition};

/// No return of n has a cluster; said in a note if there are any.
pub(crate) fn without_clusters(n: usize, k: usize, out: &mut Partition, notes: &mut Notes) {
    if n > 0 {
        notes.add(N073, "no eigenvalue counts as zero, so no return has a cluster");
    }
    (out.clusters, out.inertia) = (0, 0.0);
    out.labels.clear();
    out.labels.resize(n, None);
    out.centroids.resize_with(0, k, |_, _| 0.0);
}
