//! A process killed at any moment leaves a recording that opens, with every revolution up to some point.

use std::io::{BufRead as _, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

use crosscut_recorder::Recorder;
use crosscut_rrd::{Damage, Recording};
use crosscut_stage::Observer as _;

use crate::frames;
use crate::reading::options;

/// Where the child process records to.
const CHILD_PATH: &str = "CROSSCUT_TEST_KILLED";
/// How often it is killed, after how many revolutions at most, and how long after such a revolution.
const KILLS: u64 = 16;
const MOST_REVOLUTIONS: u64 = 120;
const LONGEST: Duration = Duration::from_millis(100);
/// Ten minutes at 10 Hz: more than it gets to.
const REVOLUTIONS: u64 = 6000;
/// Those that may not be on the disk yet.
const ON_THEIR_WAY: u64 = 64;
/// What the child says of each revolution, with its number.
const RECORDED: &str = "recorded ";

const EVERY_REVOLUTION: [&str; 6] =
    ["/scan/ranges", "/scan/returns", "/affinity/W", "/spectral/eigenvalues", "/kmeans/labels", "/report/junctions"];

/// Records until it is killed.
#[test]
#[ignore = "run by the next test, which kills it"]
fn child_that_records_until_it_is_killed() {
    let path = PathBuf::from(std::env::var_os(CHILD_PATH).expect("the other test says where"));
    let mut frames: Vec<_> = (0..4).map(frames::frame).collect();
    let mut recorder = Recorder::new(options(&path)).unwrap();
    for seq in 0..REVOLUTIONS {
        let frame = &mut frames[(seq % 4) as usize];
        (frame.revolution.seq, frame.revolution.stamp_ns) = (seq, frames::stamp_ns(seq));
        recorder.observe(frame).unwrap();
        println!("\n{RECORDED}{seq}");
    }
}

/// Lets a child record to `path` up to this revolution and for a while longer, and kills it.
fn record_and_kill(path: &Path, revolution: u64, after: Duration) {
    let mut program = Command::new(std::env::current_exe().expect("the path of this program"));
    program.args(["--ignored", "--exact", "killing::child_that_records_until_it_is_killed", "--nocapture"]);
    program.env(CHILD_PATH, path);
    let mut child = program.stdout(Stdio::piped()).spawn().expect("this program starts");
    let mut said = BufReader::new(child.stdout.take().expect("it is piped")).lines().map_while(Result::ok);
    let reached = format!("{RECORDED}{revolution}");
    assert!(said.any(|line| line == reached), "the child ended before revolution {revolution}");
    std::thread::sleep(after);
    child.kill().expect("it was running");
    child.wait().expect("it ends");
}

#[test]
fn killed_at_any_moment_a_recording_opens_and_has_every_revolution_up_to_the_last_seconds() {
    let folder = tempfile::tempdir().unwrap();
    let mut random = 7_u64;
    let mut next_random = |below: u64| {
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (random >> 33) % below
    };
    for kill in 0..KILLS {
        let (reached, after) = (next_random(MOST_REVOLUTIONS), LONGEST.mul_f64(next_random(1000) as f64 / 1000.0));
        let path = folder.path().join(format!("{kill}.rrd"));
        record_and_kill(&path, reached, after);
        let recording = Recording::open(&path).unwrap();
        let damages = recording.damages();
        assert!(matches!(damages, [Damage::Unfinished { .. } | Damage::CutOff { .. }]), "{reached}: {damages:?}");
        for entity in EVERY_REVOLUTION {
            let there = recording.entities().contains_key(entity);
            let rows = if there {
                recording.rows(entity).unwrap().map(|row| row.unwrap().revolution).collect()
            } else {
                vec![]
            };
            assert!(rows.iter().copied().eq(0..rows.len() as i64), "{entity}, killed {after:?} after {reached}");
            assert!(
                rows.len() as u64 + ON_THEIR_WAY > reached,
                "{entity}: {} rows at revolution {reached}",
                rows.len()
            );
        }
    }
}
