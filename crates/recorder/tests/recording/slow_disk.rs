//! A disk slower than a live flight: the flight goes on, what is left out is counted, and the rest is there.

use std::fs::File;
use std::path::Path;
use std::process::Command;
use std::sync::mpsc;
use std::time::Duration;

use crosscut_recorder::{Recorder, RecorderOptions, Scope};
use crosscut_rrd::{Recording, Value};
use crosscut_stage::Observer as _;

use crate::frames;
use crate::reading::{self, options};

const REVOLUTIONS: u64 = 3000;

/// Records to a pipe that nobody reads until all revolutions were shown; returns what the end said.
fn record_to_a_stalled_pipe(pipe: &Path, saved: &Path) -> String {
    let (shown, all_shown) = mpsc::sync_channel(1);
    std::thread::scope(|scope| {
        let reader = std::thread::Builder::new().name("disk".to_owned()).spawn_scoped(scope, move || {
            let mut stalled = File::open(pipe).expect("the pipe opens when it is written to");
            // A recorder that waits for this disk never gets there: better an error than a test that hangs.
            let in_time = all_shown.recv_timeout(Duration::from_secs(120)).is_ok();
            std::io::copy(&mut stalled, &mut File::create(saved).expect("a file")).expect("read to the end");
            in_time
        });
        let options = RecorderOptions { live: true, ..options(pipe) };
        let mut recorder = Recorder::new(options).expect("a recorder");
        let mut frames: Vec<_> = (0..4).map(frames::frame).collect();
        for seq in 0..REVOLUTIONS {
            let frame = &mut frames[(seq % 4) as usize];
            (frame.revolution.seq, frame.revolution.stamp_ns) = (seq, frames::stamp_ns(seq));
            recorder.observe(frame).expect("the flight goes on");
        }
        shown.send(()).expect("the disk waits for this");
        let said = recorder.finish().expect_err("something was lost").to_string();
        drop(recorder); // closes the pipe
        assert!(reader.expect("a thread").join().expect("no panic"), "the flight waited for the disk");
        said
    })
}

#[test]
#[cfg(unix)]
fn a_live_flight_does_not_wait_for_the_disk_and_what_is_left_out_is_counted() {
    let folder = tempfile::tempdir().unwrap();
    let [pipe, saved] = ["pipe.rrd", "saved.rrd"].map(|name| folder.path().join(name));
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let said = record_to_a_stalled_pipe(&pipe, &saved);

    let recording = Recording::open(&saved).unwrap();
    assert_eq!(recording.damages(), []);
    let revolutions: Vec<i64> = recording.rows("/scan/ranges").unwrap().map(|row| row.unwrap().revolution).collect();
    let is_dark = |value| matches!(value, Value::Numbers(array) if array.to_f64().iter().all(|&w| w == 0.0));
    let pictures =
        recording.rows("/affinity/W").unwrap().map(|row| row.unwrap().value("EncodedDepthImage:blob").unwrap());
    let thinned = pictures.filter(|value| is_dark(value.clone())).count();
    let left_out = REVOLUTIONS as usize - revolutions.len();
    assert!(thinned > 100 && left_out > 100, "{thinned} thinned, {left_out} left out");
    assert!(
        said.contains(&format!("{thinned} revolutions")) && said.contains(&format!("{left_out} not at all")),
        "{said}"
    );
    let words: Vec<Value> =
        recording.rows("/log").unwrap().map(|row| row.unwrap().value("TextLog:text").unwrap()).collect();
    assert!(format!("{words:?}").contains("slower than the flight"), "{words:?}");
}

#[test]
#[cfg(unix)]
fn a_part_that_a_slow_disk_put_off_still_opens_alone() {
    let folder = tempfile::tempdir().unwrap();
    let [pipe, second] = ["pipe.rrd", "pipe-2.rrd"].map(|name| folder.path().join(name));
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let (go_on, may_go_on) = mpsc::sync_channel(1);
    std::thread::scope(|scope| {
        let pipe = &pipe;
        let disk = std::thread::Builder::new().name("disk".to_owned()).spawn_scoped(scope, move || {
            let mut stalled = File::open(pipe).expect("the pipe opens when it is written to");
            may_go_on.recv_timeout(Duration::from_secs(120)).expect("the flight goes on");
            std::io::copy(&mut stalled, &mut std::io::sink()).expect("read to the end");
        });
        // Flushed after a second, so after 10 revolutions, and the pipe takes less: at the 15th the disk lags behind.
        let scope = Scope { part_revolutions: 15.try_into().unwrap(), ..Scope::default() };
        let mut recorder = Recorder::new(RecorderOptions { live: true, scope, ..options(pipe) }).expect("a recorder");
        let mut record = |seq| recorder.observe(&frames::frame(seq)).expect("the flight goes on");
        (0..20).for_each(&mut record);
        assert!(!second.exists(), "the disk kept up, and this test tells nothing");
        go_on.send(()).expect("the disk waits for this");
        let begins = |seq| {
            std::thread::sleep(Duration::from_millis(100));
            record(seq);
            second.exists()
        };
        assert!((20..600).any(begins), "the part never begins");
        recorder.finish().expect("nothing is lost");
        drop(recorder); // closes the pipe
        disk.expect("a thread").join().expect("no panic");
    });
    let part = reading::Recording::read(&second);
    for entity in ["/config", "/scan/mounting", "/scan/beams", "/scan/rings", "/layout/extent"] {
        assert!(part.of(entity).next().is_some(), "{entity} is missing in a part");
    }
}
