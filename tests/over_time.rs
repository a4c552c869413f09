//! A flight over time: the picture, and the list of flips.

use crate::program::{column, results_of, run, shipped_flight};

#[test]
fn every_flip_is_listed_and_marked_in_the_picture() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let picture = folder.path().join("tee.svg");
    let more = ["--preset", "paper", "--over-time", picture.to_str().expect("UTF-8")];
    let (ran, lines) = results_of(&shipped_flight(), &more);
    ran.expect_code(0);
    let flips = count_flips(&column(&lines, "junctions"));
    assert!(flips > 0, "the paper's rule wavers on this flight");

    let list = std::fs::read_to_string(folder.path().join("tee.md")).expect("written");
    assert!(list.contains(&format!("{flips} of {} revolutions", lines.len())), "{list}");
    let rows: Vec<&str> = list.lines().filter(|line| line.contains(" returns")).collect();
    assert_eq!(rows.len(), flips, "{list}");
    let drawn = std::fs::read_to_string(&picture).expect("written");
    assert_eq!(drawn.matches("<circle").count(), flips);
    assert!(["walls", "margin", "confidence"].iter().all(|lane| drawn.contains(lane)));
}

#[test]
fn seconds_in_the_list_count_from_the_first_scan() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let rows = |more: &[&str]| {
        let picture = folder.path().join("tee.svg");
        let options = [&["--preset", "paper", "--over-time", picture.to_str().expect("UTF-8")], more].concat();
        results_of(&shipped_flight(), &options).0.expect_code(0);
        let list = std::fs::read_to_string(folder.path().join("tee.md")).expect("written");
        let cells = list.lines().filter(|line| line.contains(" returns")).map(|line| line.split(" | ").take(2));
        cells.map(|cells| cells.map(str::to_owned).collect::<Vec<_>>()).collect::<Vec<_>>()
    };
    let (whole, part) = (rows(&[]), rows(&["--from", "2"]));
    assert!(!part.is_empty() && part.iter().all(|row| whole.contains(row)), "{part:?} of {whole:?}");
}

#[test]
fn a_picture_that_cannot_be_written_leaves_complete_results() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let nowhere = folder.path().join("missing/tee.svg");
    let (ran, lines) = results_of(&shipped_flight(), &["--over-time", nowhere.to_str().expect("UTF-8")]);
    let ran = ran.expect_code(3);
    assert!(ran.stderr.contains("lost: ") && ran.stderr.contains("missing/tee"), "{}", ran.stderr);
    assert_eq!(lines.len(), 141);
}

#[test]
fn a_list_that_would_overwrite_the_results_is_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = |name: &str| folder.path().join(name).to_str().expect("UTF-8").to_owned();
    let flight = shipped_flight().to_str().expect("UTF-8").to_owned();
    run([flight_args(&flight, &path("over.svg")), vec!["--results".to_owned(), path("over.md")]].concat())
        .expect_code(2);
    assert!(std::fs::read_dir(folder.path()).expect("a folder").next().is_none(), "nothing is written");
}

fn flight_args(flight: &str, picture: &str) -> Vec<String> {
    ["run", flight, "--over-time", picture].map(str::to_owned).to_vec()
}

/// Number of counts that differ from the count of more than half of their neighbours, five on either side.
fn count_flips(counts: &[u64]) -> usize {
    let differs = |at: usize| {
        let around = at.saturating_sub(5)..(at + 6).min(counts.len());
        let neighbours: Vec<u64> = around.filter(|&other| other != at).map(|other| counts[other]).collect();
        let same = |count: u64| neighbours.iter().filter(|&&other| other == count).count();
        neighbours.iter().any(|&count| count != counts[at] && 2 * same(count) > neighbours.len())
    };
    (0..counts.len()).filter(|&at| differs(at)).count()
}
