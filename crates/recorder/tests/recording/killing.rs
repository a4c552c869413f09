//! A process killed at any moment leaves a recording that opens, with every revolution up to some point.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use crosscut_recorder::{Damage, Recorder, Recording};
use crosscut_stage::Observer as _;

use crate::frames;
use crate::reading::options;

/// Where the child process records to.
const CHILD_PATH: &str = "CROSSCUT_TEST_KILLED";
/// How often it is killed, and how long it runs at most.
const KILLS: u64 = 16;
const LONGEST: Duration = Duration::from_millis(1500);
/// Ten minutes at 10 Hz: more than it gets to.
const REVOLUTIONS: u64 = 6000;

const EVERY_REVOLUTION: [&str; 6] =
    ["/scan/ranges", "/scan/returns", "/affinity/W", "/spectral/eigenvalues", "/kmeans/labels", "/report/junctions"];

/// Not a test of its own: what the next one kills. Records until then.
#[test]
fn child_that_records_until_it_is_killed() {
    let Some(path) = std::env::var_os(CHILD_PATH).map(PathBuf::from) else { return };
    let mut frames: Vec<_> = (0..4).map(frames::frame).collect();
    let mut recorder = Recorder::new(options(&path)).unwrap();
    for seq in 0..REVOLUTIONS {
        let frame = &mut frames[(seq % 4) as usize];
        (frame.revolution.seq, frame.revolution.stamp_ns) = (seq, frames::stamp_ns(seq));
        recorder.observe(frame).unwrap();
    }
}

/// Lets a child record to `path` for a while after the file is there, and kills it.
fn record_and_kill(path: &Path, after: Duration) {
    let mut program = Command::new(std::env::current_exe().expect("the path of this program"));
    program.args(["--exact", "killing::child_that_records_until_it_is_killed"]).env(CHILD_PATH, path);
    let mut child = program.stdout(std::process::Stdio::null()).spawn().expect("this program starts");
    let patience = Instant::now();
    while !path.exists() && patience.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(1));
    }
    std::thread::sleep(after);
    child.kill().expect("it was running");
    child.wait().expect("it ends");
}

#[test]
fn killed_at_any_moment_a_recording_opens_and_has_every_revolution_up_to_some_point() {
    let folder = tempfile::tempdir().unwrap();
    let mut random = 7_u64;
    let mut longest = 0;
    for kill in 0..KILLS {
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let after = LONGEST.mul_f64((random >> 11) as f64 / (1_u64 << 53) as f64);
        let path = folder.path().join(format!("{kill}.rrd"));
        record_and_kill(&path, after);
        let recording = Recording::open(&path).unwrap();
        let damages = recording.damages();
        assert!(matches!(damages, [Damage::Unfinished { .. } | Damage::CutOff { .. }]), "{after:?}: {damages:?}");
        for entity in EVERY_REVOLUTION.into_iter().filter(|entity| recording.entities().contains_key(*entity)) {
            let revolutions: Vec<i64> = recording.rows(entity).unwrap().map(|row| row.unwrap().revolution).collect();
            assert!(revolutions.iter().copied().eq(0..revolutions.len() as i64), "{entity}, killed after {after:?}");
            longest = longest.max(revolutions.len());
        }
    }
    assert!(longest > 0, "no child got beyond revolution {longest}: nothing was tested");
}
