//! Scans under other names, in other types, and without a name.

use crosscut_ingest::{IngestError, ReadOptions, Recording};
use crosscut_messages::{Cloud, Endian, LaserScan, Message, NumberType, PointCloud2, PointField, ScanType};
use crosscut_sensor::Sensor;
use crosscut_stage::{Notes, Point, Revolution, Source, Value};

use crate::flight::{Folder, Form, Record, START_NS, drain, plain_flight, record_at, scan, sensor};

fn open_as(folder: &Folder, topic: Option<&str>, read_as: Option<ScanType>) -> Result<Recording, IngestError> {
    let options = ReadOptions { topic: topic.map(str::to_owned), read_as, ..ReadOptions::default() };
    Recording::open(&[folder.path().to_owned()], &options, sensor(&[]))
}

/// The plain flight under another name of its type, with a topic that has no scans beside it.
fn flight_named(type_name: &'static str) -> Folder {
    let mut records = plain_flight(5);
    records.iter_mut().for_each(|record| record.type_name = type_name);
    records.push(Record { topic: "/odom", type_name: "nav_msgs/msg/Odometry", ..record_at("", START_NS, &scan(0)) });
    let folder = Folder::new();
    folder.add("f.mcap", &Form::CHUNKED.write(&records));
    folder
}

#[test]
fn names_of_other_recorders_give_the_same_revolutions() {
    let expected = drain(&mut open_as(&flight_named(LaserScan::SCHEMA_NAME), None, None).expect("scans"));
    for name in ["sensor_msgs::msg::dds_::LaserScan_", "sensor_msgs::msg::LaserScan", "sensor_msgs/LaserScan"] {
        let read = drain(&mut open_as(&flight_named(name), None, None).expect(name));
        assert_eq!((read.seqs, read.ranges), (expected.seqs.clone(), expected.ranges.clone()), "{name}");
    }
}

#[test]
fn a_type_that_nobody_knows_is_read_as_the_one_that_is_asked_for() {
    for name in ["", "my_msgs/msg/Laser"] {
        let folder = flight_named(name);
        let error = open_as(&folder, Some("/scan"), None).err().expect("no scans");
        assert!(matches!(error, IngestError::NotAScanTopic { .. }));
        let mut named = open_as(&folder, Some("/scan"), Some(ScanType::LaserScan)).expect("scans");
        assert_eq!(drain(&mut named).len(), 5);
        let only = open_as(&folder, None, Some(ScanType::LaserScan));
        assert_eq!(only.is_ok(), name.is_empty(), "of several topics with a type one has to be named");
    }
}

#[test]
fn a_topic_is_found_with_and_without_its_slash() {
    let folder = flight_named(LaserScan::SCHEMA_NAME);
    assert_eq!(open_as(&folder, Some("scan"), None).expect("scans").topic(), "/scan");
    let bare = Folder::new();
    bare.add("f.mcap", &Form::CHUNKED.write(&[record_at("scan", START_NS, &scan(0))]));
    assert_eq!(open_as(&bare, Some("/scan"), None).expect("scans").topic(), "scan");
}

fn cloud(points_m: &[[f32; 3]]) -> Record {
    let data: Vec<u8> = points_m.iter().flatten().copied().flat_map(f32::to_le_bytes).collect();
    let fields = ["x", "y", "z"].iter().zip([0, 4, 8]).map(|(name, at)| PointField::new(name, at, NumberType::F32));
    let cloud = PointCloud2 {
        height: 1,
        width: points_m.len() as u32,
        fields: fields.collect(),
        point_step: 12,
        data: data.into(),
        ..PointCloud2::default()
    };
    Record {
        type_name: PointCloud2::SCHEMA_NAME,
        data: cloud.encode(Endian::Little),
        ..record_at("/points", START_NS, &scan(0))
    }
}

#[test]
fn a_cloud_is_no_rival_of_a_laser_scan() {
    let folder = Folder::new();
    folder.add("f.mcap", &Form::CHUNKED.write(&[cloud(&[[1.0; 3]]), record_at("/scan", START_NS, &scan(0))]));
    assert_eq!(open_as(&folder, None, None).expect("scans").topic(), "/scan");
    assert_eq!(open_as(&folder, None, Some(ScanType::PointCloud2)).expect("clouds").topic(), "/points");
}

fn revolution_of(record: Record, sensor: Sensor) -> (Revolution, Vec<String>) {
    let folder = Folder::new();
    let path = folder.add("f.mcap", &Form::CHUNKED.write(&[record]));
    let mut recording = Recording::open(&[path], &ReadOptions::default(), sensor).expect("clouds");
    let (mut revolution, mut notes) = (Revolution::default(), Notes::default());
    assert!(recording.next(&mut revolution, &mut notes).expect("readable"));
    let (mut rest, mut no_notes) = (Revolution::default(), Notes::default());
    assert!(!recording.next(&mut rest, &mut no_notes).expect("readable"));
    (revolution, notes.iter().map(str::to_owned).collect())
}

#[test]
fn a_cloud_is_the_revolution_that_a_level_vehicle_sees() {
    let points_m = [[1.0, 2.0, 0.5], [f32::NAN; 3], [0.0; 3], [-3.0, 0.0, 0.0]];
    let (revolution, notes) = revolution_of(cloud(&points_m), sensor(&[]));
    assert_eq!((&revolution.points_m[..], &revolution.entries[..]), (&[Point::new(-3.0, 0.0, 0.0)][..], &[-2, 0][..]));
    assert_eq!(
        notes,
        [
            "1 point at the sensor itself read as no return",
            "1 return above or below the vehicle, or within it, ignored",
            "no stamp: the time of recording is used"
        ]
    );
}

#[test]
fn a_slice_of_a_cloud_has_the_rings_that_are_asked_for() {
    let points_m =
        [[1.0, 2.0, 0.0], [2.0, 0.0, 0.0], [-3.0, 0.0, 0.0], [4.0, 1.0, 0.0]].map(|place_m| place_m.map(f64::from));
    let of_rings = |rings: Vec<u32>| {
        let cloud = Cloud { points_m: points_m.to_vec(), rings, ..Cloud::default() };
        let data = PointCloud2::from(&cloud).encode(Endian::Little);
        let sensor = sensor(&[("rings", vec![vec![2.0, 2.0], vec![5.0, 9.0]].into())]);
        let (revolution, notes) = revolution_of(Record { data, ..self::cloud(&[]) }, sensor);
        (revolution.points_m.iter().map(|point_m| point_m.x).collect::<Vec<_>>(), revolution.entries.len(), notes)
    };
    let (taken, entries, notes) = of_rings(vec![1, 2, 7, 10]);
    assert_eq!((taken, entries), (vec![2.0, -3.0], 2));
    assert!(notes.contains(&"2 points of other rings than ingest.rings left out".to_owned()), "{notes:?}");
    let (_, entries, notes) = of_rings(Vec::new());
    assert_eq!(entries, 4);
    assert!(notes.iter().any(|note| note.contains("does not state rings")), "{notes:?}");
}

#[test]
fn mounting_limits_and_masks_hold_for_clouds() {
    let points_m = [[1.0, 2.0, 0.25], [0.1, 0.0, 0.0], [90.0, 0.0, 0.0], [-3.0, 1.0, 0.0]];
    let sensor = sensor(&[
        ("upside_down", Value::Boolean(true)),
        ("min_range_m", Value::Float(0.5)),
        ("max_range_m", Value::Float(50.0)),
        ("masked_sectors_rad", vec![vec![-3.1, -2.5]].into()),
    ]);
    let (revolution, notes) = revolution_of(cloud(&points_m), sensor);
    assert_eq!(revolution.points_m, [Point::new(1.0, -2.0, 0.0)]);
    for note in
        ["1 point nearer than min_range_m 0.5 m", "1 point beyond max_range_m 50 m", "1 point in masked sectors"]
    {
        assert!(notes.iter().any(|noted| noted.starts_with(note)), "{note}: {notes:?}");
    }
}
