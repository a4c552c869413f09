//! What is measured at a gap: doorways, and whether it lies across the line of sight.

use crosscut_scan::{Doorway, Position, Scan, lies_across};
use proptest::prelude::{prop_assert, proptest};

use crate::scan;

/// The last return of a scan on the wall x = 2 below y = `edge_m`, and the next one.
fn ends(scan: &Scan, edge_m: f64) -> [usize; 2] {
    let on_wall = |i: &usize| {
        let position_m = scan.ring.position_m(*i);
        (position_m.x - 2.0).abs() < 1e-6 && position_m.y <= edge_m + 1e-6
    };
    let near = (0..scan.ring.len())
        .filter(on_wall)
        .max_by(|&a, &b| scan.ring.position_m(a).y.total_cmp(&scan.ring.position_m(b).y));
    let near = near.expect("the wall is seen");
    [near, (near + 1) % scan.ring.len()]
}

proptest! {
    #[test]
    fn a_doorway_has_its_width_and_its_depth(
        beams in 500..2000usize, edge_m in -1.2..0.2f64, width_m in 0.8..2.0f64, behind_m in 1.0..5.0f64, mirrored: bool,
    ) {
        let sign = if mirrored { -1.0 } else { 1.0 };
        let walls = [
            [[2.0, -9.0], [2.0, edge_m]], [[2.0, edge_m + width_m], [2.0, 9.0]],
            [[2.0 + behind_m, -40.0], [2.0 + behind_m, 40.0]],
        ];
        let scan = scan(beams, &walls.map(|wall| wall.map(|[x, y]| [x, sign * y])));
        let [near, far] = if mirrored {
            // The same gap in the mirror, in which clockwise is anticlockwise.
            let n = scan.ring.len();
            let seen = |i: usize| { let m = scan.ring.position_m(i); ((m.x - 2.0).abs() < 1e-6, -m.y) };
            let near = (0..n).filter(|&i| seen(i).0 && seen(i).1 <= edge_m + 1e-6);
            let near = near.max_by(|&a, &b| seen(a).1.total_cmp(&seen(b).1)).expect("the wall is seen");
            [near, (near + n - 1) % n]
        } else {
            ends(&scan, edge_m)
        };
        let door = Doorway::beside(&scan.ring, [near, far], !mirrored, Position::new(0.0, sign), 0.6);
        let door = door.expect("the other side is within reach");
        prop_assert!((door.width_m - width_m).abs() < 0.1, "{door:?} instead of {width_m} m");
        prop_assert!((door.behind_m - behind_m).abs() < 1e-6, "{door:?} instead of {behind_m} m");
    }
}

#[test]
fn dust_in_front_of_what_a_doorway_shows_is_not_its_other_side() {
    let door = [[[2.0, -9.0], [2.0, -1.0]], [[2.0, 1.0], [2.0, 9.0]], [[6.0, -40.0], [6.0, 40.0]]];
    // One beam meets it, well behind the line of the door.
    let dust = [[2.9, 0.0], [2.9, 0.025]];
    let scan = scan(720, &[&door[..], &[dust]].concat());
    let near_dust = (0..scan.ring.len()).filter(|&i| (scan.ring.position_m(i).x - 2.9).abs() < 1e-6).count();
    assert_eq!(near_dust, 1);
    let doorway = Doorway::beside(&scan.ring, ends(&scan, -1.0), true, Position::new(0.0, 1.0), 0.6);
    let width_m = doorway.expect("its other side is seen").width_m;
    assert!((width_m - 2.0).abs() < 0.1, "{width_m} m");
}

#[test]
fn a_gap_ahead_lies_across_and_one_along_a_wall_does_not() {
    let walls = [[[2.0, -9.0], [2.0, -0.5]], [[2.0, 0.5], [2.0, 6.0]], [[2.0, 7.0], [2.0, 12.0]]];
    let scan = scan(720, &walls);
    assert!(lies_across(&scan.ring, ends(&scan, -0.5)));
    assert!(!lies_across(&scan.ring, ends(&scan, 6.0)));
}
