//! Two scanners of a vehicle in a room, at its corners, joined by the transforms of the recording.

use std::f64::consts::{FRAC_PI_4, PI};

use crosscut_ingest::{LossKind, ReadOptions, Recording};
use crosscut_messages::{
    Endian, Header, LaserScan, Message as _, Quaternion, TfMessage, Time, Transform, TransformStamped, Vector3,
};
use crosscut_stage::{Beam, Notes, Revolution, Source as _};

use crate::flight::{Folder, Form, Record, record_at, sensor, time_ns};

/// Half length and half width of the room, m, with the vehicle in its middle.
const ROOM_M: [f64; 2] = [4.0, 3.0];
const STEP_RAD: f64 = PI / 360.0;
const FRONT: [f64; 3] = [0.4, 0.3, FRAC_PI_4];
const REAR: [f64; 3] = [-0.4, -0.3, FRAC_PI_4 - PI];

/// What a scanner with a view of 270° sees at x, y, yaw of the vehicle's frame; nothing beyond `range_max_m`.
fn room_scan([x, y, yaw_rad]: [f64; 3], frame_id: &str, stamp_ns: u64, range_max_m: f64) -> LaserScan {
    let first_rad = -0.75 * PI;
    let range_m = |beam: usize| {
        let (sin, cos) = (yaw_rad + first_rad + beam as f64 * STEP_RAD).sin_cos();
        let to_wall = |from: f64, along: f64, half_m: f64| {
            if along.abs() < 1e-12 { f64::INFINITY } else { (along.signum() * half_m - from) / along }
        };
        let range_m = to_wall(x, cos, ROOM_M[0]).min(to_wall(y, sin, ROOM_M[1]));
        if range_m < range_max_m { range_m as f32 } else { f32::INFINITY }
    };
    LaserScan {
        header: Header { stamp: Time::from_ns(stamp_ns), frame_id: frame_id.to_owned() },
        angle_min: first_rad as f32,
        angle_max: -first_rad as f32,
        angle_increment: STEP_RAD as f32,
        range_max: range_max_m as f32,
        ranges: (0..=540).map(range_m).collect(),
        ..LaserScan::default()
    }
}

fn transform(topic: &'static str, parent: &str, child: &str, [x, y, yaw_rad]: [f64; 3], stamp_ns: u64) -> Record {
    let header = Header { stamp: Time::from_ns(stamp_ns), frame_id: parent.to_owned() };
    let transform = Transform { translation: Vector3 { x, y, z: 0.2 }, rotation: Quaternion::from_yaw_rad(yaw_rad) };
    let transforms =
        TfMessage { transforms: vec![TransformStamped { header, child_frame_id: child.to_owned(), transform }] };
    let (type_name, encoding) = (TfMessage::SCHEMA_NAME, "cdr");
    Record { topic, type_name, encoding, log_time_ns: stamp_ns, data: transforms.encode(Endian::Little) }
}

pub(crate) fn fixed() -> Vec<Record> {
    vec![
        transform("/tf_static", "base_link", "front_laser", FRONT, time_ns(0)),
        transform("/tf_static", "base_link", "rear_laser", REAR, time_ns(0)),
        transform("/tf", "odom", "base_link", [7.0, 8.0, 1.0], time_ns(0)),
    ]
}

/// `count` scans of both scanners; the rear one is later by this.
pub(crate) fn scans(count: u64, late_ns: u64, range_max_m: f64) -> Vec<Record> {
    let pair = |i: u64| {
        let front = room_scan(FRONT, "front_laser", time_ns(i), range_max_m);
        let rear = room_scan(REAR, "rear_laser", time_ns(i) + late_ns, range_max_m);
        [record_at("/front/scan", time_ns(i), &front), record_at("/rear/scan", time_ns(i) + late_ns, &rear)]
    };
    (0..count).flat_map(pair).collect()
}

fn read(records: &[Record]) -> Vec<(Revolution, Vec<String>)> {
    let folder = Folder::new();
    let path = folder.add("f.mcap", &Form::CHUNKED.write(records));
    let options = ReadOptions {
        topic: Some("/front/scan".to_owned()),
        beside: vec!["/rear/scan".to_owned()],
        ..ReadOptions::default()
    };
    let mut recording = Recording::open(&[path], &options, sensor(&[])).expect("two scanners");
    let (mut read, mut revolution) = (Vec::new(), Revolution::default());
    loop {
        let mut notes = Notes::default();
        if !recording.next(&mut revolution, &mut notes).expect("the source goes on") {
            return read;
        }
        read.push((revolution.clone(), notes.iter().map(str::to_owned).collect()));
    }
}

/// How far a return is from the nearest wall of the room, m.
fn off_wall_m(x: f64, y: f64) -> f64 {
    (x.abs() - ROOM_M[0]).abs().min((y.abs() - ROOM_M[1]).abs())
}

fn assert_sees_the_room(revolution: &Revolution) {
    let sweep = revolution.sweep.as_ref().expect("beams");
    assert!(sweep.full_turn && sweep.view().full_turn);
    assert_eq!((sweep.len(), revolution.len()), (360, 360), "every beam sees a wall");
    for (beam, point_m) in revolution.points_m.iter().enumerate() {
        assert!(off_wall_m(point_m.x, point_m.y) < 1e-3 && point_m.z == 0.0, "{point_m}");
        let off_rad = (point_m.y.atan2(point_m.x) - sweep.bearings_rad[beam]).abs();
        assert!(off_rad <= sweep.step_rad / 2.0 + 1e-9, "beam {beam}: {off_rad}");
        assert!((f64::from(sweep.ranges_m[beam]) - point_m.x.hypot(point_m.y)).abs() < 1e-5);
    }
}

#[test]
fn two_scanners_at_the_corners_see_the_whole_room() {
    let read = read(&[fixed(), scans(4, 30_000_000, 30.0)].concat());
    assert_eq!(read.len(), 4);
    for (i, (revolution, notes)) in read.iter().enumerate() {
        assert_eq!((revolution.seq, revolution.stamp_ns), (i as u64, time_ns(i as u64)));
        assert_eq!(
            (revolution.frame_id.as_str(), &notes[..]),
            ("base_link", &["joined with /rear/scan in frame `base_link`".to_owned()][..])
        );
        assert_sees_the_room(revolution);
    }
}

#[test]
fn free_space_beyond_the_range_is_no_return_from_either_scanner() {
    let read = read(&[fixed(), scans(1, 0, 3.5)].concat());
    let sweep = read[0].0.sweep.as_ref().expect("beams");
    let count = |wanted: fn(&Beam) -> bool| sweep.beams.iter().filter(|beam| wanted(beam)).count();
    let returns = count(|beam| matches!(beam, Beam::Return(_)));
    let unknown = count(|beam| *beam == Beam::Unknown);
    assert!((100..340).contains(&returns) && unknown <= 10, "{returns} returns, {unknown} unknown");
}

#[test]
fn a_scanner_that_turns_on_its_mast_is_joined_by_its_pose_at_the_time() {
    let mut records = vec![transform("/tf_static", "base_link", "front_laser", FRONT, time_ns(0))];
    let yaw_rad = |i: f64| REAR[2] + 0.2 * i;
    for i in 0..6 {
        records.push(transform("/tf", "base_link", "rear_laser", [REAR[0], REAR[1], yaw_rad(i as f64)], time_ns(i)));
    }
    for i in 0..5 {
        let front = room_scan(FRONT, "front_laser", time_ns(i), 30.0);
        let between = [REAR[0], REAR[1], yaw_rad(i as f64 + 0.5)];
        let rear = room_scan(between, "rear_laser", time_ns(i) + 50_000_000, 30.0);
        records.push(record_at("/front/scan", time_ns(i), &front));
        records.push(record_at("/rear/scan", time_ns(i) + 50_000_000, &rear));
    }
    for (revolution, notes) in read(&records) {
        assert!(notes[0].starts_with("joined with /rear/scan"), "{notes:?}");
        assert!(
            revolution.points_m.iter().all(|point_m| off_wall_m(point_m.x, point_m.y) < 5e-3),
            "{:?}",
            revolution.points_m
        );
    }
}

#[test]
fn what_cannot_be_joined_is_noted_and_the_first_scanner_stays() {
    let without_transforms = read(&scans(2, 0, 30.0));
    let too_late = read(&[fixed(), scans(1, 100_000_001, 30.0)].concat());
    for (read, why) in
        [(without_transforms, "no transforms lead from `rear_laser`"), (too_late, "no scan within 0.1 s")]
    {
        for (revolution, notes) in &read {
            assert!(notes.iter().any(|note| note.contains(why)), "{notes:?}");
            assert_eq!((revolution.frame_id.as_str(), revolution.len()), ("front_laser", 541));
        }
    }
}

#[test]
fn a_loss_of_the_other_scanner_is_a_loss() {
    let mut records = [fixed(), scans(3, 0, 30.0)].concat();
    records.iter_mut().filter(|record| record.topic == "/rear/scan").for_each(|record| record.data.truncate(50));
    let folder = Folder::new();
    let path = folder.add("f.mcap", &Form::CHUNKED.write(&records));
    let options = ReadOptions {
        topic: Some("front/scan".to_owned()),
        beside: vec!["rear/scan".to_owned()],
        ..ReadOptions::default()
    };
    let mut recording = Recording::open(&[path], &options, sensor(&[])).expect("two scanners");
    let mut revolution = Revolution::default();
    while recording.next(&mut revolution, &mut Notes::default()).expect("the source goes on") {}
    assert!(
        recording
            .losses()
            .iter()
            .any(|loss| matches!(&loss.kind, LossKind::Messages { topic, .. } if topic == "/rear/scan")),
        "{:?}",
        recording.losses()
    );
}

/// The revolutions of the front scanner alone.
fn front_alone(records: Vec<Record>, settings: &[(&str, crosscut_stage::Value)]) -> (Revolution, Vec<String>) {
    let folder = Folder::new();
    let path = folder.add("f.mcap", &Form::CHUNKED.write(&records));
    let options = ReadOptions { topic: Some("/front/scan".to_owned()), ..ReadOptions::default() };
    let mut recording = Recording::open(&[path], &options, sensor(settings)).expect("a recording");
    let (mut revolution, mut notes) = (Revolution::default(), Notes::default());
    assert!(recording.next(&mut revolution, &mut notes).expect("readable"));
    (revolution, notes.iter().map(str::to_owned).collect())
}

#[test]
fn a_single_scanner_is_mounted_as_the_recording_states_unless_it_is_set() {
    let records = || fixed().into_iter().chain(scans(3, 0, 30.0)).collect::<Vec<_>>();
    // The first beam looks 3π/4 to the right of where the scanner does.
    let first_rad = |revolution: &Revolution| revolution.sweep.as_ref().expect("beams").bearings_rad[0];
    let (stated, notes) = front_alone(records(), &[]);
    assert!((first_rad(&stated) - (FRONT[2] - 0.75 * PI)).abs() < 1e-6, "{}", first_rad(&stated));
    assert!(notes.iter().any(|note| note.contains("by /tf_static")), "{notes:?}");
    let (set, notes) = front_alone(records(), &[("yaw_rad", crosscut_stage::Value::Float(0.1))]);
    assert!((first_rad(&set) - (0.1 - 0.75 * PI)).abs() < 1e-6 && !notes.iter().any(|note| note.contains("tf_static")));
    let (off, _) = front_alone(records(), &[("mount_from_tf", crosscut_stage::Value::Boolean(false))]);
    assert!((first_rad(&off) + 0.75 * PI).abs() < 1e-6);
}

#[test]
fn scanners_that_state_one_frame_are_joined_only_if_they_agree() {
    let flight = |rear: [f64; 3]| -> Vec<Record> {
        let pair = |i: u64| {
            let front = room_scan(FRONT, "laser", time_ns(i), 30.0);
            let rear = room_scan(rear, "laser", time_ns(i), 30.0);
            [record_at("/front/scan", time_ns(i), &front), record_at("/rear/scan", time_ns(i), &rear)]
        };
        (0..3).flat_map(pair).collect()
    };
    // From the opposite corner the room would look the same.
    let turned = [-0.4, 0.3, 2.0];
    for (rear, expected) in
        [(FRONT, "joined with /rear/scan in frame `laser`"), (turned, "both scanners state the frame")]
    {
        for (_, notes) in read(&flight(rear)) {
            assert!(notes.iter().any(|note| note.contains(expected)), "{rear:?}: {notes:?}");
        }
    }
}
