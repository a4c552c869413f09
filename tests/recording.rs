//! `--save`: the recording of all stages.

use crate::flight::{Writing, bytes, file, tunnel, tunnel_scan};
use crate::program::{Ran, crosscut, lines, results_of, run, shipped_flight};

#[test]
fn saving_a_recording_does_not_change_the_results() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let saved = folder.path().join("tee.rrd");
    let (input, every) = (shipped_flight(), ["--every", "8", "--quiet"]);
    let with = results_of(&input, &[&every[..], &["--save", saved.to_str().expect("UTF-8")]].concat());
    assert_eq!(with.0.expect_code(0).stdout, results_of(&input, &every).0.expect_code(0).stdout);
    let bytes = std::fs::read(saved).expect("saved");
    assert!(bytes.starts_with(b"RRF"), "it starts as a Rerun recording does");
    assert!(bytes.len() > 20_000, "{} bytes", bytes.len());
}

#[test]
fn a_recording_that_cannot_be_written_leaves_complete_results() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let flight = file(folder.path(), "tunnel.mcap", &tunnel(5, &Writing::default()));
    let nowhere = folder.path().join("no/such/folder/flight.rrd");
    let (ran, lines) = results_of(&flight, &["--save", nowhere.to_str().expect("UTF-8")]);
    let ran = ran.expect_code(3);
    assert_eq!(lines.len(), 5);
    assert!(ran.stderr.contains("no/such/folder"), "{}", ran.stderr);
}

#[test]
fn an_empty_recording_can_be_read() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let flight = file(folder.path(), "tunnel.mcap", &tunnel(5, &Writing::default()));
    let saved = folder.path().join("none.rrd");
    let saved = saved.to_str().expect("UTF-8");
    run(["run", flight.to_str().expect("UTF-8"), "--from", "100", "--save", saved]).expect_code(1);
    run(["rrd", "ls", saved]).expect_code(0);
}

#[test]
fn an_empty_recording_is_reported() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let flight = file(folder.path(), "tunnel.mcap", &tunnel(5, &Writing::default()));
    let saved = folder.path().join("none.rrd");
    let said = |more: &[&str]| {
        let save = ["run", flight.to_str().expect("UTF-8"), "--quiet", "--save", saved.to_str().expect("UTF-8")];
        run([&save, more].concat()).expect_code(0).stderr
    };
    for beyond in ["recording.revolutions=[[500, 600]]", "recording.spans_s=[[100, inf]]"] {
        assert!(said(&["--set", beyond]).contains("the recording is empty"), "{beyond:?}");
    }
    assert_eq!(said(&["--set", "recording.revolutions=[[4, inf]]"]), "");
}

#[test]
fn a_recording_of_a_run_that_failed_says_why() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut scans: Vec<_> = (0..4).map(tunnel_scan).collect();
    scans[2].ranges = vec![3.0; 2000];
    scans[2].angle_increment *= 180.0 / 2000.0;
    let flight = file(folder.path(), "tunnel.mcap", &bytes(&scans, &Writing::default()));
    let [saved, log] = ["tunnel.rrd", "log.csv"].map(|name| folder.path().join(name).display().to_string());
    let failing = ["--preset", "paper", "--set", "pipeline.memory_mb=40", "--save", &saved];
    let (ran, lines) = results_of(&flight, &failing);
    assert_eq!((ran.expect_code(1).stdout.lines().count(), lines.len()), (2, 2));
    run(["rrd", "get", &saved, "/log:TextLog:text", "--at", "2", "--out", &log]).expect_code(0);
    let said = std::fs::read_to_string(log).expect("written");
    assert!(said.contains("affinity failed on revolution 2: 2000 returns would need"), "{said}");
}

#[test]
fn an_outlier_range_does_not_enlarge_the_recording() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let saved_bytes = |first_range_m: f32| {
        let mut scans: Vec<_> = (0..3).map(tunnel_scan).collect();
        scans.iter_mut().for_each(|scan| scan.range_max = 0.0); // no limit
        scans[0].ranges[0] = first_range_m;
        let flight = file(folder.path(), "wild.mcap", &bytes(&scans, &Writing::default()));
        let saved = folder.path().join("wild.rrd");
        let saved_to = saved.to_str().expect("UTF-8");
        run(["run", flight.to_str().expect("UTF-8"), "--save", saved_to, "--quiet"]).expect_code(0);
        saved.metadata().expect("saved").len()
    };
    let usual = saved_bytes(8.0);
    for wild_m in [1e8, 2e9, 1e30, f32::MAX] {
        let bytes = saved_bytes(wild_m);
        assert!(bytes < usual + usual / 4, "{bytes} instead of {usual} bytes for a range of {wild_m} m");
    }
}

#[test]
fn without_a_viewer_the_recording_is_saved_with_code_3() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let flight = file(folder.path(), "tunnel.mcap", &tunnel(5, &Writing::default()));
    let saved = folder.path().join("tunnel.rrd");
    let ran: Ran =
        crosscut(["run".as_ref(), flight.as_os_str(), "--view".as_ref(), "--save".as_ref(), saved.as_os_str()])
            .env("PATH", folder.path())
            .output()
            .expect("the program starts")
            .into();
    let ran = ran.expect_code(3);
    assert!(ran.stderr.contains("pip install rerun-sdk"), "how to get one: {}", ran.stderr);
    assert!(saved.metadata().expect("saved").len() > 20_000);
}

#[test]
#[cfg(unix)]
fn a_full_disk_leaves_complete_results_and_a_readable_recording() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let saved = folder.path().join("flight.rrd");
    let arguments = ["run", "--preset", "paper", "--every", "2", "--quiet", "--out", "-", "--save"];
    let crosscut = crosscut(arguments);
    // With SIGXFSZ ignored, a write beyond the limit (8000 blocks of 512 bytes or more) is an error as on a full disk.
    let mut limited = std::process::Command::new("sh");
    limited.args(["-c", "trap '' XFSZ; ulimit -f 8000; exec \"$0\" \"$@\""]).arg(crosscut.get_program());
    limited.args(crosscut.get_args()).arg(&saved).arg(shipped_flight());
    let ran = Ran::from(limited.output().expect("a shell")).expect_code(3);
    assert_eq!(lines(&ran.stdout).len(), 71);
    assert!(ran.stderr.contains("File too large") && ran.stderr.contains("flight.rrd"), "{}", ran.stderr);
    let listed = run(["rrd", "ls", saved.to_str().expect("UTF-8")]).expect_code(3);
    assert!(
        listed.stdout.contains("/scan/ranges") && listed.stderr.contains("without its footer"),
        "{}",
        listed.stderr
    );
}

#[test]
fn a_run_whose_only_output_fails_ends_at_once() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let save = folder.path().join("nowhere").join("flight.rrd");
    let arguments = |more: &'static [&'static str]| {
        let flight = shipped_flight().into_os_string();
        ["run", "--quiet", "--save"]
            .map(Into::into)
            .into_iter()
            .chain([save.clone().into_os_string(), flight])
            .chain(more.iter().map(Into::into))
    };
    let ran = run(arguments(&[])).expect_code(1);
    assert!(ran.stderr.starts_with("lost: ") && ran.stderr.contains("error: no other output"), "{}", ran.stderr);
    let ran = run(arguments(&["--out", "-"])).expect_code(3);
    assert!(ran.stderr.starts_with("lost: ") && lines(&ran.stdout).len() == 141, "{}", ran.stderr);
}
