//! The scan that a gap is in, and the thresholds for its gaps.

use std::f64::consts::PI;

use crosscut_scan::{Directions, Lengths, LostBeams, Pieces, Scan};

use super::gap::Gap;
use super::verdict::DisabledRules;

/// A wall clearly continues across a gap where it turns by less than this.
const GOES_ON_RAD: f64 = 30.0 * PI / 180.0;
/// Where a wall clearly continues, neither end is off the line of the other piece by more than this share of the place's
/// size.
const GOES_ON_OFF_SHARE: f64 = 0.3;

/// The parameters of these names.
#[derive(Clone, Copy, Debug)]
pub(super) struct Thresholds {
    pub(super) lengths: Lengths,
    pub(super) straight_rad: f64,
    pub(super) way_rad: f64,
    pub(super) clear_share: f64,
    pub(super) disabled: DisabledRules,
}

/// A scan and the thresholds for its gaps.
#[derive(Clone, Copy, Debug)]
pub(super) struct ScanContext<'s> {
    pub(super) scan: &'s Scan,
    pub(super) thresholds: Thresholds,
    /// Where a wall clearly continues.
    pub(super) lost: LostBeams,
}

impl<'s> ScanContext<'s> {
    /// Counts the lost beams within the pieces of the scan and between them.
    pub(super) fn new(scan: &'s Scan, thresholds: Thresholds, directions: &mut Directions) -> Self {
        let none_lost = Self { scan, thresholds, lost: LostBeams::default() };
        Self { lost: none_lost.lost_beams(&scan.pieces, directions), ..none_lost }
    }

    fn lost_beams(&self, pieces: &Pieces, directions: &mut Directions) -> LostBeams {
        let (ring, mut lost) = (&self.scan.ring, LostBeams::default());
        for pair in pieces.iter().flat_map(|piece| piece.windows(2)) {
            lost.count(ring, ring.dark_between(pair[0], pair[1]));
        }
        let gaps = if ring.full_turn { pieces.len() } else { pieces.len().saturating_sub(1) };
        for at in 0..gaps {
            let (a, b) = (&pieces[at], &pieces[pieces.next(at)]);
            let beams = ring.dark_between(a[a.len() - 1], b[0]);
            if beams > 0 && self.clearly_goes_on(a, b, directions) {
                lost.count(ring, beams);
            }
        }
        lost
    }

    fn clearly_goes_on(&self, a: &[usize], b: &[usize], directions: &mut Directions) -> bool {
        let Some(gap) = Gap::between(self, a, b, directions) else { return false };
        let off_m = gap.clear_m.max(gap.depth_m.abs());
        off_m < GOES_ON_OFF_SHARE * self.scan.size_m && gap.turns.whole_rad < GOES_ON_RAD
    }

    /// Whether two neighbouring returns are so far apart that a vehicle could pass between them.
    #[inline]
    pub(super) fn is_gap(&self, p: usize, q: usize) -> bool {
        self.scan.ring.are_apart(p, q, self.thresholds.lengths.passage_m)
    }

    /// The width of a passage: the width of the vehicle.
    pub(super) fn passage_m(&self) -> f64 {
        self.thresholds.lengths.passage_m
    }

    /// A length and a number of times the roughness of the walls: what bumps of smooth and of rough walls make
    /// together.
    pub(super) fn with_bumps_m(&self, length_m: f64, bumps: f64) -> f64 {
        length_m + bumps * self.scan.roughness.sd_m
    }
}
