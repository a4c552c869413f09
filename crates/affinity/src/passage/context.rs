//! The scan that a gap is in, and the lengths by which it is divided.

use crosscut_scan::{Lengths, LostBeams, Scan};

/// A scan and the lengths by which it is divided.
#[derive(Clone, Copy, Debug)]
pub(super) struct ScanContext<'s> {
    pub(super) scan: &'s Scan,
    pub(super) lengths: Lengths,
    /// The beams that are lost within walls.
    pub(super) lost: LostBeams,
}

impl ScanContext<'_> {
    /// Whether two neighbouring returns are so far apart that a vehicle could pass between them.
    #[inline]
    pub(super) fn is_gap(&self, p: usize, q: usize) -> bool {
        self.scan.ring.are_apart(p, q, self.lengths.passage_m)
    }

    /// The width of a passage: the width of the vehicle.
    pub(super) fn passage_m(&self) -> f64 {
        self.lengths.passage_m
    }

    /// A length and a number of times the roughness of the walls: what bumps of smooth and of rough walls make
    /// together.
    pub(super) fn with_bumps_m(&self, length_m: f64, bumps: f64) -> f64 {
        length_m + bumps * self.scan.roughness.sd_m
    }
}
