//! What is fuzzed: every decoder of messages, and whole recordings of every container.
//!
//! A target takes any bytes and panics if what is read from them is wrong: more values than bytes, another value in a
//! used place than in a new one, a value that does not survive being written. [`TARGETS`] lists them with their names;
//! `seeds` makes the inputs that fuzzing starts from, and `tests/corpus.rs` runs them on stable Rust.

#[allow(dead_code)] // each uses a part of it
#[path = "../../crates/ingest/tests/ingest/bags.rs"]
mod bags;
#[allow(dead_code)] // each uses a part of it
#[path = "../../crates/ingest/tests/ingest/cloud_files.rs"]
mod cloud_files;
#[allow(dead_code)] // each uses a part of it
#[path = "../../crates/ingest/tests/ingest/flight.rs"]
mod flight;
pub mod seeds;

use std::cell::RefCell;
use std::io::Cursor;
use std::path::PathBuf;

use crosscut_ingest::{CSV_PARAMS, CsvGeometry, ReadOptions, Recording, Truths, convert, describe};
use crosscut_messages::{
    Cloud, Echo, Endian, LaserScan, Message, Odometry, ScanDecoder, ScanMessage, TfMessage, Truth,
};
use crosscut_stage::{Notes, Params, Revolution, Source as _, Value};

use crate::flight::{Folder, sensor};

/// Reads bytes of strangers; a panic is a finding.
pub type Target = fn(&[u8]);

/// Every target, by the name of its program.
pub const TARGETS: &[(&str, Target)] = &[
    ("laser_scan", laser_scan),
    ("echoes", echoes),
    ("cloud", cloud),
    ("foxglove_scan", foxglove_scan),
    ("foxglove_cloud", foxglove_cloud),
    ("odometry", odometry),
    ("transforms", transforms),
    ("truth", truth),
    ("mcap", mcap),
    ("bag", bag),
    ("database", database),
    ("carmen", carmen),
    ("table", table),
    ("pcd", pcd),
    ("ply", ply),
    ("compressed", compressed),
];

/// `sensor_msgs/LaserScan` in CDR of both versions and in the encoding of ROS 1.
pub fn laser_scan(data: &[u8]) {
    scan("sensor_msgs/LaserScan", &["cdr", "ros1"], data);
}

/// `sensor_msgs/MultiEchoLaserScan` in CDR and ROS 1, by each choice of an echo.
pub fn echoes(data: &[u8]) {
    scan("sensor_msgs/MultiEchoLaserScan", &["cdr", "ros1"], data);
}

/// `sensor_msgs/PointCloud2` in CDR and ROS 1.
pub fn cloud(data: &[u8]) {
    scan("sensor_msgs/PointCloud2", &["cdr", "ros1"], data);
}

/// `foxglove.LaserScan` in JSON and protobuf.
pub fn foxglove_scan(data: &[u8]) {
    scan("foxglove.LaserScan", &["json", "protobuf", "cdr", "ros1"], data);
}

/// `foxglove.PointCloud` in JSON and protobuf.
pub fn foxglove_cloud(data: &[u8]) {
    scan("foxglove.PointCloud", &["json", "protobuf", "cdr", "ros1"], data);
}

/// `nav_msgs/Odometry` in CDR and ROS 1.
pub fn odometry(data: &[u8]) {
    message::<Odometry>(data);
}

/// `tf2_msgs/TFMessage` in CDR and ROS 1.
pub fn transforms(data: &[u8]) {
    message::<TfMessage>(data);
}

/// The truth in JSON.
pub fn truth(data: &[u8]) {
    if let Ok(truth) = Truth::from_json(data) {
        let again = Truth::from_json(&truth.to_json()).expect("what was written can be read");
        assert_eq!(again.labels, truth.labels);
    }
}

/// An MCAP.
pub fn mcap(data: &[u8]) {
    recording(::mcap::MAGIC, data);
}

/// A bag of ROS 1.
pub fn bag(data: &[u8]) {
    recording(b"#ROSBAG V2.0\n", data);
}

/// A rosbag2 database.
pub fn database(data: &[u8]) {
    recording(b"SQLite format 3\0", data);
}

/// A CARMEN log.
pub fn carmen(data: &[u8]) {
    recording(b"FLASER ", data);
}

/// A table of ranges.
pub fn table(data: &[u8]) {
    recording(b"", data);
}

/// A PCD file.
pub fn pcd(data: &[u8]) {
    recording(b"# .PCD", data);
}

/// A PLY file.
pub fn ply(data: &[u8]) {
    recording(b"ply\n", data);
}

/// A file that is compressed as a whole.
pub fn compressed(data: &[u8]) {
    recording(b"\x28\xb5\x2f\xfd", data);
}

/// Decodes scans or clouds into a new place and a used one.
fn scan(schema: &str, encodings: &[&str], data: &[u8]) {
    for encoding in encodings {
        let mut decoder = ScanDecoder::for_schema(schema, "", encoding).expect("a type that is read");
        for echo in [Echo::First, Echo::Last, Echo::Strongest] {
            decoder.echo = echo;
            let mut new = ScanMessage::default();
            if decoder.decode_into(data, &mut new).is_err() {
                break;
            }
            let mut used = used(decoder.gives_clouds());
            decoder.decode_into(data, &mut used).expect("it could be read before");
            match (&new, &used) {
                (ScanMessage::Scan(new), ScanMessage::Scan(used)) => {
                    assert!(new.ranges.len() <= data.len() && new.intensities.len() <= data.len());
                    assert_eq!(new.encode(Endian::Little), used.encode(Endian::Little), "of a used place");
                }
                (ScanMessage::Cloud(new), ScanMessage::Cloud(used)) => {
                    assert!(new.points_m.len() <= data.len());
                    let is_each = |count: usize| count == 0 || count == new.points_m.len();
                    assert!(is_each(new.times_s.len()) && is_each(new.rings.len()));
                    assert_eq!(format!("{new:?}"), format!("{used:?}"), "of a used place");
                }
                _ => panic!("a scan became a cloud"),
            }
        }
    }
}

/// A place that held another message before.
fn used(is_cloud: bool) -> ScanMessage {
    if is_cloud {
        let (points_m, times_s, rings) = (vec![[1.0; 3]; 9], vec![1.0; 9], vec![1; 9]);
        return ScanMessage::Cloud(Cloud { points_m, times_s, rings, ..Cloud::default() });
    }
    let (ranges, intensities) = (vec![1.0; 9], vec![2.0; 7]);
    ScanMessage::Scan(LaserScan { ranges, intensities, ..LaserScan::default() })
}

/// Decodes messages that are not scans; what was read survives being written.
fn message<M: Message>(data: &[u8]) {
    let (mut ros1, mut cdr) = (M::default(), M::default());
    let are_whole = [ros1.decode_ros1_into(data).is_ok(), cdr.decode_into(data).is_ok()];
    for (message, is_whole) in [&ros1, &cdr].into_iter().zip(are_whole) {
        if is_whole {
            for endian in [Endian::Little, Endian::Big] {
                let written = message.encode(endian);
                let again = M::decode(&written).expect("what was written can be read");
                assert_eq!(again.encode(endian), written);
            }
        }
    }
}

thread_local! {
    /// Where the file of the moment is; on a disk in memory if TMPDIR names one.
    static FILE: RefCell<(Folder, PathBuf)> = RefCell::new({
        let folder = Folder::new();
        let path = folder.path().join("recording");
        (folder, path)
    });
}

/// Reads a file that begins with `start` and goes on with `data` in every way there is.
fn recording(start: &[u8], data: &[u8]) {
    let mut bytes = data.to_vec();
    bytes.resize(bytes.len().max(start.len()), 0);
    bytes[..start.len()].copy_from_slice(start);
    FILE.with_borrow(|(_, path)| {
        std::fs::write(path, &bytes).expect("a temporary file");
        let options = ReadOptions { csv: geometry(), ..ReadOptions::default() };
        let _ = describe(path, &sensor(&[]), &options);
        if let Ok(mut truths) = Truths::open(path) {
            let _ = truths.at(flight::time_ns(0));
        }
        let inputs = std::slice::from_ref(path);
        let Ok(mut flight) = Recording::open(inputs, &options, sensor(&[])) else { return };
        let (mut revolution, mut scans) = (Revolution::default(), 0);
        while let Ok(true) = flight.next(&mut revolution, &mut Notes::default()) {
            scans += 1;
            assert!(revolution.points_m.len() <= 1 << 20, "a scan has more returns than there may be beams");
        }
        if let Ok(converted) = convert(inputs, &options, sensor(&[]).echo(), Cursor::new(Vec::new()), || ()) {
            assert!(scans == 0 || !converted.messages.is_empty(), "{scans} scans are not converted");
        }
    });
}

fn geometry() -> CsvGeometry {
    let mut params = Params::defaults(CSV_PARAMS);
    for (name, value) in [("last_rad", 0.7), ("range_max_m", 30.0)] {
        params.set(name, Value::Float(value)).expect("allowed");
    }
    CsvGeometry::new(&params)
}
