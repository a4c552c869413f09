//! Recordings of other people's robots, where they are at hand: what they had wrong.

use std::path::PathBuf;

use serde_json::Value;

use crate::program::{results_of, root};

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
