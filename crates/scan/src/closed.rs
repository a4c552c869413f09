//! Gaps that the returns themselves close.

use crate::ring::Ring;

/// Returns beyond each end of a gap that are looked at.
const RETURNS: usize = 8;

/// Whether no disc of this diameter can cross the gap between two returns that follow each other, anticlockwise: its
/// centre would have to cross the chord, and every point of that is nearer than half of the diameter to a return. What
/// is hidden does not matter.
pub fn is_closed_by_returns(ring: &Ring, [from, to]: [usize; 2], width_m: f64) -> bool {
    let start_m = ring.position_m(from);
    let chord = ring.position_m(to) - start_m;
    let (length_m, radius_m) = (chord.norm(), width_m / 2.0);
    if length_m == 0.0 {
        return true;
    }
    let beside =
        |end: usize, direction: isize| (0..RETURNS as isize).map_while(move |steps| ring.after(end, direction * steps));
    // The stretch of the chord that a return covers; NaN, so none, for one farther from it than the radius.
    let covered_m = |i: usize| {
        let offset_m = ring.position_m(i) - start_m;
        let (along_m, across_m) = (offset_m.dot(&chord) / length_m, offset_m.perp(&chord) / length_m);
        let half_m = (radius_m * radius_m - across_m * across_m).sqrt();
        (along_m - half_m, along_m + half_m)
    };
    let mut reached_m = 0.0;
    loop {
        let stretches_m = beside(from, -1).chain(beside(to, 1)).map(covered_m);
        let next_m =
            stretches_m.filter(|(start_m, _)| *start_m <= reached_m).map(|(_, end_m)| end_m).fold(0.0, f64::max);
        if next_m >= length_m {
            return true;
        }
        if next_m <= reached_m {
            return false;
        }
        reached_m = next_m;
    }
}

#[cfg(test)]
mod tests {
    use crosscut_stage::{Beam, Point, Sweep};
    use proptest::collection::vec;
    use proptest::prelude::{prop_assert, proptest};

    use super::*;
    use crate::ring::Position;

    /// A full turn of returns at these ranges.
    fn ring(ranges_m: &[f64]) -> Ring {
        let step_rad = std::f64::consts::TAU / ranges_m.len() as f64;
        let point = |(at, range_m): (usize, &f64)| {
            let (sin, cos) = (at as f64 * step_rad).sin_cos();
            Point::new(range_m * cos, range_m * sin, 0.0)
        };
        let points_m: Vec<Point> = ranges_m.iter().enumerate().map(point).collect();
        let beams = (0..ranges_m.len() as u32).map(Beam::Return).collect();
        let sweep = Sweep { beams, step_rad, full_turn: true, range_max_m: 20.0, ..Sweep::default() };
        let mut ring = Ring::default();
        ring.fill(&sweep, &points_m).expect("each beam has its return");
        ring
    }

    proptest! {
        #[test]
        fn a_closed_gap_has_no_place_for_the_disc(ranges_m in vec(0.5..4.0f64, 24), at in 0..24usize, width_m in 0.2..3.0f64) {
            let ring = ring(&ranges_m);
            let pair = [at, (at + 1) % 24];
            if is_closed_by_returns(&ring, pair, width_m) {
                let [from_m, to_m] = pair.map(|i| ring.position_m(i));
                for step in 0..=100 {
                    let centre_m: Position = from_m + (to_m - from_m) * (f64::from(step) / 100.0);
                    let nearest_m = (0..24).map(|i| (ring.position_m(i) - centre_m).norm()).fold(f64::INFINITY, f64::min);
                    prop_assert!(nearest_m <= width_m / 2.0 + 1e-9, "{nearest_m}");
                }
            }
        }
    }

    #[test]
    fn a_wall_close_behind_the_nearer_end_closes_a_gap() {
        // A wall 2 m away from beam 45 on, behind one 1.6 m away: a step of 0.4 m.
        let mut ranges_m = [2.0; 360];
        ranges_m[..45].fill(1.6);
        let stepped = ring(&ranges_m);
        assert!(is_closed_by_returns(&stepped, [44, 45], 0.5), "the step is narrower than the vehicle");
        assert!(!is_closed_by_returns(&stepped, [44, 45], 0.2), "a vehicle of half the step fits between");
        ranges_m[45..].fill(3.0);
        assert!(!is_closed_by_returns(&ring(&ranges_m), [44, 45], 0.5));
    }
}
