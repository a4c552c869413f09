//! `crosscut sweep`: settings tried over flights, and again after it was killed.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::program::{Ran, run, shipped_flight};

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
    let names = ["sweep.csv", "sweep.parquet"].map(|name| out.join(name));
    names.iter().filter(|path| path.exists()).map(|path| std::fs::read(path).expect("written")).collect()
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
    sweep(&killed, &["--grid", "preset=threshold,default,dbscan", GRID[2], GRID[3]]).expect_code(0);
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
