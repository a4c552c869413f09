//! `rbf` against equation (1), worked by hand and written the plain way.

use crosscut_affinity::rbf::KIND;
use crosscut_stage::{Affinity, Notes, Point, Revolution, Weights};

fn rbf(sigma_per_m2: f64, points_m: &[Point]) -> Affinity {
    let revolution = Revolution { points_m: points_m.to_vec(), ..Revolution::default() };
    let mut out = Affinity::default();
    let mut stage = KIND.with(&[("sigma_per_m2", sigma_per_m2.into())]).expect("a positive σ");
    stage.affinity(&revolution, &mut out, &mut Notes::default()).expect("finite points");
    out
}

#[test]
fn w_and_d_are_those_computed_by_hand() {
    // Squared distances: 1 between the first two, 4 + 4 to the third.
    let affinity = rbf(0.5, &[Point::new(0.0, 0.0, 0.0), Point::new(0.0, 1.0, 0.0), Point::new(2.0, 1.0, -2.0)]);
    let Weights::Dense(w) = &affinity.weights else { panic!("rbf is dense") };
    let (near, far, farther) = (0.606_530_659_712_633_4, 0.018_315_638_888_734_18, 0.011_108_996_538_242_306);
    for (i, j, expected) in [(0, 1, near), (1, 2, far), (0, 2, farther)] {
        assert!((w[(i, j)] - expected).abs() < 1e-16, "W[{i}, {j}] = {}", w[(i, j)]);
    }
    for (degree, expected) in affinity.degrees.iter().zip([1.0 + near + farther, 1.0 + near + far, 1.0 + far + farther])
    {
        assert!((degree - expected).abs() < 1e-15);
    }
}

#[test]
fn points_too_far_apart_for_any_similarity_have_none_and_no_error() {
    let affinity = rbf(1.5, &[Point::new(-1e300, 0.0, 0.0), Point::new(1e300, 0.0, 0.0)]);
    assert_eq!(affinity.degrees, [1.0, 1.0]);
}

#[test]
fn a_sigma_out_of_range_is_refused_in_words() {
    for sigma in [0.0, -1.5, f64::NAN, f64::INFINITY] {
        let refused = KIND.with(&[("sigma_per_m2", sigma.into())]).err().expect("must be refused").to_string();
        assert!(refused.starts_with("sigma_per_m2 = ") && refused.contains("a number in (0.0, "), "{refused}");
    }
}
