//! `crosscut sweep`: settings tried over flights, and again after it was killed.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::flight::{Writing, file, tunnel};
use crate::program::{Ran, crosscut, run, shipped_flight};

fn sweep(out: &Path, more: &[&str]) -> Ran {
    let flight = shipped_flight();
    let fixed = [Path::new("sweep"), &flight, Path::new("--quiet"), Path::new("--out"), out];
    run(fixed.into_iter().chain(more.iter().map(Path::new)))
}

const GRID: [&str; 4] = ["--grid", "preset=threshold,default", "--grid", "vehicle.width_m=0.6,1.2"];

/// The rows of a CSV file without quotes, by column.
fn rows(path: &Path) -> Vec<BTreeMap<String, String>> {
    let text = std::fs::read_to_string(path).expect("written");
    let mut lines = text.lines().map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
    let header = lines.next().expect("a header");
    lines.map(|cells| header.iter().cloned().zip(cells).collect()).collect()
}

/// The files that hold of the answers alone.
fn answers(out: &Path) -> Vec<Vec<u8>> {
    vec![std::fs::read(out.join("sweep.csv")).expect("written")]
}

fn kept(out: &Path) -> Vec<PathBuf> {
    let files = std::fs::read_dir(out.join("rows")).expect("a folder").map(|file| file.expect("a file").path());
    let mut files: Vec<PathBuf> = files.collect();
    files.sort();
    files
}

#[test]
fn a_sweep_agrees_with_evaluate_for_every_combination() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().join("sweep");
    sweep(&out, &GRID).expect_code(0);
    let rows = rows(&out.join("sweep.csv"));
    assert_eq!(rows.len(), 4);
    let json = folder.path().join("evaluated.json");
    let with: Vec<String> =
        rows.iter().map(|row| format!("{},vehicle.width_m={}", row["preset"], row["vehicle.width_m"])).collect();
    let mut args = vec!["evaluate".to_owned(), shipped_flight().display().to_string(), "--quiet".to_owned()];
    args.extend(with.iter().flat_map(|with| ["--with".to_owned(), with.clone()]));
    args.extend(["--json".to_owned(), json.display().to_string()]);
    run(&args).expect_code(0);
    let evaluated: Value = serde_json::from_slice(&std::fs::read(&json).expect("written")).expect("JSON");
    for (row, result) in rows.iter().zip(evaluated["all"].as_array().expect("configurations")) {
        let right = &result["figures"]["right"];
        let share = right["hits"].as_f64().expect("a number") / right["of"].as_f64().expect("a number");
        assert!((row["right"].parse::<f64>().expect("a number") - share).abs() < 1e-12, "{row:?} {right}");
    }
    for picture in ["preset.svg", "vehicle.width_m.svg"] {
        assert!(std::fs::read_to_string(out.join(picture)).expect("written").starts_with("<svg "));
    }
}

#[test]
fn a_sweep_that_was_killed_goes_on_and_ends_with_the_same_bytes() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (whole, killed) = (folder.path().join("whole"), folder.path().join("killed"));
    sweep(&whole, &GRID).expect_code(0);
    sweep(&killed, &GRID).expect_code(0);
    // As a kill leaves it: one result missing, one half written.
    let files = kept(&killed);
    std::fs::remove_file(&files[0]).expect("removed");
    std::fs::write(&files[1], "{\"figures\":").expect("written");
    std::fs::remove_file(killed.join("sweep.csv")).expect("removed");
    let untouched = std::fs::metadata(&files[2]).expect("there").modified().expect("a time");
    sweep(&killed, &[&GRID[..], &["--jobs", "1"]].concat()).expect_code(0);
    assert_eq!(answers(&killed), answers(&whole));
    assert_eq!(std::fs::metadata(&files[2]).expect("there").modified().expect("a time"), untouched);
    // A wider grid keeps what is there.
    sweep(&killed, &["--grid", "preset=threshold,default,breakpoint", GRID[2], GRID[3]]).expect_code(0);
    assert_eq!(kept(&killed).len(), 6);
}

#[test]
fn a_grid_that_cannot_be_is_refused_before_anything_runs() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().join("sweep");
    for (grid, words) in [
        ("affinity.sigma=1,2", "at affinity.sigma=1: --set: affinity of kind \"passage\" has no sigma"),
        ("spectral.zero_tolerance=-1", "zero_tolerance"),
        ("preset=best", "best"),
        ("affinity.kind", "KEY=V1,V2"),
    ] {
        let refused = sweep(&out, &["--grid", grid]).expect_code(2).stderr;
        assert!(refused.contains(words), "{refused}");
    }
    assert!(!out.join("sweep.csv").exists());
    let other = folder.path().join("notes.txt");
    std::fs::write(&other, "no recording").expect("written");
    let failed =
        run([Path::new("sweep"), &other, Path::new("--grid"), Path::new("preset=paper"), Path::new("--out"), &out]);
    assert!(failed.expect_code(1).stderr.contains("left out"));
}

#[test]
fn a_flight_that_lost_scans_is_reported_by_later_sweeps_too() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let whole = tunnel(REVOLUTIONS, &Writing::default());
    let flight = file(folder.path(), "cut.mcap", &whole[..whole.len() / 2]);
    let out = folder.path().join("sweep");
    let args = [Path::new("sweep"), &flight, Path::new("--grid=preset=threshold"), Path::new("--out"), &out];
    for of_this_sweep in ["first", "second"] {
        let said = run(args).expect_code(3).stderr;
        assert!(said.contains("lost: ") && !said.contains("left out"), "{of_this_sweep}: {said}");
    }
    assert_eq!(kept(&out).len(), 1);
}

#[test]
fn a_flight_that_cannot_be_decoded_is_read_by_the_next_sweep() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut bytes = tunnel(3, &Writing { chunked: false, ..Writing::default() });
    let header = [0, 1, 0, 0]; // of CDR, before the stamp of the scan
    let stamp = |scan: i32| [header, [0; 4], (scan * 100_000_000).to_le_bytes()].concat();
    for scan in 1..=3 {
        let at = bytes.windows(12).position(|window| window == stamp(scan)).expect("the scan is there");
        bytes[at + 1] = 0xFF;
    }
    let flight = file(folder.path(), "broken.mcap", &bytes);
    let out = folder.path().join("sweep");
    let args = [Path::new("sweep"), &flight, Path::new("--grid=preset=threshold"), Path::new("--out"), &out];
    for _ in 0..2 {
        let said = run(args).expect_code(1).stderr;
        assert!(said.contains("left out: none of the 3 messages of /scan can be decoded"), "{said}");
    }
    assert!(kept(&out).is_empty());
}

const REVOLUTIONS: u64 = 40;
const MORE: [&str; 4] = ["--grid", "spectral.zero_tolerance=1e-3,1e-2,3e-4,0.1", "--grid", "kmeans.seed=0,7"];

#[test]
fn two_sweeps_at_once_share_a_folder() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let flight = file(folder.path(), "flight.mcap", &tunnel(REVOLUTIONS, &Writing::default()));
    // A second name of the same flight, so that its rows are written by two threads as well.
    let twin = folder.path().join("twin.mcap");
    std::fs::copy(&flight, &twin).expect("copied");
    let [shared, alone] = ["shared", "alone"].map(|name| folder.path().join(name));
    let args = |out: &Path| {
        let inputs = [flight.clone(), twin.clone(), "--preset=paper".into(), "--quiet".into(), "--jobs=2".into()];
        let more = MORE.iter().map(PathBuf::from).chain(["--out".into(), out.to_owned()]);
        std::iter::once(PathBuf::from("sweep")).chain(inputs).chain(more).collect::<Vec<_>>()
    };
    let mut both = [0; 2].map(|_| crosscut(args(&shared)).spawn().expect("the program starts"));
    assert!(both.iter_mut().all(|child| child.wait().expect("it ends").success()));
    run(args(&alone)).expect_code(0);
    assert_eq!(answers(&shared), answers(&alone));
    assert_eq!(kept(&shared).len(), 8, "nothing unfinished is left, and both names of the flight share their rows");
}
