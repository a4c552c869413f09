//! What the decision at gaps promises for all scenes of a kind: by width, by the number of beams, and by scale.

use crosscut_stage::{Point, Revolution, Value};

use super::{Segment, TUNNEL, all, components, scan, scan_as_far_as, scan_by, walls, with_branch, with_branch_at};

/// Tunnels, a dead end, side passages, a crossing, and walls that end before a wall across.
fn scenes() -> Vec<(&'static str, Vec<Segment>)> {
    let end = |x_m: f64| [[x_m, -2.0], [x_m, 2.0]];
    let corner =
        |x: f64, y: f64| [[[x * 2.0, y * 2.0], [x * 2.0, y * 30.0]], [[x * 2.0, y * 2.0], [x * 30.0, y * 2.0]]];
    let tee = [[[-30.0, 2.0], [4.0, 2.0]], [[-30.0, -2.0], [4.0, -2.0]], [[8.0, -30.0], [8.0, 30.0]]];
    vec![
        ("tunnel", TUNNEL.to_vec()),
        ("dead end", [&TUNNEL[..], &[end(6.0)]].concat()),
        ("branch of 2 m", with_branch(2.0)),
        ("branch of 3.5 m", with_branch(3.5)),
        ("branch far off", with_branch_at(6.0, 4.0)),
        ("crossing", [corner(1.0, 1.0), corner(-1.0, 1.0), corner(-1.0, -1.0), corner(1.0, -1.0)].concat()),
        ("tee", tee.to_vec()),
    ]
}

#[test]
fn a_wider_branch_is_never_closed_and_none_below_the_vehicles_width_is_open() {
    for near_m in [-1.0, 0.5, 2.0, 3.0] {
        let mut was_open = false;
        for width_m in (2..80).map(|tenths| 0.1 * f64::from(tenths)) {
            let is_open = walls(&scan(&with_branch_at(near_m, width_m), all)) > 2;
            assert!(!(is_open && width_m < 0.6), "{width_m} m wide, {near_m} m ahead: no vehicle passes");
            assert!(is_open || !was_open, "{width_m} m wide, {near_m} m ahead: closed, a narrower one is open");
            was_open |= is_open;
        }
        assert!(was_open, "{near_m} m ahead");
    }
}

#[test]
fn twice_the_beams_close_no_opening_of_exact_walls() {
    for (name, scene) in scenes() {
        let counts = [360, 720, 1440].map(|beams| walls(&scan_by(beams, &scene, all)));
        assert!(counts.is_sorted(), "{name}: {counts:?} walls");
    }
}

#[test]
fn scene_vehicle_and_lengths_scaled_together_have_the_same_walls() {
    let larger = |of: &Revolution, times: f64| {
        let mut scaled = of.clone();
        scaled.points_m.iter_mut().for_each(|point_m| *point_m = Point::from(point_m.coords * times));
        scaled.sweep.as_mut().expect("a sweep").range_max_m *= times;
        scaled
    };
    for (name, scene) in scenes() {
        let revolution = scan_as_far_as(15.0, 360, &scene, all);
        for times in [0.5, 2.0] {
            let lengths = [("width_m", 0.6), ("island_m", 2.0)];
            let settings = lengths.map(|(length, metres)| (length, Value::Float(times * metres)));
            let scaled = components(&larger(&revolution, times), &settings);
            assert_eq!(scaled, components(&revolution, &[]), "{name}, {times} times as large");
        }
    }
}

#[test]
fn a_side_wall_that_draws_back_before_a_wall_across_leaves_no_way() {
    // Both walls meet behind the end of the nearer one, where a vehicle could pass only if that one drew back farther.
    let dead_end = |ahead_m: f64, back_m: f64| {
        let (x, y) = (ahead_m + 1.0, 2.0 + back_m);
        let recess = [[[-30.0, 2.0], [ahead_m, 2.0]], [[ahead_m, 2.0], [ahead_m, y]], [[ahead_m, y], [x, y]]];
        scan(&[&recess[..], &[[[x, -2.0], [x, y]], TUNNEL[1]]].concat(), all)
    };
    let walls = |scan: &Revolution, settings: &[_]| components(scan, settings).iter().filter(|size| **size > 1).count();
    let without = [("without", vec!["odds"].into())];
    for (ahead_m, back_m) in [(3.0, 0.3), (3.0, 0.4), (5.0, 0.2), (5.0, 0.3)] {
        let scan = dead_end(ahead_m, back_m);
        assert_eq!((walls(&scan, &[]), walls(&scan, &without)), (1, 2), "{back_m} m, {ahead_m} m ahead");
    }
}
