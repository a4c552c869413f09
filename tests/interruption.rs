//! Ctrl-C and kill: what was made is kept.

use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::flight::{Writing, file, tunnel};
use crate::program::{Ran, column, crosscut, lines, shipped_flight};

/// Starts a flight of a minute at the sensor's pace and waits until some results are on disk.
fn start(folder: &std::path::Path) -> (Child, std::path::PathBuf) {
    let flight = file(folder, "flight.mcap", &tunnel(600, &Writing::default()));
    let results = folder.join("results.jsonl");
    let args = ["run".as_ref(), flight.as_os_str(), "--rate".as_ref(), "1".as_ref(), "--results".as_ref()];
    let child = crosscut(args).arg(&results).stderr(Stdio::piped()).spawn().expect("the program starts");
    let deadline = Instant::now() + Duration::from_secs(60);
    while std::fs::read_to_string(&results).unwrap_or_default().lines().count() < 5 {
        assert!(Instant::now() < deadline, "no results within a minute");
        std::thread::sleep(Duration::from_millis(20));
    }
    (child, results)
}

fn signal(child: &Child, name: &str) {
    let sent = Command::new("kill").args([format!("-{name}"), child.id().to_string()]).status();
    assert!(sent.expect("kill is on every Unix").success());
}

#[test]
#[cfg(unix)]
fn an_interrupted_flight_ends_with_130_and_whole_results_without_a_gap() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (child, results) = start(folder.path());
    signal(&child, "INT");
    let ran: Ran = child.wait_with_output().expect("it ends").into();
    let ran = ran.expect_code(130);
    assert!(ran.stderr.contains("stopping"), "{}", ran.stderr);
    let lines = lines(&std::fs::read_to_string(results).expect("results"));
    assert!(lines.len() < 600 && column(&lines, "seq").into_iter().eq(0..lines.len() as u64));
}

#[test]
#[cfg(unix)]
fn a_killed_flight_leaves_every_result_that_was_made() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (mut child, results) = start(folder.path());
    child.kill().expect("it was running");
    child.wait().expect("it ends");
    let text = std::fs::read_to_string(results).expect("results");
    assert!(text.ends_with('\n'), "no line is cut off");
    assert!(lines(&text).len() >= 5);
}

#[test]
fn who_has_read_enough_of_the_results_may_close_the_pipe_without_a_word() {
    let mut child = crosscut(["run".as_ref(), shipped_flight().as_os_str(), "--results".as_ref(), "-".as_ref()])
        .arg("--quiet")
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    drop(child.stdout.take());
    let ran: Ran = child.wait_with_output().expect("it ends").into();
    assert_eq!(ran.expect_code(130).stderr, "");
}
