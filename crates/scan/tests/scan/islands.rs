//! Pieces that stand free in front of others.

use std::f64::consts::PI;

use crosscut_scan::WIDEST_RAD;
use proptest::prelude::{prop_assert, prop_assert_eq, proptest};

use crate::{room, scan, scan_of};

/// A wall 4 m long, 1 m to the right of the sensor, and clusters: each by its bearing, its range and half of its width, in
/// radians and metres. Nothing else is in range.
fn clusters_in_dark(beams: usize, clusters: &[[f64; 3]]) -> crosscut_scan::Scan {
    let wall = [[[2.0, -1.0], [-2.0, -1.0]]];
    scan_of(beams, |_, bearing_rad| {
        let on = |&&[at_rad, range_m, half_m]: &&[f64; 3]| (bearing_rad - at_rad).abs() < half_m / range_m;
        let cluster_m = clusters.iter().find(on).map_or(f64::INFINITY, |[_, range_m, _]| *range_m);
        crate::range_m(&wall, bearing_rad).min(cluster_m)
    })
}

proptest! {
    #[test]
    fn a_pillar_away_from_all_walls_is_an_island_at_any_spacing(
        beams in 180..1400usize, x_m in 1.0..2.5f64, turn in 0..4u8, half_share in 0.2..0.36f64,
    ) {
        let half_m = half_share * x_m; // seen over 23 to 40°
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
        // The last beam that meets it may do so a spacing before its end: it is seen over twice `half_m` at least.
        let spacing_m = (x_m + half_m * half_m / x_m) * (2.0 * PI / beams as f64);
        let half_m = half_m + spacing_m;
        walls.push([[x_m, -half_m], [x_m, half_m]]);
        prop_assert!(scan(beams, &walls).islands.pieces.is_empty());
    }

    #[test]
    fn a_piece_that_spans_much_of_the_view_is_no_island(
        beams in 180..1400usize, x_m in 0.3..1.5f64, more in 1.1..1.5f64,
    ) {
        let half_m = (WIDEST_RAD / 2.0).tan() * x_m * more; // below 1.0 of `island_m` for most
        let mut walls = room(6.0);
        walls.push([[x_m, -half_m], [x_m, half_m]]);
        prop_assert!(scan(beams, &walls).islands.pieces.is_empty());
    }

    #[test]
    fn small_clusters_with_nothing_around_them_are_islands(
        beams in 360..1400usize, at_rad in 0.3..1.0f64, range_m in 1.0..4.0f64, half_m in 0.06..0.25f64,
    ) {
        let scan = clusters_in_dark(beams, &[[at_rad, range_m, half_m], [PI - at_rad, range_m, half_m]]);
        let seen = (2.0 * half_m / range_m / scan.ring.step_rad) as usize;
        let expected = if seen < 4 { None } else { Some(2) };
        prop_assert!(expected.is_none_or(|count| scan.islands.pieces.len() == count), "{}", scan.islands.pieces.len());
    }

    #[test]
    fn what_is_wider_than_the_vehicle_is_no_island_for_the_dark_beside_it(
        beams in 360..1400usize, at_rad in 0.9..2.2f64, range_m in 2.5..4.0f64, half_m in 0.35..0.8f64,
    ) {
        prop_assert!(clusters_in_dark(beams, &[[at_rad, range_m, half_m]]).islands.pieces.is_empty());
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
