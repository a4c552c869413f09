//! Counts in corridors with furniture and doors, seen with a view of 255° and a range of 5.6 m.

use std::collections::BTreeMap;

use crosscut_evaluate::flips;
use serde_json::Value;

use crate::program::{column, results_of};
use crate::{CORRIDORS, LABELS, data};

/// A label without a question: the fourth wall is 5° outside the view and has no return.
const NOT_ASKED: (&str, usize) = ("corridor_cross.mcap", 448);
/// At most this share of the counts along a corridor differs from most of their neighbours, in %.
const MOST_FLIPS_PERCENT: f64 = 15.0;
/// The zero tolerance of preset `paper`.
const PAPER_TOLERANCE: f64 = 1e-7;
/// Eigenvalues of both solvers differ by at most this.
const ROUNDING: f64 = 1e-10;

fn counts(file: &str) -> Vec<usize> {
    let lines = results_of(&data(file), &["--preset", "default"]).1;
    column(&lines, "junctions").into_iter().map(|count| count as usize).collect()
}

pub(crate) fn labelled_scans_are_counted_as_a_person_does() {
    let labels = std::fs::read_to_string(data(LABELS)).expect("readable");
    let mut counts_of: BTreeMap<String, Vec<usize>> = BTreeMap::new();
    let mut wrong = Vec::new();
    for row in labels.lines().skip(1) {
        let [file, scan, walls] = row.split(',').collect::<Vec<_>>()[..] else { panic!("not a label: {row}") };
        let (scan, walls): (usize, usize) = (scan.parse().expect("a number"), walls.parse().expect("a number"));
        let counts = counts_of.entry(file.to_owned()).or_insert_with(|| counts(file));
        if (file, scan) != NOT_ASKED && counts[scan] != walls {
            wrong.push(format!("{file} {scan}: a person sees {walls}, counted {}", counts[scan]));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

pub(crate) fn counts_rarely_flicker() {
    for (file, _) in CORRIDORS {
        let counts = counts(file);
        let percent = 100.0 * flips(&counts).len() as f64 / counts.len() as f64;
        assert!(percent <= MOST_FLIPS_PERCENT, "{file}: {percent:.1} %");
    }
}

pub(crate) fn slicing_and_faer_agree() {
    for (file, _) in CORRIDORS {
        let lines = |kind: &str| {
            let settings = ["--preset", "paper", "--every", "25", "--set", &format!("spectral.kind={kind}")];
            results_of(&data(file), &settings).1
        };
        let (full, slicing) = (lines("faer"), lines("slicing"));
        assert_eq!(full.len(), slicing.len(), "{file}");
        for (full, slicing) in full.iter().zip(&slicing) {
            let (expected, found) = (eigenvalues(full), eigenvalues(slicing));
            let difference = expected.iter().zip(&found).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(difference <= ROUNDING, "{file}, revolution {}: off by {difference}", full["seq"]);
            let is_decided = expected.iter().all(|eigenvalue| (eigenvalue - PAPER_TOLERANCE).abs() > ROUNDING);
            assert!(!is_decided || full["labels"] == slicing["labels"], "{file}, revolution {}", full["seq"]);
        }
    }
}

fn eigenvalues(line: &Value) -> Vec<f64> {
    line["eigenvalues"].as_array().expect("a list").iter().map(|value| value.as_f64().expect("a number")).collect()
}
