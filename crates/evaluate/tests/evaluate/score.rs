//! The score of one revolution, compared with hand counts and brute force.

use crosscut_evaluate::{Score, ScoreError};
use proptest::prelude::{Just, Strategy, any, prop, prop_assert, prop_assert_eq, proptest};

use crate::scans::{answer, truth};

fn score(true_labels: &[i32], reported: &[i32]) -> Score {
    Score::of(&truth(true_labels, 0), &answer(reported, &[])).expect("equally many labels")
}

#[test]
fn a_wall_is_matched_from_an_overlap_of_four_fifths() {
    // Wall 0 has 4 of 5 beams: IoU 0.8 exactly. Wall 1 has all 5.
    let four_fifths = score(&[0, 0, 0, 0, 0, 1, 1, 1, 1, 1], &[0, 0, 0, 0, -2, 1, 1, 1, 1, 1]);
    assert!(four_fifths.right && four_fifths.right_count());
    // The fifth beam goes to wall 1 instead: IoU of wall 0 is 4/5, of wall 1 5/6.
    assert!(score(&[0, 0, 0, 0, 0, 1, 1, 1, 1, 1], &[0, 0, 0, 0, 1, 1, 1, 1, 1, 1]).right);
    // Wall 0 has 3 of 4 beams.
    let three_quarters = score(&[0, 0, 0, 0, 1, 1, 1, 1], &[0, 0, 0, -2, 1, 1, 1, 1]);
    assert!(!three_quarters.right && three_quarters.right_count());
}

#[test]
fn a_beam_without_return_in_a_wall_enlarges_the_union() {
    assert!(score(&[0, 0, 0, 0, -1], &[0, 0, 0, 0, 0]).right, "4 of 5");
    assert!(!score(&[0, 0, 0, -1], &[0, 0, 0, 0]).right, "3 of 4");
}

#[test]
fn an_equal_count_with_other_walls_is_wrong() {
    // Two walls on both sides, cut elsewhere.
    let score = score(&[0, 0, 0, 1, 1, 1], &[0, 1, 1, 1, 1, 1]);
    assert!(score.right_count() && !score.right);
    assert_eq!((score.returns_right, score.returns), (4, 6));
}

#[test]
fn matched_walls_with_another_count_are_wrong() {
    let score = score(&[0, 0, 0, 0, 0, 0], &[0, 0, 0, 0, 0, 1]);
    assert!(!score.right && !score.right_count());
    assert_eq!((score.true_walls, score.reported_walls, score.returns_right), (1, 2, 5));
}

#[test]
fn islands_may_be_missed_but_not_counted_as_walls() {
    // Island 0, walls 1 and 2.
    let truth = truth(&[0, 1, 1, 1, 1, 1, 2, 2, 2, 2], 1);
    let right = |labels: &[i32], islands: &[u32]| Score::of(&truth, &answer(labels, islands)).expect("10 labels").right;
    assert!(right(&[5, 0, 0, 0, 0, 0, 1, 1, 1, 1], &[5]), "found as an island");
    assert!(right(&[-2, 0, 0, 0, 0, 0, 1, 1, 1, 1], &[]), "left out");
    assert!(!right(&[5, 0, 0, 0, 0, 0, 1, 1, 1, 1], &[]), "counted as a wall");
    assert!(!right(&[5, 0, 0, 0, 0, 0, 5, 1, 1, 1], &[5]), "a wall torn by it");
}

#[test]
fn a_wall_without_returns_cannot_be_matched() {
    let lost = crosscut_messages::Truth { walls: 2, ..truth(&[0, 0, -1, -1], 0) };
    assert!(!Score::of(&lost, &answer(&[0, 0, -1, -1], &[])).expect("4 labels").right);
    let invented = answer(&[0, 0, 1, 1], &[]);
    assert!(!Score::of(&lost, &invented).expect("4 labels").right);
}

#[test]
fn three_kinds_of_labels_are_wrong_and_dust_in_no_wall_right() {
    //                   wall     left out  dust kept  dust out  dust dropped  nothing  phantom
    let truth =
        [0, 0, 0, 0, /**/ 0, /*  */ -2, /*  */ -2, /* */ -2, /*     */ -1, /**/ -1];
    let found =
        [3, 3, 3, 3, /**/ -2, /* */ 3, /*   */ -2, /* */ -1, /*     */ -1, /**/ 3];
    let score = score(&truth, &found);
    assert_eq!((score.returns_right, score.returns), (6, 9));
}

#[test]
fn an_empty_scan_reported_empty_is_right() {
    let score = score(&[], &[]);
    assert!(score.right);
    assert_eq!((score.returns, score.adjusted_rand_index), (0, None));
}

#[test]
fn adjusted_rand_indices_agree_with_scikit_learn() {
    // sklearn.metrics.adjusted_rand_score(truth, reported)
    let known: [(&[i32], &[i32], f64); 4] = [
        (&[0, 0, 1, 1], &[0, 0, 1, 2], 0.571_428_571_428_571_4),
        (&[0, 0, 0, 1, 1, 1], &[0, 0, 1, 1, 2, 2], 0.242_424_242_424_242_43),
        (&[0, 0, 0, 0, 1, 1, 1, 1], &[0, 1, 0, 1, 0, 1, 0, 1], -0.166_666_666_666_666_66),
        (&[0, 1, 2], &[5, 6, 7], 1.0),
    ];
    for (truth, reported, expected) in known {
        let found = score(truth, reported).adjusted_rand_index.expect("two walls and more");
        assert!((found - expected).abs() < 1e-12, "{truth:?} {reported:?}: {found} instead of {expected}");
    }
}

#[test]
fn the_rand_index_needs_two_walls() {
    assert_eq!(score(&[0, 0, 0], &[0, 0, 1]).adjusted_rand_index, None);
    let with_island = Score::of(&truth(&[0, 0, 1], 1), &answer(&[0, 0, 1], &[])).expect("3 labels");
    assert_eq!(with_island.adjusted_rand_index, None, "one wall and an island");
    // Dust and beams without return are not of a wall; of walls left out, one group: (0 0 1 1) against (0 0 x x).
    assert_eq!(score(&[0, 0, 1, 1, -2, -1], &[0, 0, -2, -1, 0, 1]).adjusted_rand_index, Some(1.0));
}

#[test]
fn labels_of_another_number_of_beams_are_an_error() {
    let error = Score::of(&truth(&[0, 0], 0), &answer(&[0], &[])).expect_err("2 against 1");
    assert_eq!(error, ScoreError::Beams { seq: 0, truth: 2, reported: 1 });
}

/// Share of all pairs treated alike, corrected for chance by the definition: pair by pair.
fn rand_index_by_pairs(truth: &[i32], reported: &[i32]) -> f64 {
    let beams: Vec<_> = (0..truth.len()).filter(|&i| truth[i] >= 0).collect();
    let (mut both, mut in_truth, mut in_report, mut all) = (0.0, 0.0, 0.0, 0.0);
    for (place, &i) in beams.iter().enumerate() {
        for &j in &beams[..place] {
            let (t, r) = (truth[i] == truth[j], reported[i].max(-1) == reported[j].max(-1));
            both += f64::from(t && r);
            in_truth += f64::from(t);
            in_report += f64::from(r);
            all += 1.0;
        }
    }
    let (expected, largest) = (in_truth * in_report / all, 0.5 * (in_truth + in_report));
    if largest == expected { 1.0 } else { (both - expected) / (largest - expected) }
}

/// Labels of one scan: true ones below 4, reported ones below 5, none and dust among both.
fn labels() -> impl Strategy<Value = (Vec<i32>, Vec<i32>)> {
    (0usize..40).prop_flat_map(|n| (prop::collection::vec(-2i32..4, n), prop::collection::vec(-2i32..5, n)))
}

proptest! {
    #[test]
    fn other_numbers_for_the_same_walls_change_nothing(
        (true_labels, reported) in labels(),
        true_ids in Just(vec![0i32, 1, 2, 3]).prop_shuffle(),
        reported_ids in Just(vec![0i32, 7, 2, 9, 4]).prop_shuffle(),
    ) {
        // All four walls are there, with or without beams, so that numbers do not change how many there are.
        let truth = crosscut_messages::Truth { walls: 4, ..truth(&true_labels, 0) };
        let renumbered = crosscut_messages::Truth {
            labels: true_labels.iter().map(|&t| if t < 0 { t } else { true_ids[t as usize] }).collect(),
            ..truth.clone()
        };
        let other: Vec<_> = reported.iter().map(|&r| if r < 0 { r } else { reported_ids[r as usize] }).collect();
        let one = Score::of(&truth, &answer(&reported, &[])).expect("equally many labels");
        let two = Score::of(&renumbered, &answer(&other, &[])).expect("equally many labels");
        match (one.adjusted_rand_index, two.adjusted_rand_index) {
            (Some(a), Some(b)) => prop_assert!((a - b).abs() < 1e-12),
            (a, b) => prop_assert_eq!(a, b),
        }
        prop_assert_eq!(Score { adjusted_rand_index: None, ..one }, Score { adjusted_rand_index: None, ..two });
    }

    #[test]
    fn the_truth_itself_scores_full(true_labels in prop::collection::vec(-2i32..4, 0..40)) {
        // Number the walls that occur from 0, so that none is without beams.
        let mut ids: Vec<_> = true_labels.iter().copied().filter(|&t| t >= 0).collect();
        ids.sort_unstable();
        ids.dedup();
        let dense: Vec<i32> =
            true_labels.iter().map(|t| ids.binary_search(t).map_or(*t, |place| place as i32)).collect();
        let score = score(&dense, &dense);
        prop_assert!(score.right && score.right_count());
        prop_assert_eq!(score.returns_right, score.returns);
        prop_assert_eq!(score.adjusted_rand_index, (ids.len() >= 2).then_some(1.0));
    }

    #[test]
    fn the_rand_index_agrees_with_counted_pairs((true_labels, reported) in labels()) {
        if let Some(found) = score(&true_labels, &reported).adjusted_rand_index {
            prop_assert!((found - rand_index_by_pairs(&true_labels, &reported)).abs() < 1e-9);
        }
    }

    #[test]
    fn nothing_is_right_by_more_than_all(
        (true_labels, reported) in labels(), island in any::<bool>()
    ) {
        let islands: &[u32] = if island { &[0] } else { &[] };
        let score = Score::of(&truth(&true_labels, 0), &answer(&reported, islands)).expect("equally many labels");
        prop_assert!(score.returns_right <= score.returns && score.returns <= true_labels.len());
        prop_assert!(!score.right || score.right_count());
    }
}
