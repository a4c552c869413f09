//! The edges of one wall that decide a count.

/// A weight of W between two returns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// Indices of the two returns, in either order.
    pub returns: [usize; 2],
    /// W_ij.
    pub weight: f64,
}

/// The edge that holds one wall together, and the edge that nearly joins it to another.
#[derive(Clone, Debug, PartialEq)]
pub struct WallEdges {
    /// The wall's number.
    pub wall: u32,
    /// The bottleneck of its maximum spanning tree; `None` if it has one return, or several parts.
    pub weakest: Option<Edge>,
    /// Number of parts of the wall between which W has no edge; normally 1.
    pub parts: usize,
    /// q of the two sides of the weakest edge: approximately the eigenvalue of breaking the wall there.
    pub breaks_at: f64,
    /// The strongest edge to another wall, after the number of that wall; `None` if W has none.
    pub strongest: Option<(u32, Edge)>,
    /// q of this wall and all other walls: approximately the eigenvalue of keeping it apart.
    pub parts_at: f64,
}
