//! What all commands that fly a recording have in common.

use std::path::{Path, PathBuf};

use crate::flight::{Writing, bytes, file, tunnel, tunnel_scan};
use crate::program::{Ran, lines, run, shipped_flight};

/// The commands that stream a flight, each with its outputs in `folder`.
fn commands(folder: &Path) -> Vec<Vec<PathBuf>> {
    let at = |name: &str| folder.join(name);
    let words = |words: &[&str], out: PathBuf| words.iter().map(PathBuf::from).chain([out]).collect::<Vec<_>>();
    let mut of_run = words(&["run", "--out"], at("run.jsonl"));
    of_run.extend(words(&["--map"], at("run.json")));
    vec![
        of_run,
        words(&["run", "--map"], at("map.svg")),
        words(&["report", "--out"], at("report.html")),
        words(&["compare", "--with", "default", "--with", "threshold", "--json"], at("compare.json")),
    ]
}

fn flown(command: &[PathBuf], flight: &Path, more: &[&str]) -> Ran {
    run(command.iter().cloned().chain([flight.to_owned()]).chain(more.iter().map(PathBuf::from)))
}

#[test]
fn every_command_fails_where_no_scan_can_be_read() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut damaged = tunnel(10, &Writing::default());
    damaged[2000] ^= 1; // inside the only chunk
    let flight = file(folder.path(), "flight.mcap", &damaged);
    let written = ["run.jsonl", "run.json", "map.svg", "report.html"];
    let written = written.map(|name| file(folder.path(), name, b"older\n"));
    for command in commands(folder.path()) {
        let said = flown(&command, &flight, &[]).expect_code(1).stderr;
        assert!(said.contains("no scan could be read"), "{}: {said}", command[0].display());
    }
    for path in written {
        assert_eq!(std::fs::read(&path).expect("still there"), b"older\n", "{}", path.display());
    }
}

#[test]
fn every_command_says_which_scans_were_left_out() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut scans: Vec<_> = (0..4).map(tunnel_scan).collect();
    scans[2].header.frame_id = "rear".into();
    let flight = file(folder.path(), "flight.mcap", &bytes(&scans, &Writing::default()));
    for command in &commands(folder.path()) {
        let said = flown(command, &flight, &["--set", "ingest.frame_id=lidar"]).expect_code(0).stderr;
        assert!(said.contains("left out 1 scan whose frame"), "{}: {said}", command[0].display());
    }
}

#[test]
fn every_command_reads_a_part_of_the_flight() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at = |name: &str| folder.path().join(name);
    let flight = shipped_flight();
    let every = ["--every", "10"];
    for command in commands(folder.path()) {
        flown(&command, &flight, &every).expect_code(0);
        let said = flown(&command, &flight, &["--from", "3", "--to", "2"]).expect_code(2).stderr;
        assert!(said.contains("--from 3 is after --to 2"), "{}: {said}", command[0].display());
    }
    let text = |name: &str| std::fs::read_to_string(at(name)).expect("written");
    assert_eq!(lines(&text("run.jsonl")).len(), 15);
    assert!(text("report.html").contains("<p>15 revolutions (turns of the lidar) in "));
    let json = |name: &str| serde_json::from_str::<serde_json::Value>(&text(name)).expect("JSON");
    assert_eq!(json("compare.json")["comparisons"][0]["figures"]["same_count"]["of"], 15);
    assert_eq!(json("compare.json")["all"][0]["figures"]["revolutions"], 15);
}

#[test]
fn a_converted_part_has_the_scans_of_that_part() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let part = folder.path().join("part.mcap");
    let selected = ["--from", "2", "--to", "6", "--every", "2"];
    let convert = [PathBuf::from("convert"), "--out".into(), part.clone()];
    flown(&convert, &shipped_flight(), &selected).expect_code(0);
    let answers = |flight: &Path, more: &[&str]| {
        let results = ["run", "--quiet", "--set", "flight.pose=odometry", "--out", "-"].map(PathBuf::from);
        let stdout = flown(&results, flight, more).expect_code(0).stdout;
        lines(&stdout)
            .iter()
            .map(|line| [&line["stamp_ns"], &line["labels"]].map(ToString::to_string))
            .collect::<Vec<_>>()
    };
    let expected = answers(&shipped_flight(), &selected);
    assert!(expected.len() > 10 && answers(&part, &[]) == expected);
    let said = flown(&convert, &shipped_flight(), &["--from", "1000"]).expect_code(1).stderr;
    assert!(said.contains("no scan of /scan is selected"), "{said}");
    assert_eq!(answers(&part, &[]), expected, "what is there stays");
    flown(&convert, &shipped_flight(), &["--topic", "/a", "--topic", "/b"]).expect_code(2);
}

#[test]
fn tables_go_to_standard_output_and_words_to_standard_error() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let flight = shipped_flight();
    let results = ["run", "--out"].map(PathBuf::from).into_iter();
    let ran = flown(&results.clone().chain([folder.path().join("r.jsonl")]).collect::<Vec<_>>(), &flight, &[]);
    let ran = ran.expect_code(0);
    assert!(ran.stdout.contains("confidence 0.9 or more") && ran.stdout.contains("median ms"), "{}", ran.stdout);
    assert!(ran.stderr.starts_with("141 revolutions in ") && !ran.stderr.contains("sure"), "{}", ran.stderr);
    // Results and tables do not mix.
    let ran = flown(&results.chain(["-".into()]).collect::<Vec<_>>(), &flight, &[]).expect_code(0);
    assert_eq!(lines(&ran.stdout).len(), 141);
}
