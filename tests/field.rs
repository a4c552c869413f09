//! Recordings of other people's robots, where they are at hand: what they had wrong.

use std::path::PathBuf;

use serde_json::Value;

use crate::program::{Ran, crosscut, results_of, root, run};

/// A case; a note is printed where it is absent.
fn case(name: &str) -> Option<PathBuf> {
    let path = root().join("../shared/cases").join(name);
    if !path.exists() {
        println!("skipped: {} is absent", path.display());
    }
    path.exists().then_some(path)
}

fn has_note(lines: &[Value], part: &str) -> bool {
    let notes = lines.iter().filter_map(|line| line["notes"].as_array()).flatten();
    notes.filter_map(Value::as_str).any(|note| note.contains(part))
}

fn share(lines: &[Value], holds: impl Fn(&Value) -> bool) -> f64 {
    lines.iter().filter(|line| holds(line)).count() as f64 / lines.len() as f64
}

#[test]
fn odometry_that_never_moves_is_not_believed() {
    for name in ["odom_zero", "twist_only", "fake_tf"] {
        let Some(path) = case(&format!("T01-odometry-still/{name}.mcap")) else { return };
        let (_, lines) = results_of(&path, &[]);
        let end_m = lines.last().and_then(|line| line["pose"]["x_m"].as_f64()).expect("a pose");
        assert!((end_m - 99.75).abs() < 1.5, "{name}: {end_m} m");
    }
}

#[test]
fn an_altered_recording_of_ours_is_told_and_takes_no_memory() {
    for name in ["missing", "step"] {
        let Some(path) = case(&format!("B11-rrd-forged-sweep/{name}.rrd")) else { return };
        for command in ["run", "report", "debug"] {
            let folder = tempfile::tempdir().expect("a temporary folder");
            let mut altered = crosscut([command.as_ref(), path.as_os_str()]);
            let out = folder.path().join("out.html");
            let altered = if command == "report" { altered.arg("-o").arg(out) } else { &mut altered };
            let ran = Ran::from(altered.stdin(std::process::Stdio::null()).output().expect("it starts"));
            assert!(ran.stderr.contains("this is no scan"), "{command} {name}: {}", ran.stderr);
            assert!(matches!(ran.code, Some(1 | 3)), "{command} {name}: {:?}", ran.code);
        }
    }
}

#[test]
fn dark_ends_of_a_tunnel_are_no_blind_sectors() {
    for name in ["rail", "steady"] {
        let Some(path) = case(&format!("T02-blind-sectors/{name}.mcap")) else { return };
        let (_, lines) = results_of(&path, &[]);
        let corridors = share(&lines, |line| line["place"] == "corridor");
        assert!(corridors > 0.9 && !has_note(&lines, "taken as blind"), "{name}: {corridors}");
    }
}

#[test]
fn a_mount_that_the_recording_states_is_used() {
    for (name, turned_rad) in [("turned_90", 1.57), ("upside_down", 0.0)] {
        let Some(path) = case(&format!("T04-mount-in-tf/{name}.mcap")) else { return };
        let (_, lines) = results_of(&path, &[]);
        assert!(has_note(&lines, "by /tf_static"), "{name}, turned by {turned_rad}");
        assert!(share(&lines, |line| line["pose"]["y_m"].as_f64().is_some_and(|y_m| y_m.abs() < 0.5)) > 0.99);
        let end_m = lines.last().and_then(|line| line["pose"]["x_m"].as_f64()).expect("a pose");
        assert!(end_m > 35.0, "{name}: {end_m} m");
    }
}

#[test]
fn the_length_of_a_smooth_tunnel_is_not_known() {
    let Some(path) = case("T06-smooth-tunnel/smooth.mcap") else { return };
    let (_, lines) = results_of(&path, &[]);
    assert!(has_note(&lines, "its length is not known"));
    assert_eq!(lines.last().expect("some")["pose"]["sd_m"], Value::Null);
}

#[test]
fn undoing_the_turn_is_no_worse_than_leaving_it() {
    for name in ["tee_cw", "tee_ccw"] {
        let Some(path) = case(&format!("T08-rplidar-time-order/{name}.mcap")) else { return };
        let right = |more: &[&str]| share(&results_of(&path, more).1, |line| line["junctions"] == 3);
        let (with, without) = (right(&[]), right(&["--set", "ingest.deskew=false"]));
        assert!(with >= without, "{name}: {with} with, {without} without");
    }
}

fn of(lines: &[Value], holds: impl Fn(&Value) -> bool) -> usize {
    lines.iter().filter(|line| holds(line)).count()
}

fn end_m(lines: &[Value]) -> f64 {
    lines.last().and_then(|line| line["pose"]["x_m"].as_f64()).expect("a pose")
}

#[test]
fn names_and_units_that_only_look_like_those_meant_are_not_taken() {
    if let Some(path) = case("R01-carmen-parameter/parameters.clf") {
        let (_, lines) = results_of(&path, &[]);
        assert_eq!(of(&lines, |line| line["returns"] == 181), lines.len());
    }
    let (Some(one), Some(nested)) =
        (case("R04-header-levels/one_level.csv"), case("R04-header-levels/nested_levels.csv"))
    else {
        return;
    };
    let [one, nested] = [one, nested].map(|path| results_of(&path, &[]).1);
    assert!(one.iter().zip(&nested).all(|(one, nested)| {
        ["stamp_ns", "junctions", "pose", "place", "labels"].iter().all(|field| one[field] == nested[field])
    }));
    let Some(path) = case("U07-time-of-simulation/topic.csv") else { return };
    let (_, lines) = results_of(&path, &[]);
    let stamps = [&lines[0], lines.last().expect("some")].map(|line| line["stamp_ns"].as_u64().expect("a stamp"));
    assert_eq!(stamps, [112_439_000_000, 120_239_000_000]);
}

#[test]
fn odometry_in_the_line_of_a_scan_needs_no_stamp() {
    let Some(path) = case("R02-no-stamps/zero.clf") else { return };
    let (_, lines) = results_of(&path, &[]);
    assert!((end_m(&lines) - 14.75).abs() < 0.02, "{}", end_m(&lines));
}

#[test]
fn lists_of_returns_are_turns() {
    for (name, turns) in [("varying_beams", 12), ("clockwise_rad", 8)] {
        let Some(path) = case(&format!("U11-list-of-angle-and-distance/{name}.csv")) else { return };
        let (_, lines) = results_of(&path, &[]);
        assert_eq!((lines.len(), of(&lines, |line| line["returns"].as_u64() > Some(60))), (turns, turns), "{name}");
    }
    let Some(path) = case("U12-table-of-x-and-y/xy_mm.csv") else { return };
    let (_, lines) = results_of(&path, &[]);
    assert_eq!((lines.len(), &lines[0]["place"]), (1, &Value::from("tee")));
    let Some(path) = case("U13-label-column/label_last.csv") else { return };
    let info = run(["info", path.to_str().expect("UTF-8"), "--set", "csv.last_rad=6.2657"]).stdout;
    assert!(info.contains("column 361 (words) is not used"), "{info}");
}

#[test]
fn packets_of_uneven_motors_are_joined() {
    for name in ["constant", "jitter_0.1pct", "ramp", "slow_4pct"] {
        let Some(path) = case(&format!("U15-packets-of-varying-rate/{name}.mcap")) else { return };
        let (_, lines) = results_of(&path, &[]);
        let tees = of(&lines, |line| line["place"] == "tee");
        assert!((14..=16).contains(&lines.len()) && tees + 2 >= lines.len(), "{name}: {tees} of {}", lines.len());
    }
}

#[test]
fn odometry_of_another_alignment_is_read() {
    for name in ["aligned", "connext_micro"] {
        let Some(path) = case(&format!("U10-odometry-unreadable/{name}.mcap")) else { return };
        assert!((end_m(&results_of(&path, &[]).1) - 5.9).abs() < 0.02, "{name}");
    }
}

#[test]
fn a_slice_without_returns_says_where_the_points_are() {
    let Some(path) = case("U14-cloud-above-the-slice/cloud.mcap") else { return };
    assert!(has_note(&results_of(&path, &[]).1, "by vehicle.height_m"));
}

#[test]
fn noise_that_is_cut_off_at_the_limit_is_no_return() {
    let Some(path) = case("U01-clipped-noise/empty.mcap") else { return };
    let (_, lines) = results_of(&path, &[]);
    assert_eq!(of(&lines, |line| line["junctions"] == 0 && line["returns"].as_u64() < Some(4)), lines.len());
}

/// How far the vehicle is ahead at the end of a flight by its scans, where it is truly, and how far off it may be.
#[test]
fn what_is_in_view_shows_how_far_a_vehicle_came_without_odometry() {
    for (name, true_m, off_m) in [
        ("R04-header-levels/one_level.csv", 9.75, 0.1),
        ("U02-pose-stuck/tee.mcap", 12.8, 0.6),
        ("U04-fast-steps/rough_0.8m.mcap", 43.2, 0.5),
        ("U08-chassis-holds-pose/chassis.mcap", 11.85, 0.3),
    ] {
        let Some(path) = case(name) else { return };
        let (_, lines) = results_of(&path, &[]);
        let end_m = lines.last().and_then(|line| line["pose"]["x_m"].as_f64()).expect("a pose");
        assert!((end_m - true_m).abs() < off_m, "{name}: {end_m} m");
    }
}

#[test]
fn the_vehicle_in_its_own_scan_is_named() {
    let Some(path) = case("U08-chassis-holds-pose/chassis.mcap") else { return };
    let (_, lines) = results_of(&path, &[]);
    assert!(has_note(&lines, "the vehicle itself is in view, at 0.4"));
    let (_, lines) = results_of(&path, &["--set", "ingest.min_range_m=0.50"]);
    assert!(!has_note(&lines, "the vehicle itself") && (end_m(&lines) - 11.85).abs() < 0.3);
}

#[test]
fn directions_of_a_driver_are_told_from_bad_odometry() {
    let Some(path) = case("U09-turned-or-mirrored/turned180.mcap") else { return };
    for (set, setting) in [
        ("ingest.yaw_rad=0", "turned by 180 degrees: a direction is wrong, no motion; ingest.yaw_rad = -3.141 turns"),
        ("ingest.yaw_rad=2.356", "turned by -45 degrees: a direction is wrong, no motion; ingest.yaw_rad = "),
        ("ingest.yaw_rad=3.14159", ""),
    ] {
        let (_, lines) = results_of(&path, &["--set", set]);
        let is_blamed = ["a slip or a jump", "they contradict"].iter().any(|part| has_note(&lines, part));
        let is_told = has_note(&lines, "a direction is wrong");
        assert!(!is_blamed && is_told != setting.is_empty() && has_note(&lines, setting), "{set}");
    }
    let mirrored = ["--set", "ingest.yaw_rad=3.14159", "--set", "ingest.upside_down=true"];
    let (_, lines) = results_of(&path, &mirrored);
    assert!(has_note(&lines, "the scans mirrored: a direction is wrong") && !has_note(&lines, "a slip or a jump"));
}
