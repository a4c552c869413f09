//! Agreement of two answers.

use crosscut_evaluate::{Agreement, Differences, Proportion, Score, Stretch};
use crosscut_report::{OpeningLine, ResultsLine, WayLine};

use crate::scans::{answer, truth};

fn agreement(seq: u64, first: &[i32], second: &[i32]) -> Agreement {
    let at = |labels| ResultsLine { seq, stamp_ns: 100 * seq, ..answer(labels, &[]) };
    Agreement::of(&at(first), &at(second)).expect("equally many labels")
}

#[test]
fn agreement_equals_the_score_with_one_answer_as_truth() {
    let labels = [[0, 0, 0, 0, 0, 1], [0, 0, 0, 0, 1, 1], [0, 0, 1, 1, 2, -2], [0, -1, 1, 1, 1, 1]];
    for first in &labels {
        for second in &labels {
            let agreement = agreement(0, first, second);
            let score = Score::of(&truth(first, 0), &answer(second, &[])).expect("equally many labels");
            assert_eq!(
                (agreement.same_walls, agreement.junctions),
                (score.right, [score.true_walls, score.reported_walls])
            );
            assert_eq!((agreement.same_returns, agreement.returns), (score.returns_right, score.returns));
        }
    }
}

#[test]
fn a_pillar_of_one_answer_matches_no_wall() {
    let same = |first: &[u32], second: &[u32]| {
        let labels = [0, 0, 1, 1, 2, 2];
        Agreement::of(&answer(&labels, first), &answer(&labels, second)).expect("equally many labels").same_walls
    };
    assert!(same(&[], &[]) && same(&[2], &[2]));
    assert!(!same(&[2], &[1]), "two walls each, but not the same two");
    assert!(!same(&[2], &[]), "another count");
}

#[test]
fn openings_are_missing_or_added_relative_to_the_first_answer() {
    let with = |bearings_rad: &[f64]| {
        let opening = |&bearing_rad: &f64| OpeningLine {
            known: "judged".to_owned(),
            bearing_rad,
            width_m: 3.0,
            range_m: 5.0,
            walls: [0, 0],
            evidence: String::new(),
            p: None,
            cut_by_view: false,
        };
        ResultsLine { openings: bearings_rad.iter().map(opening).collect(), ..answer(&[0, 0], &[]) }
    };
    let mut differences = Differences::default();
    differences.add(&Agreement::of(&with(&[0.0, 1.0, 2.0]), &with(&[0.1, 3.0])).expect("equally many labels"));
    assert_eq!(differences.openings_lacking, Proportion { hits: 2, of: 3 });
    assert_eq!(differences.openings_more, Proportion { hits: 1, of: 2 });
}

#[test]
fn ways_are_missing_or_added_and_differ_where_one_has_no_partner_within_20_degrees() {
    let with = |elevations_deg: &[f64]| {
        let way = |deg: &f64| WayLine {
            direction: [deg.to_radians().cos(), 0.0, deg.to_radians().sin()],
            bearing_rad: 0.0,
            elevation_rad: deg.to_radians(),
            slope_rad: deg.to_radians(),
            clearance_m: 2.0,
            kind: String::new(),
            p: 0.9,
            evidence: String::new(),
            cut_by_view: false,
        };
        ResultsLine { ways: Some(elevations_deg.iter().map(way).collect()), ..answer(&[0, 0], &[]) }
    };
    let agreement = |a: &[f64], b: &[f64]| Agreement::of(&with(a), &with(b)).expect("equally many labels");
    assert!(agreement(&[0.0, 90.0], &[71.0, 19.0]).is_same() && agreement(&[], &[]).is_same());
    assert!(!agreement(&[0.0], &[21.0]).is_same() && !agreement(&[0.0], &[0.0, 5.0]).is_same());
    let mut differences = Differences::default();
    differences.add(&agreement(&[0.0, 90.0, 180.0], &[10.0, 50.0]));
    let [lacking, more] = [differences.ways_lacking, differences.ways_more];
    assert_eq!([lacking, more], [Proportion { hits: 2, of: 3 }, Proportion { hits: 1, of: 2 }]);
    assert_eq!(differences.stretches[0].ways, Some([3, 2]));
}

#[test]
fn a_stretch_ends_where_the_answers_or_counts_change() {
    let (one, two, three) = ([0, 0, 0, 0], [0, 0, 1, 1], [0, 1, 2, 2]);
    let other_two = [0, 1, 1, 1];
    let flight = [(one, one), (one, two), (one, two), (one, three), (one, one), (one, three), (two, other_two)];
    let mut differences = Differences::default();
    for (seq, (first, second)) in (0..).zip(&flight) {
        differences.add(&agreement(seq, first, second));
    }
    let stretch = |from: u64, to: u64, junctions| Stretch {
        flight: "tee".to_owned(),
        seq: [from, to],
        stamp_ns: [100 * from, 100 * to],
        revolutions: to - from + 1,
        junctions,
        ways: None,
        confidence: [answer(&one, &[]).confidence; 2],
    };
    let expected = [stretch(1, 2, [1, 2]), stretch(3, 3, [1, 3]), stretch(5, 5, [1, 3]), stretch(6, 6, [2, 2])];
    let mut all = Differences::default();
    all.merge(differences.clone(), "tee");
    assert_eq!(all.stretches, expected);
    assert_eq!(
        (differences.same_count, differences.same_walls),
        (Proportion { hits: 3, of: 7 }, Proportion { hits: 2, of: 7 })
    );
}

#[test]
fn answers_for_different_scans_are_refused() {
    let is_refused = |first: &ResultsLine, second: &ResultsLine| {
        Agreement::of(first, second).is_err_and(|error| error.to_string().contains("not of the same scan"))
    };
    assert!(is_refused(&answer(&[0, 0], &[]), &answer(&[0], &[])), "other beams");
    let at = |seq| ResultsLine { seq, ..answer(&[0, 0], &[]) };
    assert!(is_refused(&at(0), &at(3)), "another revolution");
    assert!(Agreement::of(&at(3), &at(3)).is_ok());
}
