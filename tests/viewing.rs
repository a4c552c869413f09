//! `crosscut view`: the data that reaches the viewer.

use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};

use crate::flight::{Writing, file, tunnel};
use crate::program::{Ran, crosscut, run};

/// A recording of five revolutions.
fn recording(folder: &Path, name: &str) -> PathBuf {
    let flight = file(folder, "tunnel.mcap", &tunnel(5, &Writing::default()));
    let saved = folder.join(name);
    run(["run".as_ref(), flight.as_os_str(), "--quiet".as_ref(), "--save".as_ref(), saved.as_os_str()]).expect_code(0);
    saved
}

/// Runs `crosscut view` with a viewer that stores its input; returns how it ended, and the input.
fn view(folder: &Path, args: &[&Path]) -> (Ran, PathBuf) {
    let (bin, given) = (folder.join("bin"), folder.join("given.rrd"));
    std::fs::create_dir_all(&bin).expect("a folder");
    let viewer = bin.join("rerun");
    std::fs::write(&viewer, format!("#!/bin/sh\nexec cat > '{}'\n", given.display())).expect("written");
    std::fs::set_permissions(&viewer, std::fs::Permissions::from_mode(0o755)).expect("set");
    let path = format!("{}:{}", bin.display(), std::env::var("PATH").unwrap_or_default());
    let ran = crosscut([Path::new("view")].iter().chain(args)).env("PATH", path).output().expect("it starts");
    (ran.into(), given)
}

/// The entities that `crosscut rrd ls` lists.
fn entities(recording: &Path) -> String {
    run(["rrd".as_ref(), "ls".as_ref(), recording.as_os_str()]).stdout
}

#[test]
fn a_recording_reaches_the_viewer_whole() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let saved = recording(folder.path(), "flight.rrd");
    let (ran, given) = view(folder.path(), &[&saved]);
    ran.expect_code(0);
    // Data piped to a viewer has no footer, like a recording that was cut off.
    let diff = run(["rrd".as_ref(), "diff".as_ref(), saved.as_os_str(), given.as_os_str()]).expect_code(3);
    assert!(diff.stdout.starts_with("the same") && !diff.stdout.contains("differ"), "{}\n{}", diff.stdout, diff.stderr);
    assert!(entities(&given).contains("/affinity/W"));
}

#[test]
fn two_recordings_have_separate_entities() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (left, right) = (recording(folder.path(), "left.rrd"), recording(folder.path(), "right.rrd"));
    let (ran, given) = view(folder.path(), &[&left, Path::new("--beside"), &right]);
    ran.expect_code(0);
    let listed = entities(&given);
    for entity in ["/left/scan/returns", "/right/scan/returns", "/left/report/junctions", "/right/report/junctions"] {
        assert!(listed.contains(entity), "{entity} in\n{listed}");
    }
    assert!(!listed.contains(" /scan/returns"), "{listed}");
    let beside = Path::new("--beside");
    for more in [left.as_path(), Path::new("robot.mcap")] {
        view(folder.path(), &[&left, beside, &right, beside, more]).0.expect_code(2);
    }
}

#[test]
fn a_damaged_recording_is_shown_up_to_the_damage() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let saved = recording(folder.path(), "flight.rrd");
    let bytes = std::fs::read(&saved).expect("saved");
    std::fs::write(&saved, &bytes[..bytes.len() * 2 / 3]).expect("written");
    let (ran, given) = view(folder.path(), &[&saved]);
    let ran = ran.expect_code(3);
    let lost = |said: &str| said.lines().find(|line| line.starts_with("lost: cut off")).map(str::to_owned);
    let listed = run([Path::new("rrd"), Path::new("ls"), &saved]).expect_code(3).stderr;
    assert!(lost(&listed).is_some_and(|line| line.contains("flight.rrd")), "{listed}");
    assert_eq!(lost(&ran.stderr), lost(&listed), "how far it is whole");
    assert!(entities(&given).contains("/config"));
}

#[test]
fn parts_are_shown_together_and_missing_ones_reported() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let flight = file(folder.path(), "tunnel.mcap", &tunnel(5, &Writing::default()));
    let [first, second] = ["long.rrd", "long-2.rrd"].map(|name| folder.path().join(name));
    let save = [
        "--quiet".as_ref(),
        "--set".as_ref(),
        "recording.part_revolutions=2".as_ref(),
        "--save".as_ref(),
        first.as_os_str(),
    ];
    run(["run".as_ref(), flight.as_os_str()].into_iter().chain(save)).expect_code(0);
    let (ran, given) = view(folder.path(), &[&first]);
    ran.expect_code(0);
    let whole = run(["rrd".as_ref(), "ls".as_ref(), given.as_os_str()]);
    assert!(whole.stdout.contains("0 to 4") && !whole.stderr.contains("part"), "{}\n{}", whole.stdout, whole.stderr);
    std::fs::remove_file(second).expect("it was there");
    let said = view(folder.path(), &[&first]).0.expect_code(3).stderr;
    assert!(said.contains("part 2 is missing"), "{said}");
}

#[test]
fn without_a_viewer_it_says_how_to_get_one() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let saved = recording(folder.path(), "flight.rrd");
    let ran: Ran = crosscut([Path::new("view"), &saved]).env("PATH", "").output().expect("it starts").into();
    assert!(ran.expect_code(1).stderr.contains("pip install rerun-sdk"));
}

#[test]
fn a_file_that_is_no_recording_starts_no_viewer() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let text = folder.path().join("notes.txt");
    std::fs::write(&text, "no recording\n").expect("written");
    let (ran, given) = view(folder.path(), &[&text]);
    let ran = ran.expect_code(1);
    assert!(ran.stderr.contains("notes.txt"), "{}", ran.stderr);
    assert!(!given.exists());
}
