//! Ctrl-C and kill: results so far are kept.

use std::io::{BufRead as _, BufReader, Write as _};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::flight::{Writing, file, tunnel};
use crate::program::{Ran, column, crosscut, lines, results_of, run, shipped_flight};

/// Starts a flight of a minute at the sensor's pace and waits until some results are on disk.
fn start(folder: &Path) -> (Child, std::path::PathBuf) {
    let flight = file(folder, "flight.mcap", &tunnel(600, &Writing::default()));
    let results = folder.join("results.jsonl");
    let args = ["run".as_ref(), flight.as_os_str(), "--rate".as_ref(), "1".as_ref(), "--out".as_ref()];
    let child = crosscut(args).arg(&results).stderr(Stdio::piped()).spawn().expect("the program starts");
    await_or_panic(|| std::fs::read_to_string(&results).unwrap_or_default().lines().count() >= 5);
    (child, results)
}

fn await_or_panic(is_done: impl Fn() -> bool) {
    let deadline = Instant::now() + Duration::from_secs(60);
    while !is_done() {
        assert!(Instant::now() < deadline, "nothing within a minute");
        std::thread::sleep(Duration::from_millis(20));
    }
}

fn signal(child: &Child, name: &str) {
    let sent = Command::new("kill").args([format!("-{name}"), child.id().to_string()]).status();
    assert!(sent.expect("kill is on every Unix").success());
}

#[test]
#[cfg(unix)]
fn an_interrupted_flight_ends_with_130_and_complete_results() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (child, results) = start(folder.path());
    signal(&child, "INT");
    let ran: Ran = child.wait_with_output().expect("it ends").into();
    let ran = ran.expect_code(130);
    assert!(ran.stderr.contains("stopping"), "{}", ran.stderr);
    let lines = lines(&std::fs::read_to_string(results).expect("results"));
    assert!(lines.len() < 600 && column(&lines, "seq").into_iter().eq(0..lines.len() as u64));
}

/// `timeout` sends its signal to the program, and at once to the group that it is in.
#[test]
#[cfg(unix)]
fn two_signals_at_once_are_one() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (child, _) = start(folder.path());
    let twice = format!("kill -TERM {0}; kill -TERM {0}", child.id());
    assert!(Command::new("sh").args(["-c", &twice]).status().expect("a shell").success());
    let ran = Ran::from(child.wait_with_output().expect("it ends")).expect_code(130);
    assert!(ran.stderr.contains("interrupted after"), "it quit at once: {}", ran.stderr);
}

/// Long before the time that a flight in progress has.
#[cfg(unix)]
fn ends_soon_by_a_signal(child: Child) {
    std::thread::sleep(Duration::from_millis(500)); // it waits by then, or will
    signal(&child, "TERM");
    let sent = Instant::now();
    Ran::from(child.wait_with_output().expect("it ends")).expect_code(130);
    assert!(sent.elapsed() < Duration::from_secs(6), "{:?}", sent.elapsed());
}

#[test]
#[cfg(unix)]
fn a_signal_ends_a_wait_for_standard_input() {
    let start = std::fs::read(shipped_flight()).expect("a recording");
    for sent in [0, start.len() / 2] {
        let mut child = crosscut(["run", "-", "--quiet"]).stdin(Stdio::piped()).spawn().expect("the program starts");
        let mut pipe = child.stdin.take().expect("a pipe");
        pipe.write_all(&start[..sent]).expect("it reads");
        ends_soon_by_a_signal(child);
    }
}

#[test]
#[cfg(unix)]
fn a_signal_ends_a_wait_for_a_reader() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let pipe = folder.path().join("pipe");
    assert!(Command::new("mkfifo").arg(&pipe).status().expect("mkfifo is on every Unix").success());
    let flight = shipped_flight();
    let args = ["run".as_ref(), flight.as_os_str(), "--out".as_ref(), pipe.as_os_str()];
    ends_soon_by_a_signal(crosscut(args).stderr(Stdio::piped()).spawn().expect("the program starts"));
}

#[test]
#[cfg(unix)]
fn a_file_that_another_run_writes_to_is_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (child, results) = start(folder.path());
    let ran = run(["run".as_ref(), shipped_flight().as_os_str(), "--out".as_ref(), results.as_os_str()]).expect_code(1);
    assert!(ran.stderr.contains("another program is writing to it"), "{}", ran.stderr);
    signal(&child, "INT");
    Ran::from(child.wait_with_output().expect("it ends")).expect_code(130);
    let lines = lines(&std::fs::read_to_string(results).expect("results"));
    assert!(lines.len() >= 5 && column(&lines, "seq").into_iter().eq(0..lines.len() as u64));
}

#[test]
#[cfg(all(unix, feature = "rerun"))]
fn a_recording_in_use_is_refused_and_results_are_complete() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let flight = file(folder.path(), "flight.mcap", &tunnel(600, &Writing::default()));
    let rrd = folder.path().join("flight.rrd");
    let save = |flight: &Path| {
        let mut command = crosscut(["run".as_ref(), flight.as_os_str(), "--save".as_ref(), rrd.as_os_str()]);
        command.stderr(Stdio::piped());
        command
    };
    let child = save(&flight).args(["--rate", "1"]).spawn().expect("the program starts");
    await_or_panic(|| rrd.metadata().is_ok_and(|file| file.len() > 0));
    let other = save(&shipped_flight()).args(["--out", "-"]).output().expect("it runs");
    let other = Ran::from(other).expect_code(3);
    assert!(other.stderr.contains("another program is writing to it"), "{}", other.stderr);
    assert_eq!(lines(&other.stdout).len(), 141);
    signal(&child, "INT");
    Ran::from(child.wait_with_output().expect("it ends")).expect_code(130);
    run(["rrd".as_ref(), "ls".as_ref(), rrd.as_os_str()]).expect_code(0);
}

/// Starts the command and interrupts it as soon as `made` exists, such as the part file of an output.
fn interrupted(command: &[&str], made: &Path) -> Ran {
    let child = crosscut(command).stderr(Stdio::piped()).spawn().expect("the program starts");
    await_or_panic(|| made.exists());
    signal(&child, "INT");
    Ran::from(child.wait_with_output().expect("it ends")).expect_code(130)
}

#[test]
#[cfg(unix)]
fn an_interrupted_simulation_leaves_readable_files() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().to_str().expect("UTF-8");
    let said =
        interrupted(&["simulate", "--suite", "all", "--out", path], &folder.path().join(".clean35.mcap.part")).stderr;
    assert!(said.contains("interrupted: "), "{said}");
    let made: Vec<_> =
        std::fs::read_dir(folder.path()).expect("a folder").map(|e| e.expect("an entry").path()).collect();
    assert!((2..14).contains(&made.len()), "{made:?}");
    for file in made {
        run(["info".as_ref(), file.as_os_str()]).expect_code(0);
    }
}

#[test]
#[cfg(unix)]
fn a_killed_flight_leaves_its_results() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (mut child, results) = start(folder.path());
    let before = std::fs::read_to_string(&results).expect("results");
    child.kill().expect("it was running");
    child.wait().expect("it ends");
    let text = std::fs::read_to_string(results).expect("results");
    assert!(text.starts_with(&before) && text.ends_with('\n'), "nothing is lost, and no line is cut off");
    assert!(column(&lines(&text), "seq").into_iter().eq(0..lines(&text).len() as u64));
}

#[test]
#[cfg(all(unix, feature = "rerun"))]
fn an_interrupted_export_leaves_the_old_file() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let [saved, out] = ["tee.rrd", "w.csv"].map(|name| folder.path().join(name));
    let flight = shipped_flight();
    let args = ["run".as_ref(), flight.as_os_str(), "--quiet".as_ref(), "--save".as_ref()];
    Ran::from(crosscut(args).arg(&saved).output().expect("the program starts")).expect_code(0);
    let get = ["rrd".as_ref(), "get".as_ref(), saved.as_os_str(), "/affinity/W".as_ref(), "--out".as_ref()];
    let files = || std::fs::read_dir(folder.path()).expect("a folder").count();
    // On a busy machine the export may end before the signal comes: then it is tried again.
    for _ in 0..50 {
        std::fs::write(&out, "good").expect("written");
        let mut child = crosscut(get).arg(&out).stderr(Stdio::piped()).spawn().expect("the program starts");
        let mut has_ended = || child.try_wait().expect("a child").is_some();
        while files() == 2 && !has_ended() {}
        if !has_ended() {
            signal(&child, "INT");
        }
        let ran = Ran::from(child.wait_with_output().expect("it ends"));
        if ran.code != Some(0) {
            ran.expect_code(130);
            assert_eq!(std::fs::read_to_string(&out).expect("still there"), "good");
            assert_eq!(files(), 2, "nothing unfinished beside it");
            return;
        }
    }
    panic!("every export ended before the signal");
}

#[test]
fn a_closed_pipe_ends_the_run_silently() {
    let mut child = crosscut(["run".as_ref(), shipped_flight().as_os_str(), "--out".as_ref(), "-".as_ref()])
        .arg("--quiet")
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    drop(child.stdout.take());
    let ran: Ran = child.wait_with_output().expect("it ends").into();
    assert_eq!(ran.expect_code(130).stderr, "");
}

#[test]
#[cfg(unix)]
fn an_interrupted_comparison_says_so_in_its_file() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at = |name: &str| folder.path().join(name).to_str().expect("UTF-8").to_owned();
    let json = at("figures.json");
    let flight = shipped_flight().to_str().expect("UTF-8").to_owned();
    let mut command = vec!["compare", &flight, "--json", &json];
    for with in ["paper", "paper,kmeans.seed=2", "paper,kmeans.seed=3", "paper,kmeans.seed=4"] {
        command.extend(["--with", with]);
    }
    interrupted(&command, &folder.path().join(".figures.json.part"));
    assert!(std::fs::read_to_string(&json).expect("written").contains("interrupted"));
}

#[test]
#[cfg(unix)]
fn a_killed_run_leaves_the_map_up_to_then() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let flight = file(folder.path(), "flight.mcap", &tunnel(600, &Writing::default()));
    let map = folder.path().join("map.json");
    let args = ["run".as_ref(), flight.as_os_str(), "--rate".as_ref(), "1".as_ref(), "--map".as_ref(), map.as_os_str()];
    let mut child = crosscut(args).stderr(Stdio::null()).spawn().expect("the program starts");
    await_or_panic(|| map.metadata().is_ok_and(|file| file.len() > 0));
    signal(&child, "KILL");
    child.wait().expect("it ends");
    let written: serde_json::Value = serde_json::from_slice(&std::fs::read(&map).expect("a map")).expect("JSON");
    assert!(written["nodes"].is_array() && written["merges"].is_array(), "{written}");
}

#[test]
#[cfg(unix)]
fn a_killed_run_of_a_file_leaves_the_map_that_was_there() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let flight = file(folder.path(), "flight.mcap", &tunnel(3000, &Writing::default()));
    let (map, lines) = (file(folder.path(), "map.json", b"whole"), folder.path().join("lines.jsonl"));
    let slowly = ["--preset", "paper", "--set", "spectral.kind=faer"];
    let mut command = crosscut(["run".as_ref(), flight.as_os_str(), "--map".as_ref(), map.as_os_str()]);
    let mut child = command.args(slowly).arg("-o").arg(&lines).stderr(Stdio::null()).spawn().expect("it starts");
    await_or_panic(|| lines.metadata().is_ok_and(|file| file.len() > 0));
    std::thread::sleep(Duration::from_millis(1500));
    assert_eq!(child.try_wait().expect("a child"), None, "it is at work");
    signal(&child, "KILL");
    child.wait().expect("it ends");
    assert_eq!(std::fs::read(&map).expect("the old map"), b"whole");
}

#[test]
#[cfg(unix)]
fn a_killed_run_loses_at_most_a_second_of_an_mcap() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let flight = file(folder.path(), "flight.mcap", &tunnel(100, &Writing::default()));
    let out = folder.path().join("results.mcap");
    let args = ["run".as_ref(), flight.as_os_str(), "--rate".as_ref(), "1".as_ref(), "--out".as_ref(), out.as_os_str()];
    let mut child = crosscut(args).stderr(Stdio::null()).spawn().expect("the program starts");
    await_or_panic(|| out.metadata().is_ok_and(|file| file.len() > 2000));
    signal(&child, "KILL");
    child.wait().expect("it ends");
    let (ran, lines) = results_of(&out, &[]);
    ran.expect_code(3);
    assert!((10..100).contains(&lines.len()), "{} scans", lines.len());
}

#[test]
#[cfg(unix)]
fn an_interrupt_stops_the_command_and_debug_goes_on() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let flight = file(folder.path(), "flight.mcap", &tunnel(3000, &Writing::default()));
    let args = ["debug".as_ref(), flight.as_os_str(), "--preset".as_ref(), "paper".as_ref()];
    let mut command = crosscut(args);
    command.args(["--set", "spectral.kind=faer"]); // all eigenvalues: slow
    let mut child =
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("it starts");
    let mut input = child.stdin.take().expect("a pipe");
    let mut output = BufReader::new(child.stdout.take().expect("a pipe")).lines();
    let mut shown = || output.next().expect("a line").expect("text");
    shown(); // the greeting
    writeln!(input, "hold\nseek 5").expect("it reads");
    assert!(shown().starts_with("A: 0 ") && shown().starts_with("5 "));
    for line in ["again", "differs", "next changed", "report"] {
        writeln!(input, "{line}").expect("it reads");
        std::thread::sleep(Duration::from_millis(300)); // it is at work by then
        signal(&child, "INT");
        let sent = Instant::now();
        writeln!(input, "step 0").expect("it reads");
        assert!(shown().starts_with("5 "), "after {line}");
        assert!(sent.elapsed() < Duration::from_secs(5), "{line} took {:?}", sent.elapsed());
    }
    signal(&child, "INT");
    let ran = Ran::from(child.wait_with_output().expect("it ends")).expect_code(130);
    assert_eq!(ran.stderr.matches("error: stopped; everything is as before").count(), 4, "{}", ran.stderr);
}
