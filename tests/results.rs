//! The lines of results.

use std::path::Path;
use std::process::Command;

use serde_json::Value;

use crate::flight::{Writing, file, tunnel};
use crate::program::{Ran, column, crosscut, results_of, run, shipped_flight};

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

#[test]
fn results_as_an_mcap_hold_the_scans_and_the_same_lines() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().join("answers.mcap");
    // The vehicle's left is the sensor's right: the drawing is in the sensor's frame.
    let mounting = ["--set", "ingest.upside_down=true", "--set", "ingest.yaw_rad=0.5"];
    let (_, expected) = results_of(&shipped_flight(), &mounting);
    let flight = shipped_flight();
    let args = [Path::new("run"), &flight, Path::new("--out"), &out];
    run(args.into_iter().chain(mounting.iter().map(Path::new))).expect_code(0);
    let bytes = std::fs::read(&out).expect("written");
    let messages: Vec<_> =
        mcap::MessageStream::new(&bytes).expect("an MCAP").map(|message| message.expect("a message")).collect();
    let of = |topic: &str| messages.iter().filter(|message| message.channel.topic == topic).collect::<Vec<_>>();
    let lines: Vec<Value> =
        of("/crosscut/results").iter().map(|message| serde_json::from_slice(&message.data).expect("JSON")).collect();
    assert_eq!(lines, expected);
    assert!(of("/crosscut/results").iter().zip(&lines).all(|(message, line)| line["stamp_ns"] == message.log_time));
    assert_eq!((of("/scan").len(), of("/crosscut/scene").len()), (lines.len(), lines.len()));
    // It is a recording as well, with the same answers.
    let (_, again) = results_of(&out, &mounting);
    let answer = |line: &Value| ["junctions", "labels", "openings", "confidence"].map(|field| line[field].clone());
    assert!(again.iter().map(answer).eq(expected.iter().map(answer)));
}

#[test]
fn a_flight_that_cannot_be_read_leaves_older_results_as_mcap() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (out, broken) = (folder.path().join("answers.mcap"), folder.path().join("broken.mcap"));
    std::fs::write(&out, "older").expect("written");
    std::fs::write(&broken, "no recording").expect("written");
    run([Path::new("run"), &broken, Path::new("--out"), &out]).expect_code(1);
    assert_eq!(std::fs::read(&out).expect("there"), b"older");
}

#[test]
#[cfg(unix)]
fn results_that_cannot_be_ended_leave_the_map() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let flight = file(folder.path(), "tunnel.mcap", &tunnel(5, &Writing::default()));
    let (out, map) = (folder.path().join("answers.mcap"), folder.path().join("map.json"));
    let command = crosscut([Path::new("run"), &flight, Path::new("--out"), &out, Path::new("--map"), &map]);
    // No file grows beyond a block, which holds the start of an MCAP and an empty map.
    let limited = "trap '' XFSZ; ulimit -f 1; exec \"$0\" \"$@\"";
    let ran = Command::new("sh").args(["-c", limited]).arg(command.get_program()).args(command.get_args()).output();
    let ran = Ran::from(ran.expect("a shell")).expect_code(1);
    assert!(ran.stderr.contains("error: the results cannot be written after 5 revolutions"), "{}", ran.stderr);
    let map: Value = serde_json::from_slice(&std::fs::read(&map).expect("written")).expect("JSON");
    assert!(map["nodes"].is_array());
}
