//! `run --follow`: a recording that is still being written. Each step waits for lines of results, never for a time.

use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdout, Command, Stdio};

use crate::flight::{Writing, tunnel};
use crate::program::{Ran, crosscut, results_of, run};

/// The first lines come after 100 scans, in which parts of turns and blind sectors are looked for.
const SCANS: u64 = 150;

fn follow(flight: &Path) -> (Child, BufReader<ChildStdout>) {
    let args = ["run".as_ref(), flight.as_os_str(), "--follow".as_ref(), "--quiet".as_ref(), "--results".as_ref()];
    let mut command = crosscut(args);
    let mut child = command.arg("-").stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the program starts");
    let lines = BufReader::new(child.stdout.take().expect("it is piped"));
    (child, lines)
}

fn next_lines(from: &mut BufReader<ChildStdout>, count: usize) -> String {
    let mut lines = String::new();
    for i in 0..count {
        assert!(from.read_line(&mut lines).expect("UTF-8") > 0, "results end after {i} of {count} lines");
    }
    lines
}

/// How many messages are whole in the first `bytes` of a flight without chunks, whose scans are all of one size.
fn scans_in(whole: &[u8], bytes: usize) -> usize {
    let marks = whole.windows(5).enumerate().filter(|(_, found)| found == b"lidar").map(|(at, _)| at);
    let starts: Vec<usize> = marks.collect();
    let size = starts[1] - starts[0];
    starts.iter().filter(|at| *at + size <= bytes).count()
}

#[test]
fn each_scan_has_its_line_before_the_next_is_written() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for chunked in [false, true] {
        let whole = tunnel(SCANS, &Writing { chunked, ..Writing::default() });
        let expected = {
            let path = folder.path().join("whole.mcap");
            std::fs::write(&path, &whole).expect("writable");
            results_of(&path, &["--quiet"]).0.expect_code(0).stdout
        };
        let flight = folder.path().join("growing.mcap");
        let mut file = std::fs::File::create(&flight).expect("writable");
        let (child, mut results) = follow(&flight);
        let (mut read, mut written) = (String::new(), 0);
        // The first pieces end within the magic bytes and before the first scan.
        for piece_end in [3, 400, whole.len() * 8 / 10, whole.len() * 8 / 10 + 1, whole.len() * 85 / 100] {
            file.write_all(&whole[written..piece_end]).expect("writable");
            written = piece_end;
            if !chunked {
                let there = scans_in(&whole, written);
                let due = if there < 100 { 0 } else { there };
                read += &next_lines(&mut results, due - read.lines().count());
            }
        }
        file.write_all(&whole[written..]).expect("writable");
        read += &next_lines(&mut results, SCANS as usize - read.lines().count());
        assert_eq!(read, expected, "chunked: {chunked}");
        Ran::from(child.wait_with_output().expect("it ends")).expect_code(0);
    }
}

#[test]
#[cfg(unix)]
fn an_interrupt_ends_the_wait_for_more() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let whole = tunnel(SCANS, &Writing { chunked: false, ..Writing::default() });
    let flight = folder.path().join("growing.mcap");
    let cut = whole.len() * 8 / 10;
    std::fs::write(&flight, &whole[..cut]).expect("writable");
    let (child, mut results) = follow(&flight);
    next_lines(&mut results, scans_in(&whole, cut));
    let sent = Command::new("kill").args(["-INT".to_owned(), child.id().to_string()]).status();
    assert!(sent.expect("kill is on every Unix").success());
    let rest = results.lines().count();
    assert!(rest <= 1, "{rest} more lines than whole scans");
    Ran::from(child.wait_with_output().expect("it ends")).expect_code(130);
}

#[test]
fn what_cannot_be_followed_is_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let log = folder.path().join("log.clf");
    std::fs::write(&log, "FLASER 2 1 2 0 0 0 0 0 0 1.0 host 0\n").expect("writable");
    run(["run".as_ref(), log.as_os_str(), "--follow".as_ref()]).expect_code(1);
    run(["run", "-", "--follow"]).expect_code(2);
    run(["run", "a.mcap", "b.mcap", "--follow"]).expect_code(2);
    run(["run", "a.mcap", "--follow", "--topic", "/front", "--topic", "/rear"]).expect_code(2);
    let ahead = run(["run", "a.mcap", "--follow", "--set", "flight.look_ahead=10"]).expect_code(2).stderr;
    assert!(ahead.contains("flight.look_ahead is for recordings"), "{ahead}");
    let empty = folder.path().join("empty.mcap");
    std::fs::write(&empty, tunnel(0, &Writing::default())).expect("writable");
    run(["run".as_ref(), empty.as_os_str(), "--follow".as_ref()]).expect_code(1);
}
