//! Lines of results of corridors.

use std::f64::consts::PI;

use serde_json::Value;

use crate::program::results_of;
use crate::{CORRIDORS, data};

pub(crate) fn every_line_is_consistent() {
    for (file, scans) in CORRIDORS {
        let (ran, lines) = results_of(&data(file), &[]);
        ran.expect_code(0);
        assert_eq!(lines.len(), scans, "{file}");
        assert!(lines.iter().all(|line| line["returns"].as_u64() > Some(100)), "{file} has returns everywhere");
        lines.iter().for_each(assert_consistent);
    }
}

/// Fails unless the values of a line agree with each other as the contract states.
fn assert_consistent(line: &Value) {
    let list = |value: &Value| value.as_array().expect("a list").clone();
    let number = |value: &Value| value.as_f64().expect("a number");
    let count = |value: &Value| value.as_u64().expect("a whole number");
    let labels: Vec<i64> = list(&line["labels"]).iter().map(|label| label.as_i64().expect("a label")).collect();
    let labelled = |wanted: i64| labels.iter().filter(|&&label| label == wanted).count() as u64;
    let walls = list(&line["walls"]);
    assert_eq!(count(&line["returns"]), labels.len() as u64 - labelled(-1), "{line}");
    assert!(labels.iter().all(|label| (-2..walls.len() as i64).contains(label)), "{line}");
    for (id, wall) in (0..).zip(&walls) {
        assert_eq!((wall["id"].as_i64(), count(&wall["returns"])), (Some(id), labelled(id)), "{line}");
        assert!(list(&wall["bearing_rad"]).iter().all(|bearing| number(bearing).abs() <= PI), "{line}");
    }
    let first_beams = (0..walls.len() as i64).map(|id| labels.iter().position(|&label| label == id));
    assert!(first_beams.is_sorted(), "walls are numbered by their first beam: {line}");
    let of_no_island = walls.iter().filter(|wall| wall["island"] == false).count() as u64;
    assert_eq!(count(&line["junctions"]), of_no_island, "{line}");
    assert_eq!(line["place"], "partial_view", "{line}");
    for opening in list(&line["openings"]) {
        let between = list(&opening["walls"]);
        assert!(between.iter().all(|id| walls[count(id) as usize]["island"] == false), "{line}");
        assert!(number(&opening["width_m"]) >= 0.6 && number(&opening["bearing_rad"]).abs() <= PI, "{line}");
        assert!(["seen_through", "no_return"].contains(&opening["evidence"].as_str().expect("a name")), "{line}");
    }
    let eigenvalues: Vec<f64> = list(&line["eigenvalues"]).iter().map(number).collect();
    assert!(eigenvalues.is_sorted() && eigenvalues.len() <= 16, "{line}");
    let below = eigenvalues.iter().filter(|&&eigenvalue| eigenvalue < 1e-8).count() as u64;
    let k = count(&line["k"]);
    assert_eq!(below, k.min(16), "{line}");
    assert!(k >= 16 || eigenvalues.len() as u64 > k, "the next is there as well: {line}");
    assert!((0.0..=1.0).contains(&number(&line["confidence"])), "{line}");
}
