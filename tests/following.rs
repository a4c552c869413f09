//! `run --follow`: a recording that is still being written. Each step waits for lines of results, never for a time.

use std::io::{BufRead, BufReader, Cursor, Write};
use std::path::Path;
use std::process::{Child, ChildStdout, Command, Stdio};

use crate::flight::{Writing, tunnel};
use crate::program::{Ran, crosscut, results_of, run, shipped_flight};

/// Parts of turns and blind sectors are looked for in the first 100 scans, for a second at most.
const SCANS: u64 = 150;

fn follow(flight: &Path) -> (Child, BufReader<ChildStdout>) {
    let args = ["run".as_ref(), flight.as_os_str(), "--follow".as_ref(), "--quiet".as_ref(), "--out".as_ref()];
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
        // Fewer than 100 scans are answered as well, after a second.
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
        for piece_end in
            [3, 400, whole.len() / 10, whole.len() * 8 / 10, whole.len() * 8 / 10 + 1, whole.len() * 85 / 100]
        {
            file.write_all(&whole[written..piece_end]).expect("writable");
            written = piece_end;
            if !chunked {
                let due = scans_in(&whole, written);
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
    let empty = folder.path().join("empty.mcap");
    std::fs::write(&empty, tunnel(0, &Writing::default())).expect("writable");
    run(["run".as_ref(), empty.as_os_str(), "--follow".as_ref()]).expect_code(1);
}

/// A recording without chunks, as a recorder writes it that keeps nothing back.
fn unchunked(recording: &[u8]) -> Vec<u8> {
    let options = mcap::WriteOptions::new().use_chunks(false);
    let mut writer = options.create(Cursor::new(Vec::new())).expect("memory");
    for message in mcap::MessageStream::new(recording).expect("an MCAP") {
        writer.write(&message.expect("whole")).expect("memory");
    }
    writer.finish().expect("memory");
    writer.into_inner().into_inner()
}

/// Two parts of the shipped flight, with its odometry, in a folder.
fn parts_in(folder: &Path) -> [Vec<u8>; 2] {
    [("0.mcap", ["--to", "7"]), ("1.mcap", ["--from", "7.05"])].map(|(name, span)| {
        let part = folder.join(name);
        let [flight, out] = [shipped_flight(), part.clone()].map(|path| path.display().to_string());
        run(["convert", &flight, "--out", &out].iter().chain(&span)).expect_code(0);
        let bytes = unchunked(&std::fs::read(&part).expect("written"));
        std::fs::write(part, &bytes).expect("writable");
        bytes
    })
}

#[test]
fn files_that_appear_in_a_folder_are_one_flight_with_its_odometry() {
    let whole = tempfile::tempdir().expect("a temporary folder");
    let parts = parts_in(whole.path());
    let expected = results_of(whole.path(), &["--quiet"]).0.expect_code(0).stdout;
    assert!(expected.contains("\"pose\":{"), "the flight has odometry");
    let growing = tempfile::tempdir().expect("a temporary folder");
    let (child, mut results) = follow(growing.path());
    let mut file = std::fs::File::create(growing.path().join("bag_0.mcap")).expect("writable");
    let half = parts[0].len() / 2;
    file.write_all(&parts[0][..half]).expect("writable");
    let mut read = next_lines(&mut results, 1);
    file.write_all(&parts[0][half..]).expect("writable");
    std::fs::write(growing.path().join("bag_1.mcap"), &parts[1]).expect("writable");
    // The last scan waits for the odometry up to its end.
    read += &next_lines(&mut results, expected.lines().count() - 2);
    std::fs::write(growing.path().join("metadata.yaml"), "rosbag2_bagfile_information:\n").expect("writable");
    read += &next_lines(&mut results, 1);
    assert_eq!(read, expected);
    Ran::from(child.wait_with_output().expect("it ends")).expect_code(0);
}

#[test]
fn standard_input_is_answered_while_its_sender_pauses() {
    let flight = unchunked(&std::fs::read(shipped_flight()).expect("the shipped flight"));
    let expected = results_of(&shipped_flight(), &["--quiet"]).0.expect_code(0).stdout;
    let args = ["run", "-", "--quiet", "--out", "-"];
    let folder = tempfile::tempdir().expect("a temporary folder");
    let compressed = folder.path().join("tee.mcap.zst");
    std::fs::write(&compressed, zstd::encode_all(&flight[..], 1).expect("compressed")).expect("writable");
    let compressed = std::fs::File::open(compressed).expect("written");
    let ran = Ran::from(crosscut(args).stdin(compressed).output().expect("the program starts")).expect_code(0);
    assert_eq!(ran.stdout, expected, "compressed");
    let mut command = crosscut(args);
    let command = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().expect("the program starts");
    let mut lines = BufReader::new(child.stdout.take().expect("it is piped"));
    let mut sender = child.stdin.take().expect("it is piped");
    sender.write_all(&flight[..flight.len() / 2]).expect("read");
    let read = next_lines(&mut lines, 1);
    // On a thread: the program reads no more while nobody reads its lines.
    let sending = move || sender.write_all(&flight[flight.len() / 2..]);
    std::thread::Builder::new().name("sender".to_owned()).spawn(sending).expect("a thread");
    let rest = next_lines(&mut lines, expected.lines().count() - 1);
    assert_eq!(read + &rest, expected);
    Ran::from(child.wait_with_output().expect("it ends")).expect_code(0);
}

#[test]
fn a_live_robot_needs_the_wheel_and_the_error_says_how_to_get_it() {
    for address in ["zenoh://robot/scan", "ros2://0/scan"] {
        let said = run(["run", address, "--out", "-"]).expect_code(2).stderr;
        assert!(said.contains("python/run --install"), "{said}");
        assert!(run(["report", address, "--out", "page.html"]).expect_code(2).stderr.contains("`crosscut run` and"));
    }
}
