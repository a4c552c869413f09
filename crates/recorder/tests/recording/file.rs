//! The file: errors said, equal flights equal, and what a killed process leaves behind.

use std::num::NonZeroU64;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use crosscut_recorder::{Recorder, RecorderError, RecorderOptions, Scope};
use crosscut_stage::{Frame, Observer as _};

use crate::frames;
use crate::reading::{Recording, options, record, record_of};

/// Where the child process of a test records to.
const CHILD_PATH: &str = "CROSSCUT_TEST_RECORDING";

/// This test program, told to run one test alone.
fn this_program(test: &str) -> Command {
    let mut program = Command::new(std::env::current_exe().expect("the path of this program"));
    program.args(["--ignored", "--exact", test]);
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

/// Records 80 revolutions where a file may not grow so large, and leaves the error's text.
#[test]
#[ignore = "run by the next test"]
fn child_that_runs_out_of_space() {
    let path = PathBuf::from(std::env::var_os(CHILD_PATH).expect("the other test says where"));
    let mut recorder = Recorder::new(options(&path)).unwrap();
    let errors = (0..80).filter_map(|seq| recorder.observe(&frames::frame(seq)).err()).map(|e| e.to_string());
    std::fs::write(path.with_extension("errors"), errors.collect::<Vec<_>>().join("\n")).unwrap();
}

#[test]
#[cfg(unix)]
fn a_full_disk_is_an_error_and_what_was_written_before_opens() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("flight.rrd");
    let test = ["--ignored", "--exact", "file::child_that_runs_out_of_space"];
    // With SIGXFSZ ignored, a write beyond the limit is an error as on a full disk.
    let limited = "trap '' XFSZ; ulimit -f 4000; exec \"$0\" \"$@\"";
    let program = std::env::current_exe().unwrap();
    let mut shell = Command::new("sh");
    shell.args(["-c", limited]).arg(program).args(test).env(CHILD_PATH, &path);
    assert!(shell.output().unwrap().status.success());
    let errors = std::fs::read_to_string(path.with_extension("errors")).unwrap();
    let first = errors.lines().next().expect("an error is returned while the flight goes on");
    assert!(first.contains("File too large") && first.ends_with("flight.rrd"), "{first}");
    let revolutions = Recording::read(&path).revolutions("/scan/returns");
    assert!((1..80).contains(&revolutions.len()), "{revolutions:?}");
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

/// Bytes of a recording with exact matrices at every so many revolutions.
fn bytes_of(frames: &[Frame], exact_every: u64) -> u64 {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("flight.rrd");
    let scope = Scope { exact_every: NonZeroU64::new(exact_every), ..Scope::default() };
    record_of(&path, frames, scope);
    std::fs::metadata(&path).expect("recorded").len()
}

#[test]
fn ten_minutes_of_360_beams_at_10_hz_stay_below_200_mb() {
    let frames: Vec<Frame> = (0..100).map(frames::frame).collect();
    let (short, long) = (bytes_of(&frames[..50], 50), bytes_of(&frames, 100)); // with one exact W and U each
    let (each, exact) = ((long - short) / 50, bytes_of(&frames, 50) - long);
    // Exact matrices come at every 300th revolution, and at 16 changes of the count at most.
    let flight = long + each * 5900 + exact * (6000 / 300 + 15);
    assert!(flight < 200_000_000, "{flight} bytes, {each} for each revolution, {exact} for each exact W and U");
}

#[test]
fn a_long_flight_is_split_into_parts_that_each_open_alone_and_belong_to_one_recording() {
    let folder = tempfile::tempdir().unwrap();
    let frames: Vec<Frame> = (0..25).map(frames::frame).collect();
    let scope = Scope { part_revolutions: NonZeroU64::new(10).unwrap(), ..Scope::default() };
    record_of(&folder.path().join("flight.rrd"), &frames, scope);
    let parts = ["flight.rrd", "flight-2.rrd", "flight-3.rrd"].map(|name| Recording::read(&folder.path().join(name)));
    for (part, expected) in parts.iter().zip([0..10, 10..20, 20..25]) {
        assert!(part.revolutions("/scan/returns").into_iter().eq(expected));
        assert!(part.layout_messages > 20 && part.has_footer);
        for entity in ["/config", "/about", "/", "/scan/beams", "/scan/mounting", "/scan/rings", "/timing/total"] {
            assert!(part.of(entity).next().is_some(), "{entity} is missing in a part");
        }
        assert_eq!(part.stores, parts[0].stores, "parts are one recording");
    }
    assert!(!folder.path().join("flight-4.rrd").exists());
}

#[test]
fn a_part_that_cannot_be_created_is_an_error_and_the_parts_before_it_are_whole() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("flight.rrd");
    std::fs::create_dir(folder.path().join("flight-2.rrd")).unwrap();
    let scope = Scope { part_revolutions: NonZeroU64::new(3).unwrap(), ..Scope::default() };
    let mut recorder = Recorder::new(RecorderOptions { scope, ..options(&path) }).unwrap();
    (0..3).for_each(|seq| recorder.observe(&frames::frame(seq)).unwrap());
    let error = recorder.observe(&frames::frame(3)).unwrap_err().to_string();
    assert!(error.contains("flight-2.rrd"), "{error}");
    let recording = Recording::read(&path);
    assert!(recording.has_footer);
    assert_eq!(recording.revolutions("/report/junctions").len(), 3);
}

#[test]
fn viewers_go_on_without_a_file_that_fails_and_its_error_is_told_at_the_end() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("flight.rrd");
    std::fs::create_dir(folder.path().join("flight-2.rrd")).unwrap();
    let scope = Scope { part_revolutions: NonZeroU64::new(3).unwrap(), ..Scope::default() };
    let serve = Some(([127, 0, 0, 1], 0).into());
    let mut recorder = Recorder::new(RecorderOptions { scope, serve, ..options(&path) }).unwrap();
    (0..9).for_each(|seq| recorder.observe(&frames::frame(seq)).unwrap());
    let error = recorder.finish().unwrap_err().to_string();
    assert!(error.contains("flight-2.rrd") && !error.contains("viewer"), "{error}");
    assert_eq!(Recording::read(&path).revolutions("/report/junctions").len(), 3);
}

#[test]
#[ignore = "run by the next test, with RERUN=0"]
fn child_that_is_not_to_record() {
    let path = PathBuf::from(std::env::var_os(CHILD_PATH).expect("the other test says where"));
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

/// Records 140 revolutions of 0.1 s, says so, and hangs.
#[test]
#[ignore = "run by the next test, which kills it"]
fn child_that_records_and_hangs() {
    let path = PathBuf::from(std::env::var_os(CHILD_PATH).expect("the other test says where"));
    let mut recorder = Recorder::new(options(&path)).unwrap();
    for seq in 0..140 {
        recorder.observe(&frames::frame(seq)).unwrap();
    }
    std::fs::write(path.with_extension("done"), "").unwrap();
    std::thread::sleep(Duration::from_secs(600));
}

#[test]
fn a_killed_process_leaves_all_but_the_last_64_revolutions() {
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
        assert!(last >= Some(139 - 64), "{entity} ends at revolution {last:?} of 139");
    }
    assert!(recording.layout_messages > 20);
}
