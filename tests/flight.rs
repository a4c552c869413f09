//! Small flights made in memory: a straight tunnel, written as by a ROS 2 recorder.

use std::f32::consts::PI;
use std::io::Cursor;
use std::path::{Path, PathBuf};

use crosscut_messages::{CDR_ENCODING, Endian, Header, LaserScan, Message, SCHEMA_ENCODING, Time};
use mcap::records::MessageHeader;

/// Time between scans of these flights.
pub(crate) const PERIOD_NS: u64 = 100_000_000;

/// A scan in the middle of a tunnel 6 m wide, seen to 12 m.
pub(crate) fn tunnel_scan(seq: u64) -> LaserScan {
    let (beams, range_max) = (180, 12.0);
    let angle_increment = 2.0 * PI / beams as f32;
    let range = |beam: usize| {
        let range = 3.0 / (-PI + (beam as f32 + 0.5) * angle_increment).sin().abs();
        if range < range_max { range } else { f32::INFINITY }
    };
    let stamp_ns = (seq + 1) * PERIOD_NS;
    LaserScan {
        header: Header { stamp: Time::from_ns(stamp_ns), frame_id: "lidar".into() },
        angle_min: -PI + 0.5 * angle_increment,
        angle_max: PI - 0.5 * angle_increment,
        angle_increment,
        range_min: 0.1,
        range_max,
        ranges: (0..beams).map(range).collect(),
        ..Default::default()
    }
}

/// The form in which a flight is written.
pub(crate) struct Writing {
    pub(crate) compression: Option<mcap::Compression>,
    pub(crate) chunked: bool,
    pub(crate) endian: Endian,
    pub(crate) topics: &'static [&'static str],
}

impl Default for Writing {
    fn default() -> Self {
        Self { compression: None, chunked: true, endian: Endian::Little, topics: &["/scan"] }
    }
}

/// An MCAP of these scans, on each of the topics.
pub(crate) fn bytes(scans: &[LaserScan], writing: &Writing) -> Vec<u8> {
    let options = mcap::WriteOptions::new()
        .compression(writing.compression)
        .use_chunks(writing.chunked)
        .chunk_size(Some(8 * 1024))
        .profile("ros2");
    let mut writer = options.create(Cursor::new(Vec::new())).expect("memory");
    let schema =
        writer.add_schema(LaserScan::SCHEMA_NAME, SCHEMA_ENCODING, LaserScan::SCHEMA_TEXT.as_bytes()).expect("memory");
    for topic in writing.topics {
        let channel_id = writer.add_channel(schema, topic, CDR_ENCODING, &Default::default()).expect("memory");
        for (i, scan) in scans.iter().enumerate() {
            let time = (i as u64 + 1) * PERIOD_NS;
            let header = MessageHeader { channel_id, sequence: i as u32, log_time: time, publish_time: time };
            writer.write_to_known_channel(&header, &scan.encode(writing.endian)).expect("memory");
        }
    }
    writer.finish().expect("memory");
    writer.into_inner().into_inner()
}

/// A flight with this number of scans of a straight tunnel.
pub(crate) fn tunnel(scans: u64, writing: &Writing) -> Vec<u8> {
    bytes(&(0..scans).map(tunnel_scan).collect::<Vec<_>>(), writing)
}

/// Writes bytes to a file in `folder` and returns its path.
pub(crate) fn file(folder: &Path, name: &str, bytes: &[u8]) -> PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, bytes).expect("the temporary folder can be written");
    path
}
