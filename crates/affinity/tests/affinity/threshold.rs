//! `threshold` on distances known by heart.

use crosscut_affinity::threshold;
use crosscut_stage::{Affinity, Notes, Point, Revolution, Weights};

#[test]
fn edges_are_between_returns_within_the_radius_which_is_itself_within() {
    // 3-4-5 triangle, and one return far off.
    let points_m = [[0.0, 0.0], [3.0, 0.0], [3.0, 4.0], [90.0, 0.0]].map(|[x, y]| Point::new(x, y, 0.0));
    let revolution = Revolution { points_m: points_m.to_vec(), ..Revolution::default() };
    for (radius_m, rows) in [
        (2.9, [&[0u32][..], &[1], &[2], &[3]]),
        (4.0, [&[0, 1], &[0, 1, 2], &[1, 2], &[3]]),
        (5.0, [&[0, 1, 2], &[0, 1, 2], &[0, 1, 2], &[3]]),
    ] {
        let mut out = Affinity::default();
        let mut stage = threshold::KIND.with(&[("radius_m", radius_m.into())]).expect("a positive radius");
        stage.affinity(&revolution, &mut out, &mut Notes::default()).expect("finite points");
        let Weights::Sparse(w) = &out.weights else { panic!("threshold is sparse") };
        for (i, row) in rows.into_iter().enumerate() {
            assert_eq!(w.row(i), (row, &vec![1.0; row.len()][..]), "row {i} at {radius_m} m");
        }
    }
}

#[test]
fn a_radius_out_of_range_is_refused() {
    for radius_m in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(threshold::KIND.with(&[("radius_m", radius_m.into())]).is_err(), "{radius_m}");
    }
}
