//! Pieces that stand free in front of others.

use proptest::prelude::{prop_assert, prop_assert_eq, proptest};

use crate::{room, scan};

proptest! {
    #[test]
    fn a_pillar_away_from_all_walls_is_an_island_at_any_spacing(
        beams in 180..1400usize, x_m in 1.0..2.5f64, turn in 0..4u8, half_m in 0.2..0.9f64,
    ) {
        let mut walls = room(6.0);
        let quarter = |[x, y]: [f64; 2]| match turn { 0 => [x, y], 1 => [-y, x], 2 => [-x, -y], _ => [y, -x] };
        walls.push([quarter([x_m, -half_m]), quarter([x_m, half_m])]);
        let scan = scan(beams, &walls);
        prop_assert_eq!(scan.islands.pieces.len(), 1);
        let on_pillar = |&i: &usize| scan.ring.range_m(i) < 3.0;
        prop_assert!(scan.islands.pieces.returns().iter().all(on_pillar));
        prop_assert!(!scan.pieces.returns().iter().any(on_pillar), "all of it");
    }

    #[test]
    fn a_long_piece_is_no_island(beams in 180..1400usize, x_m in 1.0..2.5f64, half_m in 1.05..2.0f64) {
        let mut walls = room(6.0);
        walls.push([[x_m, -half_m], [x_m, half_m]]);
        prop_assert!(scan(beams, &walls).islands.pieces.is_empty());
    }

    #[test]
    fn a_piece_nearer_to_a_wall_than_a_vehicle_passes_is_no_island(
        beams in 180..1400usize, half_m in 0.2..0.9f64, before_m in 0.05..0.45f64,
    ) {
        let mut walls = room(6.0);
        walls.push([[6.0 - before_m, -half_m], [6.0 - before_m, half_m]]);
        prop_assert!(scan(beams, &walls).islands.pieces.is_empty());
    }
}
