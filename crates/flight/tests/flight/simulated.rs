//! Poses on simulated flights, against the true ones.

use crosscut_flight::{PoseTracker, Tracked};
use crosscut_sensor::Sensor;
use crosscut_simulator::Scene;
use crosscut_stage::{Notes, Params, Revolution, Value};
use nalgebra::{Isometry2, Vector2};

use crate::scenario;

fn flight(name: &str, seed: u64, revolutions: usize) -> Vec<Scene> {
    (scenario(name).fly)(seed).take(revolutions).collect()
}

fn true_pose(scene: &Scene) -> Isometry2<f64> {
    let pose = scene.pose.expect("a scene of a flight");
    Isometry2::new(pose.position_m.coords, pose.heading_rad)
}

fn odometry(scene: &Scene) -> Isometry2<f64> {
    let pose = scene.odometry.as_ref().expect("a scene of a flight").pose.pose;
    let yaw_rad = 2.0 * pose.orientation.z.atan2(pose.orientation.w);
    Isometry2::new(Vector2::new(pose.position.x, pose.position.y), yaw_rad)
}

/// The poses of a flight, and how many revolutions have a note.
fn track(flight: &[Scene], kind: &str, with_odometry: impl Fn(usize) -> bool) -> (Vec<Tracked>, usize) {
    track_by(flight, kind, |i, scene| with_odometry(i).then(|| odometry(scene)))
}

/// As [`track`], with this odometry.
fn track_by(
    flight: &[Scene],
    kind: &str,
    odometry: impl Fn(usize, &Scene) -> Option<Isometry2<f64>>,
) -> (Vec<Tracked>, usize) {
    let mut params = Params::defaults(crosscut_flight::PARAMS);
    params.set("pose", Value::String(kind.to_owned())).expect("a kind");
    let (mut tracker, sensor) = (PoseTracker::new(&params), Sensor::default());
    let (mut revolution, mut noted) = (Revolution::default(), 0);
    let add = |(i, scene): (usize, &Scene)| {
        sensor.revolution(&scene.scan, &mut revolution, &mut Notes::default());
        revolution.odometry = odometry(i, scene);
        let mut notes = Notes::default();
        let tracked = tracker.add(&revolution, &mut notes);
        noted += usize::from(!notes.is_empty());
        tracked
    };
    let tracked = flight.iter().enumerate().filter_map(add).collect();
    (tracked, noted)
}

/// How far the last pose is off, as a share of the way.
fn drift(flight: &[Scene], found: &[Tracked]) -> f64 {
    let first = true_pose(&flight[0]);
    let way_m: f64 = flight
        .windows(2)
        .map(|pair| (true_pose(&pair[1]).translation.vector - true_pose(&pair[0]).translation.vector).norm())
        .sum();
    let off = first.inv_mul(&true_pose(flight.last().expect("some"))).inv_mul(&found.last().expect("some").pose);
    off.translation.vector.norm() / way_m
}

#[test]
fn walls_correct_the_drift_of_the_odometry() {
    let (mut by_odometry, mut by_both, mut by_scans) = (0.0, 0.0, 0.0);
    for seed in 1..=2 {
        let flight = flight("tunnel", seed, 400);
        let of = |kind: &str| drift(&flight, &track(&flight, kind, |_| true).0);
        let drifts = [of("odometry"), of("odometry_scan_match"), of("scan_match")];
        println!("seed {seed}: {drifts:.4?}");
        by_odometry += drifts[0] / 2.0;
        by_both += drifts[1] / 2.0;
        by_scans += drifts[2] / 2.0;
    }
    println!("drift: odometry {by_odometry:.4}, both {by_both:.4}, scans alone {by_scans:.4}");
    assert!(by_both < 0.5 * by_odometry, "{by_both} against {by_odometry}");
    assert!(by_scans < 0.1, "{by_scans}");
}

#[test]
fn the_kinds_treat_missing_odometry_as_they_state() {
    let flight = flight("tee", 1, 20);
    let notes = |kind: &str, with_odometry: fn(usize) -> bool| track(&flight, kind, with_odometry).1;
    assert_eq!(notes("auto", |_| true), 0);
    assert_eq!(notes("auto", |_| false), 0, "a recording of scans alone");
    assert_eq!(notes("auto", |i| i != 7), 1, "a hole");
    assert_eq!(notes("odometry", |i| i != 7), 1, "a hole");
    assert_eq!(notes("odometry_scan_match", |_| false), 20);
    assert_eq!(notes("odometry", |_| false), 20);
    assert!(track(&flight, "odometry", |_| false).0.is_empty() && track(&flight, "none", |_| true).0.is_empty());
    let scans = |with_odometry| track(&flight, "scan_match", with_odometry);
    assert_eq!(scans((|_| true) as fn(usize) -> bool), scans(|_| false));
}

#[test]
fn a_hole_in_the_odometry_loses_no_motion() {
    let flight = flight("tee", 1, 60);
    for kind in ["odometry", "odometry_scan_match"] {
        let last = |with_odometry: fn(usize) -> bool| track(&flight, kind, with_odometry).0[59].pose;
        let off = last(|_| true).inv_mul(&last(|i| !(20..30).contains(&i)));
        assert!(off.translation.vector.norm() < 0.05 && off.rotation.angle().abs() < 0.01, "{kind}: {off:?}");
    }
}

#[test]
fn odometry_that_is_not_finite_is_left_out() {
    let flight = flight("tee", 1, 20);
    let broken =
        |i: usize, scene: &Scene| Some(if i == 7 { Isometry2::translation(f64::NAN, 0.0) } else { odometry(scene) });
    for kind in ["odometry", "odometry_scan_match"] {
        assert_eq!(track_by(&flight, kind, broken), track(&flight, kind, |i| i != 7), "{kind}");
    }
}

#[test]
fn recordings_cut_together_are_stretches_and_no_flight_is_cut() {
    // 40 scans from each of four places of three mines: what one shows lies on walls of another in part.
    let parts = [("tunnel", 1, 100), ("mine", 1, 60), ("tunnel", 2, 250), ("mine", 2, 200)];
    let scenes = parts.map(|(name, seed, from)| flight(name, seed, from + 40).split_off(from));
    let stretches = |flight: &[Scene]| {
        let (tracked, _) = track(flight, "scan_match", |_| false);
        let mut lost: Vec<usize> = (0..tracked.len()).filter(|&at| tracked[at].lost).collect();
        lost.dedup();
        lost
    };
    let whole = scenes.concat();
    assert_eq!(stretches(&whole), [40, 80, 120]);
    for seed in 1..=2 {
        assert!(stretches(&flight("mine", seed, 400)).is_empty());
    }
}
