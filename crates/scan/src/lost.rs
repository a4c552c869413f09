//! Beams that come back with nothing where there is a wall: how many the lidar loses, beside which a gap without returns
//! is judged.

use crate::ring::Ring;

/// Beams lost in a row over less than this angle show nothing: a dense lidar loses a few anywhere.
const LOST_RAD: f64 = std::f64::consts::PI / 180.0;
/// Walls that lose several beams in a row at more places than this lose them anywhere.
const LOSSY_PLACES: u32 = 1;
/// Beams came back with nothing because there is nothing, if they are more than this many times those that are lost in
/// a row along the walls.
const LOST_TIMES: u32 = 2;

/// Beams that come back with nothing along walls.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LostBeams {
    /// The most in a row.
    pub in_a_row: u32,
    /// At how many places there are several in a row.
    pub places: u32,
}

impl LostBeams {
    /// Counts a place of a wall where this many beams in a row came back with nothing.
    #[inline]
    pub fn count(&mut self, ring: &Ring, beams: u32) {
        self.in_a_row = self.in_a_row.max(beams);
        let is_wide = f64::from(beams) * ring.step_rad >= LOST_RAD;
        self.places += u32::from(beams > 1 && is_wide);
    }

    /// Whether this many beams in a row may be lost ones.
    #[inline]
    pub fn explain(&self, beams: u32) -> bool {
        beams <= LOST_TIMES * self.in_a_row
    }

    /// Whether beams are lost at so many places that a gap without returns is no door.
    #[inline]
    pub fn are_anywhere(&self) -> bool {
        self.places > LOSSY_PLACES
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::collection::vec;
    use proptest::prelude::{prop_assert, prop_assert_eq, proptest};

    fn ring(step_rad: f64) -> Ring {
        let mut ring = Ring::default();
        ring.step_rad = step_rad;
        ring
    }

    proptest! {
        #[test]
        fn lost_beams_do_not_depend_on_the_order_and_more_explain_more(
            mut counts in vec(0..40u32, 1..30), beams in 90..4000usize, more in 1..40u32, asked in 0..200u32,
        ) {
            let ring = ring(std::f64::consts::TAU / beams as f64);
            let all = |counts: &[u32]| {
                let mut lost = LostBeams::default();
                counts.iter().for_each(|&count| lost.count(&ring, count));
                lost
            };
            let lost = all(&counts);
            counts.reverse();
            prop_assert_eq!(all(&counts), lost);
            counts.push(more);
            let with_more = all(&counts);
            prop_assert!(with_more.explain(asked) || !lost.explain(asked));
            prop_assert!(with_more.are_anywhere() || !lost.are_anywhere());
            prop_assert!(with_more.explain(more), "what is lost somewhere may be lost elsewhere");
        }
    }

    #[test]
    fn one_lost_beam_and_a_narrow_row_are_no_place() {
        let dense = ring(0.1f64.to_radians());
        let sparse = ring(2f64.to_radians());
        let places = |ring: &Ring, beams: u32| {
            let mut lost = LostBeams::default();
            lost.count(ring, beams);
            lost.places
        };
        assert_eq!([places(&sparse, 1), places(&sparse, 2)], [0, 1]);
        assert_eq!([places(&dense, 9), places(&dense, 11)], [0, 1]);
    }
}
