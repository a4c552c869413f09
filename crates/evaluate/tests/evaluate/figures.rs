//! Figures over revolutions, families and configurations, and their tables.

use crosscut_evaluate::{Confusion, Evaluation, Proportion, Score, Scoreboard, tables};
use crosscut_messages::TruthOpening;
use crosscut_report::OpeningLine;

use crate::scans::{answer, truth};

fn score(true_labels: &[i32], reported: &[i32], confidence: f64) -> Score {
    let answer = crosscut_report::ResultsLine { confidence: Some(confidence), ..answer(reported, &[]) };
    Score::of(&truth(true_labels, 0), &answer).expect("equally many labels")
}

/// Right; counted right with wrong walls; one wall too many; one too few.
fn four() -> [Score; 4] {
    [
        score(&[0, 0, 1, 1], &[0, 0, 1, 1], 0.95),
        score(&[0, 0, 1, 1], &[0, 1, 1, 1], 0.95),
        score(&[0, 0, 1, 1], &[0, 0, 1, 2], 0.3),
        score(&[0, 0, 1, 1], &[0, 0, 0, 0], 0.2),
    ]
}

fn evaluation(scores: &[Score]) -> Evaluation {
    let mut evaluation = Evaluation::default();
    for score in scores {
        evaluation.add(score);
    }
    evaluation
}

#[test]
fn figures_of_four_revolutions_agree_with_a_hand_count() {
    let figures = evaluation(&four()).figures();
    assert_eq!((figures.revolutions, figures.right), (4, Proportion { hits: 1, of: 4 }));
    assert_eq!(figures.right_count, Proportion { hits: 2, of: 4 });
    assert_eq!(
        (figures.over_count, figures.under_count),
        (Proportion { hits: 1, of: 4 }, Proportion { hits: 1, of: 4 })
    );
    let confusion = |reported, revolutions| Confusion { truth: 2, reported, revolutions };
    assert_eq!(figures.confusion, [confusion(1, 1), confusion(2, 2), confusion(3, 1)]);
    assert_eq!((figures.labels.returns_right, figures.labels.returns), (4 + 3 + 3 + 2, 16));
    let index = figures.labels.adjusted_rand_index.expect("two walls");
    // By hand: 1; 0 for one of four beams moved; 4/7 for one split off; 0 for all in one.
    assert_eq!((index.count, index.p05, index.p95), (4, 0.0, 1.0));
    assert_eq!(figures.confidence.sure_right, Proportion { hits: 1, of: 2 });
    // The right answer (0.95) ties with one wrong one and is above two.
    assert!((figures.confidence.auroc.expect("both kinds") - 2.5 / 3.0).abs() < 1e-12);
}

#[test]
fn openings_are_summed_over_revolutions() {
    let opening = |bearing_rad| TruthOpening { bearing_rad, width_m: 4.0 };
    let line = |bearing_rad, width_m| OpeningLine {
        known: if width_m == 5.0 { "seen" } else { "judged" }.to_owned(),
        bearing_rad,
        width_m,
        range_m: 5.0,
        walls: [0, 0],
        evidence: String::new(),
        p: None,
        cut_by_view: false,
    };
    let mut sum = Evaluation::default();
    let revolutions = [
        (vec![opening(0.0), opening(1.0), opening(2.0)], vec![line(0.1, 5.0)]),
        (vec![opening(0.0)], vec![line(-0.05, 4.0), line(3.0, 4.0)]),
    ];
    for (openings, lines) in revolutions {
        let truth = crosscut_messages::Truth { openings, ..truth(&[0], 0) };
        let answer = crosscut_report::ResultsLine { openings: lines, ..answer(&[0], &[]) };
        sum.add(&Score::of(&truth, &answer).expect("equally many labels"));
    }
    let openings = sum.figures().openings;
    assert_eq!(
        (openings.missed, openings.false_alarms),
        (Proportion { hits: 2, of: 4 }, Proportion { hits: 1, of: 3 })
    );
    let (bearing, width) = (openings.bearing_error_rad.expect("matched"), openings.width_error.expect("matched"));
    assert!((bearing.p50 - 0.05).abs() < 1e-12 && (bearing.p95 - 0.1).abs() < 1e-12);
    assert_eq!((width.p50, width.p95), (0.0, 0.25));
}

#[test]
fn merged_evaluations_equal_one_over_all() {
    let (first, second) = (evaluation(&four()[..1]), evaluation(&four()[1..]));
    let mut merged = first;
    merged.merge(&second);
    assert_eq!(merged, evaluation(&four()));
}

fn scoreboard() -> Scoreboard {
    let mut scoreboard = Scoreboard::new(vec!["paper".into(), "default".into()]);
    for score in four() {
        scoreboard.add("clean6", 0, &score);
        scoreboard.add("clean6", 1, &four()[0]);
    }
    scoreboard.add("dust", 0, &four()[3]);
    scoreboard
}

#[test]
fn the_sum_of_families_weights_revolutions_equally() {
    let all = scoreboard().all();
    assert_eq!(all[0].figures().right, Proportion { hits: 1, of: 5 });
    assert_eq!(all[1].figures().right, Proportion { hits: 4, of: 4 });
}

#[test]
fn the_overview_has_a_row_per_family_and_a_column_per_configuration() {
    let [right, counts] = tables::overview(&scoreboard()).try_into().expect("two tables");
    assert_eq!(right.header, ["family", "revolutions", "paper", "default"]);
    assert_eq!(right.rows[0], ["clean6", "4", "25.0 [4.6, 69.9]", "100.0 [51.0, 100.0]"]);
    assert_eq!(right.rows[1], ["dust", "1", "0.0 [0.0, 79.3]", "-"]);
    assert_eq!(counts.rows[2], ["all", "5", "40.0", "100.0"]);
}

#[test]
fn every_row_of_every_table_is_as_long_as_its_header() {
    for scoreboard in [scoreboard(), Scoreboard::new(vec!["paper".into()]), Scoreboard::new(Vec::new())] {
        for table in tables::overview(&scoreboard).into_iter().chain(tables::details(&scoreboard)) {
            assert!(table.rows.iter().all(|row| row.len() == table.header.len()), "{}", table.title);
        }
    }
}

#[test]
fn counts_far_above_the_truth_share_a_column() {
    let mut scoreboard = Scoreboard::new(vec!["paper".into()]);
    scoreboard.add("clean6", 0, &score(&[0; 12], &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11], 0.5));
    scoreboard.add("clean6", 0, &score(&[0; 5], &[0, 1, 2, 3, 4], 0.5));
    scoreboard.add("clean6", 0, &score(&[0; 3], &[0, 0, 1], 0.5));
    let details = tables::details(&scoreboard);
    let confusion = details.iter().find(|table| table.header[0] == "true").expect("there is one");
    assert_eq!(confusion.header, ["true", "0", "1", "2", "3", "4 and more"]);
    assert_eq!(confusion.rows, [["1", "0", "0", "1", "0", "2"]]);
}

#[test]
fn shares_in_json_have_intervals_and_missing_values_are_null() {
    let json = serde_json::to_value(evaluation(&[]).figures()).expect("JSON");
    assert_eq!(json["right"], serde_json::json!({"hits": 0, "of": 0, "share": null, "interval95": null}));
    assert_eq!(json["openings"]["false"]["of"], 0);
    assert_eq!(json["confidence"]["reliability"].as_array().map(Vec::len), Some(10));
}
