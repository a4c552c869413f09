//! A vehicle that turns while its lidar takes a scan.

use std::f64::consts::{PI, TAU};

use crosscut_ingest::{ReadOptions, Recording};
use crosscut_messages::{Endian, Header, LaserScan, Message, Odometry, Quaternion, Time};
use crosscut_stage::{Notes, Revolution, Source, Value};

use crate::flight::{Folder, Form, Record, STEP_NS, record_at, sensor, time_ns};

const BEAMS: usize = 360;
const SCANS: u64 = 8;
/// Half of the sides of the room, m.
const ROOM_M: [f64; 2] = [2.0, 6.0];

/// From the middle of the room to its wall.
fn wall_m(heading_rad: f64) -> f64 {
    let (sin, cos) = heading_rad.sin_cos();
    (ROOM_M[0] / sin.abs()).min(ROOM_M[1] / cos.abs())
}

/// The vehicle turns at `rate_rad_s` in the middle of the room; its lidar turns anticlockwise or (-1) clockwise.
pub(crate) fn scan(number: u64, rate_rad_s: f64, direction: f64) -> LaserScan {
    let increment_rad = direction * TAU / BEAMS as f64;
    let beam_s = STEP_NS as f64 * 1e-9 / BEAMS as f64;
    let range_m = |beam: usize| {
        let heading_rad = rate_rad_s * (number as usize * BEAMS + beam) as f64 * beam_s;
        wall_m(heading_rad + 0.4 + beam as f64 * increment_rad) as f32
    };
    LaserScan {
        header: Header { stamp: Time::from_ns(time_ns(number)), frame_id: "laser".to_owned() },
        angle_min: 0.0,
        angle_max: ((BEAMS - 1) as f64 * increment_rad) as f32,
        angle_increment: increment_rad as f32,
        time_increment: beam_s as f32,
        range_max: 30.0,
        ranges: (0..BEAMS).map(range_m).collect(),
        ..LaserScan::default()
    }
}

/// The last scan of a flight, and its notes.
fn last(scans: impl Iterator<Item = LaserScan>, settings: &[(&str, Value)]) -> (Revolution, Vec<String>) {
    last_of((0..).zip(scans).map(|(i, scan)| record_at("/scan", time_ns(i), &scan)).collect(), settings)
}

/// The last scan or cloud of a recording, and its notes.
fn last_of(mut records: Vec<Record>, settings: &[(&str, Value)]) -> (Revolution, Vec<String>) {
    records.sort_by_key(|record| record.log_time_ns);
    let folder = Folder::new();
    let path = folder.add("f.mcap", &Form::CHUNKED.write(&records));
    let options = ReadOptions::default();
    let mut recording = Recording::open(&[path], &options, sensor(settings)).expect("a recording");
    let (mut revolution, mut last) = (Revolution::default(), Vec::new());
    loop {
        let mut notes = Notes::default();
        if !recording.next(&mut revolution, &mut notes).expect("readable") {
            return (revolution, last);
        }
        last = notes.iter().map(str::to_owned).collect();
    }
}

/// Odometry every 10 ms for a second, of a vehicle that drives and turns evenly.
pub(crate) fn odometry(speed_m_s: f64, rate_rad_s: f64) -> impl Iterator<Item = Record> {
    (0..100).map(move |i| {
        let stamp_ns = time_ns(0) + i * 10_000_000;
        let since_s = i as f64 * 0.01;
        let mut odometry = Odometry::default();
        odometry.header.stamp = Time::from_ns(stamp_ns);
        odometry.pose.pose.position.x = speed_m_s * since_s;
        odometry.pose.pose.orientation = Quaternion::from_yaw_rad(rate_rad_s * since_s);
        let data = odometry.encode(Endian::Little);
        Record { topic: "/odom", type_name: Odometry::SCHEMA_NAME, encoding: "cdr", log_time_ns: stamp_ns, data }
    })
}

/// How far returns are from the walls at most, if the vehicle heads to `heading_rad`.
fn farthest_from_walls_m(revolution: &Revolution, heading_rad: f64) -> f64 {
    let off_m = |i: usize| {
        let bearing_rad = revolution.bearing_rad(i) + heading_rad + 0.4;
        let (sin, cos) = bearing_rad.sin_cos();
        let (x_m, y_m) = (revolution.range_m(i) * cos, revolution.range_m(i) * sin);
        (x_m.abs() - ROOM_M[1]).abs().min((y_m.abs() - ROOM_M[0]).abs())
    };
    (0..revolution.len()).map(off_m).fold(0.0, f64::max)
}

#[test]
fn walls_are_straight_after_a_turn_of_the_vehicle() {
    for (rate_rad_s, direction) in [(PI, 1.0), (-PI, 1.0), (PI, -1.0), (-PI, -1.0), (2.0, 1.0)] {
        let scans = || (0..SCANS).map(|number| scan(number, rate_rad_s, direction));
        let middle_s = ((SCANS - 1) as f64 + 0.5) * STEP_NS as f64 * 1e-9;
        let (revolution, notes) = last(scans(), &[]);
        let off_m = farthest_from_walls_m(&revolution, rate_rad_s * middle_s);
        assert!(off_m < 0.1, "{rate_rad_s} {direction}: {off_m} m");
        let turned = format!("turned by {:.0}", (rate_rad_s * 0.1).to_degrees());
        assert!(notes.iter().any(|note| note.starts_with(&turned[..turned.len() - 1])), "{turned}: {notes:?}");
        let sweep = revolution.sweep.as_ref().expect("beams");
        assert!(sweep.full_turn);
        let covered_rad = (sweep.len() + sweep.missing) as f64 * sweep.step_rad;
        assert!((covered_rad - TAU).abs() < 0.02, "{covered_rad}");

        let (skewed, notes) = last(scans(), &[("deskew", Value::Boolean(false))]);
        assert!(farthest_from_walls_m(&skewed, rate_rad_s * middle_s) > 0.2);
        assert!(notes.is_empty(), "{notes:?}");
    }
}

/// As drivers of lidars that turn clockwise send it: listed anticlockwise, with a time from beam to beam that is positive.
fn against_time(scan: LaserScan) -> LaserScan {
    let (angle_min, angle_max) = (scan.angle_max, scan.angle_min);
    let ranges = scan.ranges.into_iter().rev().collect();
    LaserScan { angle_min, angle_max, angle_increment: -scan.angle_increment, ranges, ..scan }
}

#[test]
fn beams_listed_against_their_order_in_time_are_found_by_the_scans() {
    for (rate_rad_s, direction) in [(PI, -1.0), (-PI, -1.0), (PI, 1.0), (-PI, 1.0)] {
        let scans = || (0..SCANS).map(|number| against_time(scan(number, rate_rad_s, direction)));
        let heading_rad = rate_rad_s * ((SCANS - 1) as f64 + 0.5) * STEP_NS as f64 * 1e-9;
        let (revolution, _) = last(scans(), &[]);
        let off_m = farthest_from_walls_m(&revolution, heading_rad);
        assert!(off_m < 0.1, "{rate_rad_s} {direction}: {off_m} m");
        let with_odometry = (0..).zip(scans()).map(|(i, scan)| record_at("/scan", time_ns(i), &scan));
        let (revolution, _) = last_of(with_odometry.chain(odometry(0.0, rate_rad_s)).collect(), &[]);
        let off_m = farthest_from_walls_m(&revolution, heading_rad);
        assert!(off_m < 0.1, "with odometry, {rate_rad_s} {direction}: {off_m} m");
    }
}

#[test]
fn scans_without_times_of_beams_or_turning_stay_unchanged() {
    let without_times = |scan: LaserScan| LaserScan { time_increment: 0.0, ..scan };
    let flights: [Vec<LaserScan>; 3] = [
        (0..SCANS).map(|number| without_times(scan(number, PI, 1.0))).collect(),
        (0..SCANS).map(|number| scan(number, 0.0, 1.0)).collect(),
        (0..SCANS).map(|number| scan(number, 1.2, 1.0)).collect(),
    ];
    for flight in flights {
        let (with, notes) = last(flight.iter().cloned(), &[]);
        let (without, _) = last(flight.iter().cloned(), &[("deskew", Value::Boolean(false))]);
        assert_eq!(with.points_m, without.points_m);
        assert!(notes.is_empty(), "{notes:?}");
    }
}

#[test]
fn scans_longer_than_their_interval_stay_unchanged() {
    // The duration of a scan exceeds the time between the stamps: one of them is wrong.
    let slow = |number| LaserScan { time_increment: 1e-3, ..scan(number, PI, 1.0) };
    let (_, notes) = last((0..SCANS).map(slow), &[]);
    assert!(notes.is_empty(), "{notes:?}");
}

#[test]
fn odometry_tells_the_turn_that_a_first_scan_cannot_show() {
    for (rate_rad_s, direction, upside_down) in [(PI, 1.0, false), (-PI, -1.0, false), (PI, 1.0, true)] {
        // Hung upside down, its bearings run the other way.
        let own = if upside_down { -1.0 } else { 1.0 };
        let scan = scan(0, own * rate_rad_s, direction);
        let records = || odometry(0.0, rate_rad_s).chain([record_at("/scan", time_ns(0), &scan)]).collect();
        let settings = [("upside_down", Value::Boolean(upside_down))];
        let (mut revolution, notes) = last_of(records(), &settings);
        for point_m in &mut revolution.points_m {
            point_m.y *= own;
        }
        if let Some(sweep) = &mut revolution.sweep {
            sweep.bearings_rad.iter_mut().for_each(|bearing_rad| *bearing_rad *= own);
        }
        let off_m = farthest_from_walls_m(&revolution, own * rate_rad_s * 0.05);
        assert!(off_m < 0.1, "{rate_rad_s} {direction}: {off_m} m");
        let yaw_rad = revolution.odometry.expect("a pose").rotation.angle();
        assert!((yaw_rad - rate_rad_s * 0.05).abs() < 0.01, "the pose is that of the middle of the scan: {yaw_rad}");
        let turned = format!("turned by {:.0}.0°", rate_rad_s.signum() * 18.0);
        assert!(notes.iter().any(|note| note.starts_with(&turned)), "{notes:?}");

        let (skewed, notes) =
            last_of(records(), &[("deskew", Value::Boolean(false)), ("upside_down", Value::Boolean(upside_down))]);
        assert!(skewed.odometry.is_some_and(|pose| pose.rotation.angle().abs() < 1e-6), "at the stamp");
        assert!(!notes.iter().any(|note| note.starts_with("turned")), "{notes:?}");
    }
}
