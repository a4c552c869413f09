//! The file: errors said, equal flights equal, and what a killed process leaves behind.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use crosscut_recorder::{Recorder, RecorderError};
use crosscut_stage::{Frame, Observer as _};

use crate::frames;
use crate::reading::{Recording, options, record};

/// Where the child process of a test records to.
const CHILD_PATH: &str = "CROSSCUT_TEST_RECORDING";

/// This test program, told to run one test alone.
fn this_program(test: &str) -> Command {
    let mut program = Command::new(std::env::current_exe().expect("the path of this program"));
    program.args(["--exact", test]);
    program
}

#[test]
fn a_path_that_cannot_be_written_is_an_error_that_names_it() {
    let error = Recorder::new(options(Path::new("/no/such/folder/flight.rrd"))).err().unwrap();
    assert!(matches!(error, RecorderError::Create { .. }));
    let text = error.to_string();
    assert!(
        text.starts_with("cannot create the recording: ") && text.ends_with("/no/such/folder/flight.rrd"),
        "{text}"
    );
}

/// Not a test of its own: records 40 revolutions where a file may not grow so large, and leaves the error's text.
#[test]
fn child_that_runs_out_of_space() {
    let Some(path) = std::env::var_os(CHILD_PATH).map(PathBuf::from) else { return };
    let mut recorder = Recorder::new(options(&path)).unwrap();
    let errors = (0..40).filter_map(|seq| recorder.observe(&frames::frame(seq)).err()).map(|e| e.to_string());
    std::fs::write(path.with_extension("errors"), errors.collect::<Vec<_>>().join("\n")).unwrap();
}

#[test]
#[cfg(unix)]
fn a_full_disk_is_an_error_and_what_was_written_before_opens() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("flight.rrd");
    let test = ["--exact", "file::child_that_runs_out_of_space"];
    // With SIGXFSZ ignored, a write beyond the limit is an error as on a full disk.
    let limited = "trap '' XFSZ; ulimit -f 1000; exec \"$0\" \"$@\"";
    let program = std::env::current_exe().unwrap();
    let mut shell = Command::new("sh");
    shell.args(["-c", limited]).arg(program).args(test).env(CHILD_PATH, &path);
    assert!(shell.output().unwrap().status.success());
    let errors = std::fs::read_to_string(path.with_extension("errors")).unwrap();
    let first = errors.lines().next().expect("an error is returned while the flight goes on");
    assert!(first.contains("File too large") && first.ends_with("flight.rrd"), "{first}");
    let revolutions = Recording::read(&path).revolutions("/scan/returns");
    assert!((1..40).contains(&revolutions.len()), "{revolutions:?}");
}

#[test]
fn equal_flights_make_equal_content_cut_into_equal_chunks() {
    let frames: Vec<Frame> = (0..40).map(frames::frame).collect();
    let folder = tempfile::tempdir().unwrap();
    let [first, second] = ["first.rrd", "second.rrd"].map(|name| {
        let path = folder.path().join(name);
        record(&path, &frames);
        Recording::read(&path)
    });
    let (a, b) = (first.content(), second.content());
    assert_eq!(a.len(), b.len());
    if let Some((key, _)) = a.iter().find(|(key, value)| b.get(*key) != Some(value)) {
        panic!("the recordings differ first in {key:?}");
    }
    let cuts = |recording: &Recording| -> Vec<(String, usize)> {
        let mut cuts: Vec<_> =
            recording.chunks.iter().map(|chunk| (chunk.entity_path().to_string(), chunk.num_rows())).collect();
        cuts.sort();
        cuts
    };
    assert_eq!(cuts(&first), cuts(&second));
}

#[test]
fn a_revolution_of_360_beams_takes_no_more_than_the_budget() {
    let frames: Vec<Frame> = (0..60).map(frames::frame).collect();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("flight.rrd");
    record(&path, &frames);
    let bytes = std::fs::metadata(&path).unwrap().len() / 60;
    let returns = frames[30].revolution.len();
    assert!(bytes < 40_000, "{bytes} bytes a revolution of {returns} returns");
}

/// Not a test of its own: what the next one runs with RERUN=0.
#[test]
fn child_that_is_not_to_record() {
    let Some(path) = std::env::var_os(CHILD_PATH).map(PathBuf::from) else { return };
    assert!(matches!(Recorder::new(options(&path)), Err(RecorderError::Disabled)));
}

#[test]
fn rerun_0_in_the_environment_is_an_error_rather_than_an_empty_recording() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("flight.rrd");
    let mut child = this_program("file::child_that_is_not_to_record");
    let output = child.env("RERUN", "0").env(CHILD_PATH, &path).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stdout));
    assert!(!path.exists());
}

/// Not a test of its own: what the next one kills. Records 40 revolutions of 0.1 s, says so, and hangs.
#[test]
fn child_that_records_and_hangs() {
    let Some(path) = std::env::var_os(CHILD_PATH).map(PathBuf::from) else { return };
    let mut recorder = Recorder::new(options(&path)).unwrap();
    for seq in 0..40 {
        recorder.observe(&frames::frame(seq)).unwrap();
    }
    std::fs::write(path.with_extension("done"), "").unwrap();
    std::thread::sleep(Duration::from_secs(600));
}

#[test]
fn a_killed_process_leaves_all_but_the_last_two_seconds_of_the_flight() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("flight.rrd");
    let mut child = this_program("file::child_that_records_and_hangs").env(CHILD_PATH, &path).spawn().unwrap();
    let patience = Instant::now();
    while !path.with_extension("done").exists() && patience.elapsed() < Duration::from_secs(120) {
        std::thread::sleep(Duration::from_millis(20));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let recording = Recording::read(&path);
    for entity in ["/scan/ranges", "/affinity/W", "/report/junctions"] {
        let last = recording.revolutions(entity).last().copied();
        assert!(last >= Some(39 - 20), "{entity} ends at revolution {last:?} of 39");
    }
    assert!(recording.layout_messages > 20);
}
