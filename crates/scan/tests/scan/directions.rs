//! The direction in which a wall ends.

use crosscut_scan::{Directions, End, Position, Roughness, direction};
use proptest::prelude::{prop_assert, proptest};

use crate::{LENGTHS, scan};

proptest! {
    #[test]
    fn a_line_has_its_direction_at_any_spacing(
        beams in 90..2000usize, distance_m in 0.5..6.0f64, length_m in 3.0..20.0f64, turn_rad in -3.0..3.0f64,
    ) {
        let turned = nalgebra::Rotation2::new(turn_rad);
        let ends_m = [-length_m, length_m].map(|along_m| turned * Position::new(distance_m, along_m));
        let scan = scan(beams, &[ends_m.map(Into::into)]);
        let mut directions = Directions::default();
        directions.start(&scan.ring, &scan.roughness, LENGTHS.stretch_m);
        for piece in scan.pieces.iter().filter(|piece| piece.len() > 2) {
            for end in [End::First, End::Last] {
                let along = turned * Position::y();
                for stretch_m in [0.1, LENGTHS.stretch_m, 5.0] {
                    let found = direction(&scan.ring, &Roughness::default(), piece, end, stretch_m);
                    prop_assert!((found - along).norm() < 1e-6, "{found} instead of {along}");
                }
                if let Some(found) = directions.of(&scan.ring, &scan.roughness, piece, end) {
                    prop_assert!((found - along).norm() < 1e-6, "{found} instead of {along}");
                }
            }
        }
    }

    #[test]
    fn a_kept_direction_is_the_one_that_would_be_computed_again(
        beams in 90..1000usize, corner_m in -2.0..2.0f64, cuts in proptest::collection::vec(1..80usize, 1..6),
    ) {
        let scan = scan(beams, &[[[2.0, -9.0], [2.0, corner_m]], [[2.0, corner_m], [7.0, corner_m + 3.0]]]);
        let mut kept = Directions::default();
        kept.start(&scan.ring, &scan.roughness, LENGTHS.stretch_m);
        let all = scan.pieces.returns();
        for cut in cuts {
            let piece = &all[..cut.min(all.len())];
            for end in [End::First, End::Last] {
                let mut fresh = Directions::default();
                fresh.start(&scan.ring, &scan.roughness, LENGTHS.stretch_m);
                prop_assert!(kept.of(&scan.ring, &scan.roughness, piece, end) == fresh.of(&scan.ring, &scan.roughness, piece, end));
            }
        }
    }
}
