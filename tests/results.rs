//! The lines of results.

use std::f64::consts::PI;

use serde_json::Value;

use crate::flight::{Writing, file, tunnel};
use crate::program::{column, real_recording, results_of, run, shipped_flight};

#[test]
fn every_scan_of_the_shipped_flight_has_its_line_with_every_field_of_the_contract() {
    let (ran, lines) = results_of(&shipped_flight(), &["--preset", "paper"]);
    let ran = ran.expect_code(0);
    assert!(lines.len() > 50, "{} lines", lines.len());
    assert!(column(&lines, "seq").into_iter().eq(0..lines.len() as u64));
    let fields = [
        "seq",
        "stamp_ns",
        "returns",
        "junctions",
        "k",
        "margin",
        "confidence",
        "place",
        "eigenvalues",
        "walls",
        "openings",
        "labels",
        "notes",
    ];
    for line in &lines {
        for field in fields {
            assert!(line.get(field).is_some(), "{field} is missing from {line}");
        }
        let labels = line["labels"].as_array().expect("labels");
        assert_eq!(labels.len(), 360, "one label per beam");
        assert_eq!(labels.iter().filter(|l| **l != -1).count() as u64, line["returns"].as_u64().expect("returns"));
        assert_eq!(line["k"], line["junctions"], "the paper reports what the eigenvalues say");
        assert_eq!(line["walls"].as_array().map(Vec::len), line["k"].as_u64().map(|k| k as usize));
        let eigenvalues: Vec<_> = line["eigenvalues"].as_array().expect("a list").iter().map(Value::as_f64).collect();
        assert_eq!(eigenvalues.len(), 16, "min(n, 16) of them");
        assert!(eigenvalues.is_sorted());
    }
    assert!(ran.stderr.contains("revolutions"), "the summary is for people: {}", ran.stderr);
}

#[test]
fn a_wide_straight_tunnel_has_two_walls_and_two_ways_on() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let flight = file(folder.path(), "tunnel.mcap", &tunnel(3, &Writing::default()));
    let (ran, lines) = results_of(&flight, &["--preset", "paper"]);
    ran.expect_code(0);
    assert_eq!(column(&lines, "junctions"), [2, 2, 2]);
    assert_eq!(lines[0]["place"], "corridor");
    assert_eq!(column(&lines, "stamp_ns"), [100_000_000, 200_000_000, 300_000_000]);
}

#[test]
fn results_are_the_same_bytes_again_and_whatever_the_number_of_workers() {
    let once = |workers: &str| {
        let input = shipped_flight();
        let set = format!("pipeline.workers={workers}");
        results_of(&input, &["--quiet", "--set", &set]).0.expect_code(0).stdout
    };
    let reference = once("1");
    for workers in ["1", "2", "4"] {
        let again = once(workers);
        let difference = reference.lines().zip(again.lines()).position(|(a, b)| a != b);
        assert!(
            reference == again,
            "with {workers} workers line {difference:?} differs; {} and {} lines",
            reference.lines().count(),
            again.lines().count()
        );
    }
}

#[test]
fn the_three_solvers_of_the_dense_laplacian_give_the_same_walls() {
    let labels = |solver: &str| -> Vec<Value> {
        let paper = ["--preset", "paper", "--every", "10", "--set", solver];
        let (ran, lines) = results_of(&shipped_flight(), &paper);
        ran.expect_code(0);
        lines.iter().map(|line| line["labels"].clone()).collect()
    };
    let reference = labels("spectral.kind=faer");
    assert_eq!(reference, labels("spectral.kind=nalgebra"));
    assert_eq!(reference, labels("spectral.kind=slicing"));
}

#[test]
fn a_selection_keeps_the_index_that_the_message_has_in_its_topic() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let flight = file(folder.path(), "tunnel.mcap", &tunnel(40, &Writing::default()));
    let seqs = |more: &[&str]| {
        let (ran, lines) = results_of(&flight, more);
        ran.expect_code(0);
        column(&lines, "seq")
    };
    assert_eq!(seqs(&["--every", "15"]), [0, 15, 30]);
    assert_eq!(seqs(&["--from", "1.95", "--to", "2.25"]), [20, 21, 22]);
}

#[test]
fn quiet_says_nothing() {
    let ran = run(["run".as_ref(), "--quiet".as_ref(), shipped_flight().as_os_str()]).expect_code(0);
    assert_eq!((ran.stdout.as_str(), ran.stderr.as_str()), ("", ""));
}

#[test]
fn what_a_line_says_of_walls_openings_labels_and_eigenvalues_agrees_on_every_scan_of_the_real_corridors() {
    for (name, scans) in [("cross", 688), ("threeway", 233), ("dead", 285), ("left", 112)] {
        let Some(recording) = real_recording(&format!("corridor_{name}.mcap")) else { return };
        let (ran, lines) = results_of(&recording, &[]);
        ran.expect_code(0);
        assert_eq!(lines.len(), scans, "{name}");
        assert!(lines.iter().all(|line| line["returns"].as_u64() > Some(100)), "{name} has returns everywhere");
        for line in &lines {
            assert_agrees(line);
        }
    }
}

/// What the contract says of one line, and of what stands in it.
fn assert_agrees(line: &Value) {
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
