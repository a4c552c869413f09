//! Words for people, on standard error.

use std::fs::File;
use std::path::Path;
use std::process::{ExitStatus, Stdio};

use crate::program::{crosscut, shipped_flight};

/// How the command ends when nobody reads what it says.
fn unheard(arguments: &[&Path]) -> ExitStatus {
    let mut child = crosscut(arguments).stderr(Stdio::piped()).spawn().expect("the program starts");
    drop(child.stderr.take());
    child.wait().expect("it ends")
}

#[test]
fn nobody_has_to_read_what_is_said() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (made, results) = (folder.path().join("made.mcap"), folder.path().join("results.jsonl"));
    let simulate = ["simulate", "tee", "--out"].map(Path::new);
    assert_eq!(unheard(&[&simulate[..], &[&made]].concat()).code(), Some(0));
    let flight = shipped_flight();
    let run = [Path::new("run"), &flight, Path::new("--results"), &results];
    assert_eq!(unheard(&run).code(), Some(0), "the summary");
    assert_eq!(std::fs::read_to_string(results).expect("results").lines().count(), 141);
    assert_eq!(unheard(&["run", "nowhere.mcap"].map(Path::new)).code(), Some(1), "an error");
    assert_eq!(unheard(&["simulate", "nowhere"].map(Path::new)).code(), Some(2), "wrong usage");
}

#[test]
#[cfg(target_os = "linux")]
fn words_that_find_no_space_do_not_change_the_exit_code() {
    let full = || File::create("/dev/full").expect("it is there");
    for (arguments, code) in [(["run", "nowhere.mcap"], 1), (["simulate", "nowhere"], 2), (["simulate", "--list"], 0)] {
        let ended = crosscut(arguments).stderr(full()).stdout(Stdio::null()).status().expect("the program starts");
        assert_eq!(ended.code(), Some(code), "{arguments:?}");
    }
}
