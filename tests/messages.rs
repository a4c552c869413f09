//! Messages on standard error.

use std::fs::File;
use std::path::Path;
use std::process::{ExitStatus, Stdio};

use crate::program::{crosscut, shipped_flight};

/// The exit status of a command whose standard error nobody reads.
fn status_without_reader(arguments: &[&Path]) -> ExitStatus {
    let mut child = crosscut(arguments).stderr(Stdio::piped()).spawn().expect("the program starts");
    drop(child.stderr.take());
    child.wait().expect("it ends")
}

#[test]
fn messages_need_no_reader() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (made, results) = (folder.path().join("made.mcap"), folder.path().join("results.jsonl"));
    let simulate = ["simulate", "tee", "--out"].map(Path::new);
    assert_eq!(status_without_reader(&[&simulate[..], &[&made]].concat()).code(), Some(0));
    let flight = shipped_flight();
    let run = [Path::new("run"), &flight, Path::new("--out"), &results];
    assert_eq!(status_without_reader(&run).code(), Some(0), "the summary");
    assert_eq!(std::fs::read_to_string(results).expect("results").lines().count(), 141);
    assert_eq!(status_without_reader(&["run", "nowhere.mcap"].map(Path::new)).code(), Some(1), "an error");
    assert_eq!(status_without_reader(&["simulate", "nowhere"].map(Path::new)).code(), Some(2), "wrong usage");
}

#[test]
#[cfg(target_os = "linux")]
fn messages_that_find_no_space_keep_the_exit_code() {
    let full = || File::create("/dev/full").expect("it is there");
    for (arguments, code) in [(["run", "nowhere.mcap"], 1), (["simulate", "nowhere"], 2), (["simulate", "--list"], 0)] {
        let ended = crosscut(arguments).stderr(full()).stdout(Stdio::null()).status().expect("the program starts");
        assert_eq!(ended.code(), Some(code), "{arguments:?}");
    }
}
