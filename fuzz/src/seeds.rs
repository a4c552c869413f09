//! The inputs that fuzzing starts from: a small whole message or recording of every kind.

use std::io::Write as _;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use crosscut_messages::{
    Endian, Header, LaserEcho, LaserScan, Message, MultiEchoLaserScan, NumberType, Odometry, PointCloud2, PointField,
    TfMessage, Time, TransformStamped, Truth,
};

use crate::bags::{BAG_COMPRESSIONS, ros1_bag, rosbag2};
use crate::cloud_files;
use crate::flight::{Form, Record, plain_flight, ros1_record_at, scan, time_ns};

/// The seeds of a target, each whole.
pub fn of(target: &str) -> Vec<Vec<u8>> {
    match target {
        "laser_scan" => [in_cdr(&scan(3)), vec![ros1_record_at("/scan", 0, &scan(3)).data]].concat(),
        "echoes" => in_cdr(&echoes()),
        "cloud" => {
            let [little, big] = [Endian::Little, Endian::Big].map(|endian| cloud().encode(endian));
            [versions(little), versions(big), vec![ros1_cloud()]].concat()
        }
        "foxglove_scan" => vec![FOXGLOVE_SCAN.as_bytes().to_vec(), PROTOBUF_SCAN.to_vec()],
        "foxglove_cloud" => vec![foxglove_cloud().into_bytes(), PROTOBUF_CLOUD.to_vec()],
        // A sequence number, a stamp, two empty texts and 85 numbers in ROS 1.
        "odometry" => [in_cdr(&Odometry::default()), vec![vec![0; 4 + 8 + 2 * 4 + 85 * 8]]].concat(),
        // One transform: the same with 7 numbers.
        "transforms" => {
            let transforms = vec![TransformStamped { header: header(), ..TransformStamped::default() }; 2];
            let ros1 = [&1u32.to_le_bytes()[..], &[0; 4 + 8 + 2 * 4 + 7 * 8]].concat();
            [in_cdr(&TfMessage { transforms }), vec![ros1]].concat()
        }
        "truth" => vec![Truth { labels: vec![0, 1, -1, -2], walls: 2, ..Truth::default() }.to_json()],
        "mcap" => Form::all().into_iter().map(mcap).collect(),
        "bag" => {
            let flight: Vec<Record> = (0..6).map(|i| ros1_record_at("/scan", time_ns(i), &scan(i))).collect();
            let bag = |compression, is_indexed| ros1_bag(&flight, compression, is_indexed).bytes;
            BAG_COMPRESSIONS.iter().flat_map(|name| [bag(name, true), bag(name, false)]).collect()
        }
        "database" => {
            let mut long = plain_flight(2);
            long.iter_mut().for_each(|record| record.data.resize(1200, 0));
            vec![rosbag2(&plain_flight(6)).bytes, rosbag2(&long).bytes]
        }
        "carmen" => vec![CARMEN.as_bytes().to_vec()],
        "table" => TABLES.iter().map(|text| text.as_bytes().to_vec()).collect(),
        "pcd" | "ply" => {
            let files = cloud_files::all().into_iter().filter(|(name, _)| name.ends_with(target));
            files.map(|(_, bytes)| bytes).collect()
        }
        "compressed" => compressed(),
        _ => Vec::new(),
    }
}

fn header() -> Header {
    Header { stamp: Time { sec: 7, nanosec: 8 }, frame_id: "lidar".to_owned() }
}

/// A message in both byte orders and both versions of CDR; the second differs only where there are numbers of 8 bytes.
fn in_cdr(message: &impl Message) -> Vec<Vec<u8>> {
    [Endian::Little, Endian::Big].into_iter().flat_map(|endian| versions(message.encode(endian))).collect()
}

fn versions(first: Vec<u8>) -> Vec<Vec<u8>> {
    let mut second = first.clone();
    second[1] |= 0x06;
    vec![first, second]
}

fn echoes() -> MultiEchoLaserScan {
    let echo = |echoes: &[f32]| LaserEcho { echoes: echoes.to_vec() };
    MultiEchoLaserScan {
        geometry: LaserScan { header: header(), angle_increment: 0.5, range_max: 9.0, ..LaserScan::default() },
        ranges: vec![echo(&[1.0, 2.0]), echo(&[]), echo(&[4.0])],
        intensities: vec![echo(&[7.0, 9.0]), echo(&[])],
    }
}

fn cloud() -> PointCloud2<'static> {
    let fields = [("x", 0, NumberType::F32), ("y", 4, NumberType::F32), ("z", 8, NumberType::F32)];
    let more = [("ring", 12, NumberType::U16), ("t", 14, NumberType::U32)];
    PointCloud2 {
        header: header(),
        height: 2,
        width: 2,
        fields: fields.into_iter().chain(more).map(|(name, at, number)| PointField::new(name, at, number)).collect(),
        is_bigendian: false,
        point_step: 18,
        row_step: 36,
        data: vec![1; 72].into(),
        is_dense: true,
    }
}

/// A cloud of one point with x and y.
fn ros1_cloud() -> Vec<u8> {
    let mut bytes = [[0; 16].as_slice(), &[1, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0]].concat();
    for (name, offset) in [(b"x", 0), (b"y", 4)] {
        bytes.extend([1, 0, 0, 0, name[0], offset, 0, 0, 0, 7, 1, 0, 0, 0]);
    }
    bytes.extend([0, 8, 0, 0, 0, 8, 0, 0, 0, 8, 0, 0, 0, 0, 0, 128, 63, 0, 0, 0, 64, 1]);
    bytes
}

const FOXGLOVE_SCAN: &str = r#"{"timestamp":{"sec":7,"nsec":8},"frame_id":"lidar","pose":{"position":{"x":0,"y":0,"z":0},
"orientation":{"x":0,"y":0,"z":1,"w":1}},"start_angle":-1,"end_angle":1,"ranges":[1.5,null,"Infinity"],"intensities":[]}"#;

fn foxglove_cloud() -> String {
    let data = STANDARD.encode([1.0f32, 2.0, 3.0].map(f32::to_le_bytes).concat());
    format!(
        r#"{{"timestamp":{{"sec":7,"nsec":8}},"frame_id":"lidar","pose":{{"position":{{"x":1,"y":0,"z":0}}}},
        "point_stride":12,"fields":[{{"name":"x","offset":0,"type":7}},{{"name":"y","offset":4,"type":7}}],"data":"{data}"}}"#
    )
}

/// `foxglove.LaserScan`: a time, a frame, -1 to 1 rad, two ranges.
#[rustfmt::skip]
const PROTOBUF_SCAN: &[u8] = &[
    0x0a, 4, 0x08, 7, 0x10, 8, 0x12, 1, b'l', 0x21, 0, 0, 0, 0, 0, 0, 0xf0, 0xbf, 0x29, 0, 0, 0, 0, 0, 0, 0xf0, 0x3f,
    0x32, 16, 0, 0, 0, 0, 0, 0, 0xf8, 0x3f, 0, 0, 0, 0, 0, 0, 0xf8, 0x7f,
];

/// `foxglove.PointCloud`: 8 bytes a point, x and y of type 7, one point.
#[rustfmt::skip]
const PROTOBUF_CLOUD: &[u8] = &[
    0x25, 8, 0, 0, 0, 0x2a, 10, 0x0a, 1, b'x', 0x15, 0, 0, 0, 0, 0x18, 7, 0x2a, 10, 0x0a, 1, b'y', 0x15, 4, 0, 0, 0,
    0x18, 7, 0x32, 8, 0, 0, 128, 63, 0, 0, 0, 64,
];

/// A flight without checksums, which no fuzzer would guess: scans, odometry, transforms and truth.
fn mcap(form: Form) -> Vec<u8> {
    let mut records = plain_flight(6);
    let record =
        |topic, type_name, encoding, data| Record { topic, type_name, encoding, log_time_ns: time_ns(0), data };
    records.push(record("/odom", Odometry::SCHEMA_NAME, "cdr", Odometry::default().encode(Endian::Little)));
    records.push(record("/tf", TfMessage::SCHEMA_NAME, "cdr", TfMessage::default().encode(Endian::Little)));
    records.push(record("/truth", crosscut_messages::TRUTH_SCHEMA_NAME, "json", Truth::default().to_json()));
    form.write_unchecked(&records)
}

const CARMEN: &str = "FLASER 4 1 2 3 4 0 0 0 5 6 0 10.5 host 0.1\nPARAM robot_front_laser_max 50.0 host 0\n\
    ODOM 1 2 0 0.5 0.1 0 9.5 host 0\n\
    ROBOTLASER1 0 -1.5 3 0.5 30 0.01 0 3 1 2 3 2 7 8 0 0 0 4 5 0.5 0 0 0 0 0 1232658478.25 host 0\n";

const TABLES: [&str; 5] = [
    "\u{feff}stamp_ns,r0,r1,r2\r\n1700000000000000000,1,2,3\r\n1700000000100000000,1,nan,inf\r\n",
    "1.5,nan,inf,1,2,1,2,1\n\n2,,4,1,2,1,2,1\n",
    "time;r1;r2;r3 (mm)\n0,1;1,5;2,5;3\n0,2;1,5;2,5;3\n",
    "%time,field.header.stamp,field.angle_min,field.angle_increment,field.ranges0,field.ranges1,field.intensities0,field.intensities1\n7,5,-0.1,0.2,1.5,inf,47,47\n8,6,-0.1,0.2,1.5,inf,2.5,47,47,47\n",
    "1700000000,5,laser,-0.1,0.1,0.1,0.0,0.1,0.05,30.0,1.5,nan,inf,\n",
];

/// Small files in every compression of whole files.
fn compressed() -> Vec<Vec<u8>> {
    let plain = rosbag2(&plain_flight(2)).bytes;
    let mut bz2 = bzip2::write::BzEncoder::new(Vec::new(), bzip2::Compression::fast());
    bz2.write_all(&plain).expect("in memory");
    let mut lz4 = lz4::EncoderBuilder::new().build(Vec::new()).expect("in memory");
    lz4.write_all(&plain).expect("in memory");
    let zstd = zstd::encode_all(&plain[..], 1).expect("in memory");
    vec![zstd, bz2.finish().expect("in memory"), lz4.finish().0]
}
