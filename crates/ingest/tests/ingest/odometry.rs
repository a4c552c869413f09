//! The odometry beside the scans: which topic, and which pose belongs to which scan.

use crosscut_ingest::{ReadOptions, Recording};
use crosscut_messages::{
    Endian, Header, Message, Odometry, Quaternion, TfMessage, Time, Transform, TransformStamped, Vector3,
};
use crosscut_stage::{Notes, Revolution, Source, Value};

use crate::flight::{Folder, Form, Record, plain_flight, sensor, time_ns};

/// The vehicle drives 2 m a second and turns 0.1 rad a second; `start_m` tells topics apart.
fn odometry_at(topic: &'static str, stamp_ns: u64, start_m: f64) -> Record {
    let since_s = (stamp_ns - time_ns(0)) as f64 * 1e-9;
    let mut odometry = Odometry::default();
    odometry.header.stamp = Time::from_ns(stamp_ns);
    odometry.pose.pose.position.x = start_m + 2.0 * since_s;
    odometry.pose.pose.orientation = Quaternion::from_yaw_rad(0.1 * since_s);
    let data = odometry.encode(Endian::Little);
    Record { topic, type_name: Odometry::SCHEMA_NAME, encoding: "cdr", log_time_ns: stamp_ns, data }
}

fn transform_at(stamp_ns: u64, frame_id: &str, x_m: f64) -> Record {
    let header = Header { stamp: Time::from_ns(stamp_ns), frame_id: frame_id.to_owned() };
    let transform = Transform { translation: Vector3 { x: x_m, ..Vector3::default() }, ..Transform::default() };
    let transforms = vec![TransformStamped { header, child_frame_id: "base_link".to_owned(), transform }];
    let data = TfMessage { transforms }.encode(Endian::Little);
    Record { topic: "/tf", type_name: TfMessage::SCHEMA_NAME, encoding: "cdr", log_time_ns: stamp_ns, data }
}

fn in_order(mut records: Vec<Record>) -> Vec<Record> {
    records.sort_by_key(|record| record.log_time_ns);
    records
}

/// Position and yaw of each scan, by its odometry.
fn poses(path: &std::path::Path, given: &[(&str, Value)]) -> Vec<Option<[f64; 2]>> {
    let mut recording = Recording::open(&[path.to_owned()], &ReadOptions::default(), sensor(given)).expect("scans");
    let (mut revolution, mut poses) = (Revolution::default(), Vec::new());
    while recording.next(&mut revolution, &mut Notes::default()).expect("the source goes on") {
        poses.push(revolution.odometry.map(|pose| [pose.translation.x, pose.rotation.angle()]));
    }
    poses
}

#[test]
fn every_form_gives_scans_the_odometry_at_their_stamps() {
    let folder = Folder::new();
    // Every 70 ms up to scan 17, so that most scans lie between two messages.
    let odometry = (0..25).map(|i| odometry_at("/odom", time_ns(0) + i * 70_000_000, 0.0));
    let records = in_order(plain_flight(20).into_iter().chain(odometry).collect());
    for form in Form::all() {
        let path = folder.add("flight.mcap", &form.write(&records));
        for (i, pose) in poses(&path, &[]).into_iter().enumerate() {
            match (i, pose) {
                (0..=16, Some([x_m, yaw_rad])) => {
                    let since_s = 0.1 * i as f64;
                    assert!((x_m - 2.0 * since_s).abs() < 1e-9 && (yaw_rad - 0.1 * since_s).abs() < 1e-6, "{i}");
                }
                (17.., None) => {}
                other => panic!("{other:?}, {form:?}"),
            }
        }
    }
}

#[test]
fn the_odometry_is_that_of_the_topic_asked_for_then_of_odom_then_of_transforms() {
    let folder = Folder::new();
    let of_topic = |topic, start_m| (0..6).map(move |i| odometry_at(topic, time_ns(i), start_m));
    let transforms = || {
        let to_odometry = (0..6).map(|i| transform_at(time_ns(i), "/odom", 300.0));
        to_odometry.chain((0..6).map(|i| transform_at(time_ns(i), "map", 400.0)))
    };
    let add = |records: Vec<Record>| {
        let scans = plain_flight(5).into_iter();
        folder.add("flight.mcap", &Form::CHUNKED.write(&in_order(scans.chain(records).collect())))
    };
    let first_m = |path: &std::path::Path, given: &[(&str, Value)]| poses(path, given)[0].map(|pose| pose[0]);

    let path = add(of_topic("/a/odometry", 100.0).chain(of_topic("/odom", 200.0)).chain(transforms()).collect());
    assert_eq!(first_m(&path, &[]), Some(200.0));
    assert_eq!(first_m(&path, &[("odometry", Value::String("/a/odometry".into()))]), Some(100.0));
    assert_eq!(first_m(&path, &[("odometry", Value::String("/tf".into()))]), Some(300.0));
    assert_eq!(first_m(&path, &[("odometry", Value::String("/nothing".into()))]), None);
    assert_eq!(first_m(&add(of_topic("/a/odometry", 100.0).chain(transforms()).collect()), &[]), Some(100.0));
    assert_eq!(first_m(&add(transforms().collect()), &[]), Some(300.0));
    assert_eq!(first_m(&add(Vec::new()), &[]), None);
}

#[test]
fn odometry_of_another_clock_is_not_taken_and_not_kept_in_memory_for_ever() {
    let folder = Folder::new();
    let a_day_ns = 86_400_000_000_000;
    let earlier = (0..20).map(|i| {
        let record = odometry_at("/odom", time_ns(i), 0.0);
        let mut odometry = Odometry::decode(&record.data).expect("written above");
        odometry.header.stamp = Time::from_ns(time_ns(i) - a_day_ns);
        Record { data: odometry.encode(Endian::Little), ..record }
    });
    let records = in_order(plain_flight(20).into_iter().chain(earlier).collect());
    let path = folder.add("flight.mcap", &Form::CHUNKED.write(&records));
    assert_eq!(poses(&path, &[]), vec![None; 20]);
}

/// Odometry in CDR as a writer lays it out that counts alignment from the start of the message.
fn from_start(stamp: Time, frame: &str, x_m: f64) -> Vec<u8> {
    let mut data = vec![0, 1, 0, 0];
    data.extend(stamp.sec.to_le_bytes());
    data.extend(stamp.nanosec.to_le_bytes());
    for text in [frame, "base_link"] {
        data.resize(data.len().next_multiple_of(4), 0);
        data.extend((text.len() as u32 + 1).to_le_bytes());
        data.extend(text.bytes().chain([0]));
    }
    data.resize(data.len().next_multiple_of(8), 0);
    let numbers = [x_m, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0].into_iter().chain([0.0; 36 + 6 + 36]);
    data.extend(numbers.flat_map(f64::to_le_bytes));
    data
}

#[test]
fn odometry_is_read_by_the_alignment_that_makes_its_quaternion_one() {
    let folder = Folder::new();
    for frame in ["", "o", "odom", "odometry"] {
        let shifted = (0..20).map(|i| {
            let record = odometry_at("/odom", time_ns(i), 0.0);
            Record { data: from_start(Time::from_ns(time_ns(i)), frame, 0.25 * i as f64), ..record }
        });
        let records = in_order(plain_flight(20).into_iter().chain(shifted).collect());
        let path = folder.add("flight.mcap", &Form::CHUNKED.write(&records));
        let x_m: Vec<_> = poses(&path, &[]).into_iter().map(|pose| pose.map(|pose| pose[0])).collect();
        assert_eq!(x_m, (0..20).map(|i| Some(0.25 * f64::from(i))).collect::<Vec<_>>(), "{frame:?}");
    }
}

#[test]
fn odometry_of_which_nothing_can_be_used_is_a_loss() {
    let folder = Folder::new();
    let damaged = (0..20).map(|i| {
        let record = odometry_at("/odom", time_ns(i), 0.0);
        let mut odometry = Odometry::decode(&record.data).expect("written above");
        odometry.pose.pose.orientation.w = 1e200;
        Record { data: odometry.encode(Endian::Little), ..record }
    });
    let records = in_order(plain_flight(20).into_iter().chain(damaged).collect());
    let path = folder.add("flight.mcap", &Form::CHUNKED.write(&records));
    let mut recording = Recording::open(&[path], &ReadOptions::default(), sensor(&[])).expect("scans");
    while recording.next(&mut Revolution::default(), &mut Notes::default()).expect("the source goes on") {}
    let losses: Vec<String> = recording.losses().iter().map(ToString::to_string).collect();
    assert!(matches!(&losses[..], [loss] if loss.starts_with("no message of /odom can be used")), "{losses:?}");
}

#[test]
fn lines_of_a_log_whose_times_stand_still_have_the_odometry_of_their_own() {
    let folder = Folder::new();
    for (line, times) in [("FLASER 4 1 2 3 4", ["0", "0"]), ("FLASER 4 1 2 3 4", ["1.13487e+09", "1.13487e+09"])] {
        for odometry in ["", "ODOM 50 0 0 1 0 0 0 host 0\n"] {
            let rows = (0..9).map(|i| format!("{odometry}{line} {i} 0 0 {i} 0 0 {} host {}\n", times[0], times[1]));
            let path = folder.add("log.clf", rows.collect::<String>().as_bytes());
            let x_m: Vec<_> = poses(&path, &[]).into_iter().map(|pose| pose.map(|pose| pose[0] as usize)).collect();
            assert_eq!(x_m, (0..9).map(Some).collect::<Vec<_>>(), "{line} {times:?}");
        }
    }
}

#[test]
fn a_compressed_log_has_the_odometry_of_its_lines() {
    let folder = Folder::new();
    let mut text = String::new();
    for i in 0..5 {
        let time_s = 1_700_000_000.0 + 0.1 * f64::from(i);
        text += &format!("ODOM {i} 0 0 1 0 0 {time_s} nohost 0\n");
        text += &format!("FLASER 4 1.0 2.0 3.0 4.0 {i} 0 0 {i} 0 0 {time_s} nohost 0\n");
    }
    let packed = zstd::encode_all(text.as_bytes(), 3).expect("in memory");
    for path in [folder.add("log.clf", text.as_bytes()), folder.add("log.clf.zst", &packed)] {
        let x_m: Vec<_> = poses(&path, &[]).into_iter().map(|pose| pose.map(|pose| pose[0])).collect();
        assert_eq!(x_m, [0.0, 1.0, 2.0, 3.0, 4.0].map(Some), "{}", path.display());
    }
}
