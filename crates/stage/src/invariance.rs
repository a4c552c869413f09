//! Changes of a revolution that an affinity does not see.

/// A change of the revolution that leaves W alone, up to the rounding of the changed points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Invariance {
    /// All points moved by the same vector.
    Translation,
    /// All points turned by the same rotation of R³.
    Rotation,
    /// All points turned about the sensor's z axis, with their beams.
    Turn,
    /// Left and right exchanged (y and the bearings negated), beams kept in order.
    Mirror,
    /// The returns in another order: W has its rows and columns in that order.
    Permutation,
}

impl Invariance {
    /// All invariances: those of an affinity that uses distances only.
    pub const ALL: &[Self] = &[Self::Translation, Self::Rotation, Self::Turn, Self::Mirror, Self::Permutation];
}
