//! The lines of results.

use serde_json::Value;

use crate::flight::{Writing, file, tunnel};
use crate::program::{column, results_of, run, shipped_flight};

#[test]
fn every_scan_has_a_line_with_every_field() {
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
fn a_straight_tunnel_has_two_walls() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let flight = file(folder.path(), "tunnel.mcap", &tunnel(3, &Writing::default()));
    let (ran, lines) = results_of(&flight, &["--preset", "paper"]);
    ran.expect_code(0);
    assert_eq!(column(&lines, "junctions"), [2, 2, 2]);
    assert_eq!(lines[0]["place"], "corridor");
    assert_eq!(column(&lines, "stamp_ns"), [100_000_000, 200_000_000, 300_000_000]);
}

#[test]
fn results_do_not_depend_on_the_number_of_workers() {
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
fn solvers_of_the_dense_laplacian_give_the_same_walls() {
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
fn a_selection_keeps_the_index_in_the_topic() {
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
fn quiet_prints_nothing() {
    let ran = run(["run".as_ref(), "--quiet".as_ref(), shipped_flight().as_os_str()]).expect_code(0);
    assert_eq!((ran.stdout.as_str(), ran.stderr.as_str()), ("", ""));
}
