//! `breakpoint` on sweeps worked out by hand.

use std::f64::consts::TAU;

use crosscut_affinity::breakpoint::KIND;
use crosscut_stage::{Affinity, AffinityStage, Beam, Notes, Point, Revolution, StageError, Sweep, Weights};

/// A sweep with these ranges, `step_deg` apart from bearing 0 on; none is a beam without return.
fn sweep(ranges_m: &[Option<f64>], step_deg: f64, full_turn: bool) -> Revolution {
    let step_rad = step_deg.to_radians();
    let mut revolution = Revolution::default();
    let mut sweep = Sweep { step_rad, full_turn, range_max_m: 15.0, ..Sweep::default() };
    for (beam, range_m) in ranges_m.iter().enumerate() {
        let bearing_rad = crosscut_stage::wrap_angle_rad(beam as f64 * step_rad);
        sweep.bearings_rad.push(bearing_rad);
        sweep.beams.push(match range_m {
            Some(r) => {
                revolution.points_m.push(Point::new(r * bearing_rad.cos(), r * bearing_rad.sin(), 0.0));
                Beam::Return(revolution.points_m.len() as u32 - 1)
            }
            None => Beam::NoReturn,
        });
    }
    revolution.sweep = Some(sweep);
    revolution
}

/// λ = 10°, σ_r = 2 cm and up to two missing beams.
fn stage() -> Box<dyn AffinityStage> {
    let values = [("lambda_deg", 10.0.into()), ("range_noise_m", 0.02.into()), ("missing_beams", 2.into())];
    KIND.with(&values).expect("in range")
}

/// The edges i < j of `revolution`.
fn edges(revolution: &Revolution) -> Vec<(usize, usize)> {
    let mut out = Affinity::default();
    let mut stage = stage();
    stage.affinity(revolution, &mut out, &mut Notes::default()).expect("a sweep");
    assert!(matches!(out.weights, Weights::Sparse(_)));
    let mut edges = Vec::new();
    out.weights.for_each(|i, j, _| edges.extend((i < j).then_some((i, j))));
    edges
}

#[test]
fn a_range_may_jump_as_far_as_a_wall_met_at_lambda_would_make_it() {
    // 10 m sin 1° / sin 9° + 3 · 0.02 m = 1.1756 m between the returns: a range of 11.1610 m on the next beam.
    assert_eq!(edges(&sweep(&[Some(10.0), Some(11.160)], 1.0, false)), [(0, 1)]);
    assert_eq!(edges(&sweep(&[Some(10.0), Some(11.162)], 1.0, false)), []);
    // The same the other way round: the nearer range counts.
    assert_eq!(edges(&sweep(&[Some(11.160), Some(10.0)], 1.0, false)), [(0, 1)]);
    assert_eq!(edges(&sweep(&[Some(11.162), Some(10.0)], 1.0, false)), []);
}

#[test]
fn missing_beams_are_bridged_up_to_their_number_and_up_to_lambda() {
    let with_missing = |missing: usize, step_deg: f64| {
        let mut ranges_m = vec![None; missing];
        ranges_m.insert(0, Some(5.0));
        ranges_m.push(Some(5.0));
        edges(&sweep(&ranges_m, step_deg, false)).len()
    };
    assert_eq!([0, 1, 2, 3].map(|missing| with_missing(missing, 1.0)), [1, 1, 1, 0]);
    // Three steps of 3.4° are more than λ.
    assert_eq!([0, 1, 2].map(|missing| with_missing(missing, 3.4)), [1, 1, 0]);
}

#[test]
fn in_a_full_turn_the_last_return_is_a_neighbour_of_the_first() {
    let round = vec![Some(4.0); 60];
    let mut ring: Vec<_> = (0..59).map(|i| (i, i + 1)).collect();
    assert_eq!(edges(&sweep(&round, 6.0, false)), ring);
    ring.insert(1, (0, 59));
    assert_eq!(edges(&sweep(&round, 6.0, true)), ring);
    // Across the seam as anywhere else, beams may be missing, but not too many.
    let mut gap = vec![Some(4.0); 120];
    (gap[0], gap[119]) = (None, None);
    assert!(edges(&sweep(&gap, 3.0, true)).contains(&(0, 117)));
    gap[1] = None;
    assert!(!edges(&sweep(&gap, 3.0, true)).contains(&(0, 116)));
}

#[test]
fn beams_that_a_turn_is_short_of_are_missing_at_its_seam_as_anywhere_else() {
    for (missing, tied) in [(0, true), (2, true), (3, false)] {
        let mut short = sweep(&vec![Some(4.0); 120 - missing], 3.0, true);
        short.sweep.as_mut().expect("made above").missing = missing;
        assert_eq!(edges(&short).contains(&(0, 119 - missing)), tied, "{missing} beams");
    }
}

#[test]
fn two_returns_on_a_turn_of_two_beams_have_one_edge_at_most() {
    assert_eq!(edges(&sweep(&[Some(4.0), Some(4.0)], 180.0, true)), []);
    let (mut near, turn) = (sweep(&[Some(4.0), Some(4.0)], 5.0, true), TAU / 72.0);
    near.sweep.as_mut().expect("made above").step_rad = turn;
    assert_eq!(edges(&near), [(0, 1)]);
}

#[test]
fn a_cloud_without_beams_is_an_error_that_says_so() {
    let cloud = Revolution { points_m: vec![Point::origin(); 3], ..Revolution::default() };
    let mut stage = stage();
    let refused = stage.affinity(&cloud, &mut Affinity::default(), &mut Notes::default());
    assert!(matches!(refused, Err(StageError::Unsupported(text)) if text.contains("needs the beams")));
}

#[test]
fn beams_that_do_not_match_the_returns_are_an_error() {
    let refused = |spoil: fn(&mut Revolution)| {
        let mut revolution = sweep(&[Some(4.0), Some(4.0)], 1.0, false);
        spoil(&mut revolution);
        let mut stage = stage();
        stage.affinity(&revolution, &mut Affinity::default(), &mut Notes::default()).expect_err("refused").to_string()
    };
    assert_eq!(refused(|r| r.points_m.truncate(1)), "beam 1 has return 1: not in beam order, or not there");
    let out_of_order = |r: &mut Revolution| r.sweep.as_mut().expect("made above").beams.reverse();
    assert_eq!(refused(out_of_order), "beam 0 has return 1: not in beam order, or not there");
}

#[test]
fn each_number_out_of_range_is_refused() {
    for (name, bad) in [("lambda_deg", 0.0), ("range_noise_m", -0.02)] {
        assert!(KIND.with(&[(name, bad.into())]).is_err(), "{name}");
    }
    assert!(KIND.with(&[("missing_beams", 20_000.into())]).is_err());
}
