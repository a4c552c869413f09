//! Returns that are of no wall: dust, mixed ones beside pillars, the vehicle's own.

use proptest::collection::vec;
use proptest::prelude::{prop_assert_eq, proptest};

use crate::{LENGTHS, range_m, room, scan_of};

const BEAMS: usize = 360;

proptest! {
    #[test]
    fn dust_is_in_the_air_and_nothing_else_is(ranges_m in vec(0.5..2.0f64, 1..30), first in 0..BEAMS, half_m in 2.5..6.0f64) {
        let walls = room(half_m);
        // One dust return each 12 beams.
        let dust = |beam: usize| {
            let after = (beam + BEAMS - first) % BEAMS;
            if after.is_multiple_of(12) { ranges_m.get(after / 12) } else { None }
        };
        let scan = scan_of(BEAMS, |beam, bearing_rad| dust(beam).copied().unwrap_or_else(|| range_m(&walls, bearing_rad)));
        let dust_returns: Vec<usize> = (0..BEAMS).filter(|beam| !scan.pieces.returns().contains(beam)).collect();
        let expected: Vec<usize> = (0..BEAMS).filter(|&beam| dust(beam).is_some()).collect();
        prop_assert_eq!(scan.dust_returns, expected.len());
        prop_assert_eq!(dust_returns, expected);
    }

    #[test]
    fn a_mixed_return_beside_a_pillar_is_in_the_air_and_the_pillar_an_island(
        at in 20..BEAMS - 60, width in 12..30usize, share in 0.3..0.7f64, is_before: bool,
    ) {
        let walls = room(4.0);
        let pillar = at..at + width;
        let mixed = if is_before { at - 1 } else { at + width };
        let scan = scan_of(BEAMS, |beam, bearing_rad| {
            let wall_m = range_m(&walls, bearing_rad);
            if pillar.contains(&beam) { 1.5 } else if beam == mixed { 1.5 + share * (wall_m - 1.5) } else { wall_m }
        });
        prop_assert_eq!(scan.dust_returns, 1);
        prop_assert_eq!(scan.islands.pieces.returns(), pillar.collect::<Vec<_>>());
    }

    #[test]
    fn what_is_within_the_vehicle_is_its_own_unless_a_wall_goes_on_there(
        at in 0..BEAMS, width in 1..60usize, range_m in 0.05..0.299f64,
    ) {
        let is_part = |beam: usize| (beam + BEAMS - at) % BEAMS < width;
        let scan = scan_of(BEAMS, |beam, _| if is_part(beam) { range_m } else { 3.0 });
        prop_assert_eq!(scan.self_returns + scan.dust_returns, width);
        prop_assert_eq!(scan.pieces.returns().len(), BEAMS - width);
    }

    #[test]
    fn a_wall_that_the_vehicle_touches_is_a_wall(distance_m in 0.1..0.29f64) {
        let wall = [[[distance_m, -8.0], [distance_m, 8.0]]];
        let scan = scan_of(720, |_, bearing_rad| range_m(&wall, bearing_rad));
        prop_assert_eq!(scan.self_returns, 0, "{}", LENGTHS.passage_m);
    }
}
