//! Scans of every type and encoding, whole and damaged.

use base64::Engine as _;
use crosscut_messages::{
    Cloud, DecodeError, Echo, Endian, Header, LaserEcho, LaserScan, MOST_BEAMS, MOST_FIELDS, MOST_POINTS, Message,
    MultiEchoLaserScan, NumberType, PointCloud2, PointField, ScanDecoder, ScanMessage, Time,
};
use proptest::prelude::{any, prop, prop_assert, prop_assert_eq, proptest};

fn header() -> Header {
    Header { stamp: Time { sec: 7, nanosec: 8 }, frame_id: "lidar".to_owned() }
}

fn decode(schema: &str, encoding: &str, message: &[u8]) -> Result<ScanMessage, DecodeError> {
    let mut out = ScanMessage::default();
    ScanDecoder::for_schema(schema, "", encoding).expect("a scan").decode_into(message, &mut out)?;
    Ok(out)
}

fn cloud_of(message: ScanMessage) -> Cloud {
    let ScanMessage::Cloud(cloud) = message else { panic!("no cloud") };
    cloud
}

fn scan_of(message: ScanMessage) -> LaserScan {
    let ScanMessage::Scan(scan) = message else { panic!("no scan") };
    scan
}

/// Two rows of two points: z, an unused byte, y, x, ring and time, each row padded by 3 bytes.
fn packed(is_bigendian: bool) -> PointCloud2<'static> {
    let mut data = Vec::new();
    for point in 0..4u16 {
        let [x, y, z] = [f64::from(point), 10.0, -1.5];
        let mut put = |little: &[u8], big: &[u8]| data.extend_from_slice(if is_bigendian { big } else { little });
        put(&(z as f32).to_le_bytes(), &(z as f32).to_be_bytes());
        put(&[0xff], &[0xff]);
        put(&(y as i16).to_le_bytes(), &(y as i16).to_be_bytes());
        put(&x.to_le_bytes(), &x.to_be_bytes());
        put(&point.to_le_bytes(), &point.to_be_bytes());
        let time_ns = 1000 * u32::from(point);
        put(&time_ns.to_le_bytes(), &time_ns.to_be_bytes());
        if point % 2 == 1 {
            data.extend([0; 3]);
        }
    }
    PointCloud2 {
        header: header(),
        height: 2,
        width: 2,
        fields: vec![
            PointField::new("x", 7, NumberType::F64),
            PointField::new("y", 5, NumberType::I16),
            PointField::new("z", 0, NumberType::F32),
            PointField::new("ring", 15, NumberType::U16),
            PointField::new("t", 17, NumberType::U32),
        ],
        is_bigendian,
        point_step: 21,
        row_step: 45,
        data: data.into(),
        is_dense: true,
    }
}

fn unpacked() -> Cloud {
    Cloud {
        header: header(),
        points_m: (0..4).map(|point| [f64::from(point), 10.0, -1.5]).collect(),
        times_s: (0..4).map(|point| f64::from(1000 * point) * 1e-9).collect(),
        rings: (0..4).collect(),
    }
}

#[test]
fn fields_of_any_order_type_and_byte_order_are_unpacked() {
    for is_bigendian in [false, true] {
        for endian in [Endian::Little, Endian::Big] {
            let bytes = packed(is_bigendian).encode(endian);
            assert_eq!(cloud_of(decode(PointCloud2::SCHEMA_NAME, "cdr", &bytes).expect("a cloud")), unpacked());
        }
    }
    // The last row need not be padded, and a row_step of 0 means that no row is.
    let mut bare = packed(false);
    bare.data.to_mut().truncate(87);
    assert!(decode(PointCloud2::SCHEMA_NAME, "cdr", &bare.encode(Endian::Little)).is_ok());
    let flat = PointCloud2 { row_step: 0, width: 1, height: 1, ..packed(false) };
    let cloud = cloud_of(decode(PointCloud2::SCHEMA_NAME, "cdr", &flat.encode(Endian::Little)).expect("a point"));
    assert_eq!(cloud.points_m, [[0.0, 10.0, -1.5]]);
}

#[test]
fn a_cloud_written_as_a_message_is_read_back() {
    let bare = Cloud { times_s: Vec::new(), rings: Vec::new(), ..unpacked() };
    for cloud in [unpacked(), bare, Cloud::default()] {
        let bytes = PointCloud2::from(&cloud).encode(Endian::Little);
        assert_eq!(cloud_of(decode(PointCloud2::SCHEMA_NAME, "cdr", &bytes).expect("a cloud")), cloud);
    }
}

#[test]
fn clouds_that_claim_more_than_they_have_are_refused() {
    let refused = |cloud: &PointCloud2| {
        decode(PointCloud2::SCHEMA_NAME, "cdr", &cloud.encode(Endian::Little)).expect_err("must be refused").to_string()
    };
    let all = u32::MAX;
    assert!(refused(&PointCloud2 { width: all, height: all, ..packed(false) }).contains("but it has 90"));
    assert!(refused(&PointCloud2 { row_step: all, ..packed(false) }).contains("data"));
    assert!(refused(&PointCloud2 { point_step: 0, ..packed(false) }).contains("beyond the 0 bytes"));
    let named = |name, offset, number| vec![PointField::new(name, offset, number)];
    assert!(refused(&PointCloud2 { fields: named("y", 0, NumberType::F32), ..packed(false) }).contains("no `x`"));
    assert!(refused(&PointCloud2 { fields: named("x", all, NumberType::F32), ..packed(false) }).contains("beyond"));
    let mut unknown = packed(false);
    unknown.fields[0].datatype = 9;
    assert!(refused(&unknown).contains("type of `x`"));
}

#[test]
fn more_points_beams_or_levels_than_the_limit_are_refused() {
    let fields = vec![PointField::new("x", 0, NumberType::I8), PointField::new("y", 1, NumberType::I8)];
    let (width, data) = (MOST_POINTS as u32 + 1, vec![0; 2 * MOST_POINTS + 2].into());
    let large = PointCloud2 { height: 1, width, fields, point_step: 2, data, ..PointCloud2::default() };
    let error = decode(PointCloud2::SCHEMA_NAME, "cdr", &large.encode(Endian::Little)).expect_err("too many");
    assert!(error.to_string().contains("16777217 points are more than 16777216"), "{error}");
    let wide = LaserScan { ranges: vec![1.0; MOST_BEAMS + 1], ..LaserScan::default() };
    let error = decode(LaserScan::SCHEMA_NAME, "cdr", &wide.encode(Endian::Little)).expect_err("too many");
    assert!(error.to_string().contains("1048577 are more than 1048576"), "{error}");
    // An empty field takes 2 bytes of protobuf; the byte after the fields would be an error of its own.
    let fields = [[0x2a, 0].repeat(MOST_FIELDS + 1), vec![0xff]].concat();
    let error = decode("foxglove.PointCloud", "protobuf", &fields).expect_err("too many");
    assert!(error.to_string().contains("more than 4096"), "{error}");
    let fields = format!("{{\"fields\":[{}", "{},".repeat(MOST_FIELDS + 1));
    let error = decode("foxglove.PointCloud", "json", fields.as_bytes()).expect_err("too many");
    assert!(error.to_string().contains("more than 4096"), "{error}");
    let levels = 1 << 20;
    let unknown = format!("{{\"other\":{}{}}}", "[".repeat(levels), "]".repeat(levels));
    assert!(decode("foxglove.LaserScan", "json", unknown.as_bytes()).is_ok(), "passed over without recursion");
    // Group 15 in group 15, which no field of the schema is.
    let groups = |count: usize| [vec![0x7b; count], vec![0x7c; count]].concat();
    assert!(decode("foxglove.LaserScan", "protobuf", &groups(100)).is_ok());
    assert!(decode("foxglove.LaserScan", "protobuf", &groups(101)).is_err());
}

#[test]
fn a_cloud_cut_at_any_byte_is_an_error_and_no_panic() {
    for bytes in [packed(true).encode(Endian::Little), packed(false).encode(Endian::Big)] {
        for length in 0..bytes.len() {
            assert!(decode(PointCloud2::SCHEMA_NAME, "cdr", &bytes[..length]).is_err(), "{length}");
        }
    }
}

fn echoes() -> MultiEchoLaserScan {
    let echo = |echoes: &[f32]| LaserEcho { echoes: echoes.to_vec() };
    MultiEchoLaserScan {
        geometry: LaserScan { header: header(), angle_increment: 0.5, range_max: 9.0, ..LaserScan::default() },
        ranges: vec![echo(&[1.0, 2.0, 3.0]), echo(&[]), echo(&[4.0, 5.0])],
        intensities: vec![echo(&[7.0, 9.0, 8.0]), echo(&[])],
    }
}

#[test]
fn each_beam_gives_the_echo_that_is_asked_for() {
    for endian in [Endian::Little, Endian::Big] {
        let bytes = echoes().encode(endian);
        let mut decoder = ScanDecoder::for_schema(MultiEchoLaserScan::SCHEMA_NAME, "", "cdr").expect("a scan");
        for (echo, ranges) in [
            (Echo::First, [1.0, f32::INFINITY, 4.0]),
            (Echo::Last, [3.0, f32::INFINITY, 5.0]),
            (Echo::Strongest, [2.0, f32::INFINITY, 4.0]),
        ] {
            decoder.echo = echo;
            let mut out = ScanMessage::default();
            decoder.decode_into(&bytes, &mut out).expect("whole");
            let expected = LaserScan { ranges: ranges.to_vec(), ..echoes().geometry };
            assert_eq!(scan_of(out), expected, "{echo:?}");
        }
        for length in 0..bytes.len() {
            assert!(decode(MultiEchoLaserScan::SCHEMA_NAME, "cdr", &bytes[..length]).is_err(), "{length}");
        }
    }
}

#[test]
fn foxglove_scans_in_json_are_read_with_null_as_no_number() {
    let text = r#"{"timestamp":{"sec":7,"nsec":8},"frame_id":"lidar","pose":{"position":{"x":0,"y":0,"z":0},
        "orientation":{"x":0,"y":0,"z":1,"w":1}},"start_angle":-1,"end_angle":1,"ranges":[1.5,null,"Infinity"],
        "intensities":[]}"#;
    let scan = scan_of(decode("foxglove.LaserScan", "json", text.as_bytes()).expect("a scan"));
    assert_eq!((scan.header, scan.angle_increment, scan.range_max), (header(), 1.0, f32::INFINITY));
    assert!((scan.angle_min - (std::f32::consts::FRAC_PI_2 - 1.0)).abs() < 1e-6, "turned by its pose");
    assert!(scan.ranges[0] == 1.5 && scan.ranges[1].is_nan() && scan.ranges[2] == f32::INFINITY);
    for length in 0..text.len() {
        assert!(decode("foxglove.LaserScan", "json", &text.as_bytes()[..length]).is_err(), "{length}");
    }
    let torn = [&br#"{"frame_id":""#[..], &[0xff], br#"","ranges":[1]}"#].concat();
    assert_eq!(scan_of(decode("foxglove.LaserScan", "json", &torn).expect("a scan")).ranges, [1.0]);
}

#[test]
fn foxglove_clouds_in_json_are_moved_by_their_pose() {
    let packed = [1.0f32, 2.0, 3.0].map(f32::to_le_bytes).concat();
    let data = base64::engine::general_purpose::STANDARD.encode(packed);
    let text = format!(
        r#"{{"timestamp":{{"sec":7,"nsec":8}},"frame_id":"lidar","pose":{{"position":{{"x":10,"y":0,"z":0}},
        "orientation":{{"x":0,"y":0,"z":1,"w":1}}}},"point_stride":12,"fields":[{{"name":"x","offset":0,"type":7}},
        {{"name":"y","offset":4,"type":7}},{{"name":"z","offset":8,"type":7}}],"data":"{data}"}}"#
    );
    let cloud = cloud_of(decode("foxglove.PointCloud", "json", text.as_bytes()).expect("a cloud"));
    assert_eq!((cloud.header, cloud.points_m), (header(), vec![[8.0, 1.0, 3.0]]));
}

/// The first fields of a `foxglove_msgs` in CDR, little endian: 7 s 8 ns, `lidar`, and a pose at x = 10 m that is turned by 90°.
fn foxglove_msgs_head() -> Vec<u8> {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let pose = [10.0, 0.0, 0.0, 0.0, 0.0, half, half].map(f64::to_le_bytes).concat();
    // Doubles are aligned to 8 bytes from the end of the header of 4 on.
    [&[0, 1, 0, 0, 7, 0, 0, 0, 8, 0, 0, 0, 6, 0, 0, 0][..], b"lidar\0\0\0\0\0\0\0", &pose].concat()
}

#[test]
fn scans_and_clouds_of_foxglove_msgs_are_read_in_cdr() {
    let ranges = [1.5, f64::NAN, f64::INFINITY].map(f64::to_le_bytes).concat();
    let angles = [-1.0, 1.0].map(f64::to_le_bytes).concat();
    let bytes = [&foxglove_msgs_head()[..], &angles, &[3, 0, 0, 0, 0, 0, 0, 0], &ranges, &[0; 4]].concat();
    let scan = scan_of(decode("foxglove_msgs/msg/LaserScan", "cdr", &bytes).expect("a scan"));
    assert_eq!((scan.header, scan.angle_increment, scan.ranges[0]), (header(), 1.0, 1.5));
    assert!((scan.angle_min - (std::f32::consts::FRAC_PI_2 - 1.0)).abs() < 1e-6, "turned by its pose");
    for length in 0..bytes.len() {
        assert!(decode("foxglove_msgs/msg/LaserScan", "cdr", &bytes[..length]).is_err(), "{length}");
    }
    let field = |name: u8, offset: u8, pad: usize| {
        [&[2, 0, 0, 0, name, 0, 0, 0, offset, 0, 0, 0, 7][..], &vec![0; pad]].concat()
    };
    let points = [1.0f32, 2.0, 3.0].map(f32::to_le_bytes).concat();
    let fields = [field(b'x', 0, 3), field(b'y', 4, 3), field(b'z', 8, 3)].concat();
    let bytes = [&foxglove_msgs_head()[..], &[12, 0, 0, 0, 3, 0, 0, 0], &fields, &[12, 0, 0, 0], &points].concat();
    let cloud = cloud_of(decode("foxglove_msgs/msg/PointCloud", "cdr", &bytes).expect("a cloud"));
    let [x, y, z] = cloud.points_m[0];
    assert!((x - 8.0).abs() < 1e-9 && (y - 1.0).abs() < 1e-9 && z == 3.0, "{x} {y} {z}");
}

/// `foxglove.LaserScan` of protobuf, laid out by hand: time 7 s 8 ns, a frame that is not UTF-8, -1 to 1 rad, two ranges.
#[rustfmt::skip]
const PROTOBUF_SCAN: &[u8] = &[
    0x0a, 4, 0x08, 7, 0x10, 8,                      // 1: timestamp {1: 7, 2: 8}
    0x12, 2, b'l', 0xff,                            // 2: frame_id
    0x21, 0, 0, 0, 0, 0, 0, 0xf0, 0xbf,             // 4: start_angle -1
    0x29, 0, 0, 0, 0, 0, 0, 0xf0, 0x3f,             // 5: end_angle 1
    0x32, 16,                                       // 6: ranges, packed
    0, 0, 0, 0, 0, 0, 0xf8, 0x3f,                   // 1.5
    0, 0, 0, 0, 0, 0, 0xf8, 0x7f,                   // NaN
];

#[test]
fn foxglove_scans_in_protobuf_are_read_and_cut_ones_never_panic() {
    let scan = scan_of(decode("foxglove.LaserScan", "protobuf", PROTOBUF_SCAN).expect("a scan"));
    assert_eq!((scan.header.stamp, scan.header.frame_id.as_str()), (Time { sec: 7, nanosec: 8 }, "l\u{fffd}"));
    assert_eq!((scan.angle_min, scan.angle_increment, scan.ranges[0]), (-1.0, 2.0, 1.5));
    assert!(scan.ranges[1].is_nan());
    for length in 0..PROTOBUF_SCAN.len() {
        let _ = decode("foxglove.LaserScan", "protobuf", &PROTOBUF_SCAN[..length]);
    }
    let mut hostile = PROTOBUF_SCAN.to_vec();
    hostile.splice(29..30, [0xff, 0xff, 0xff, 0xff, 0x7f]);
    assert!(decode("foxglove.LaserScan", "protobuf", &hostile).is_err());
}

#[test]
fn a_used_place_is_as_good_as_new_whatever_it_held() {
    let mut out = ScanMessage::Cloud(unpacked());
    let scan = ScanDecoder::for_schema("sensor_msgs/LaserScan", "", "cdr").expect("a scan");
    let bytes = LaserScan { ranges: vec![1.0], ..LaserScan::default() }.encode(Endian::Little);
    scan.decode_into(&bytes, &mut out).expect("a scan");
    assert_eq!(scan_of(out.clone()).ranges, [1.0]);
    let cloud = ScanDecoder::for_schema(PointCloud2::SCHEMA_NAME, "", "cdr").expect("a cloud");
    for _ in 0..2 {
        cloud.decode_into(&packed(false).encode(Endian::Little), &mut out).expect("a cloud");
        assert_eq!(out, ScanMessage::Cloud(unpacked()));
    }
}

proptest! {
    #[test]
    fn random_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..200), little: bool) {
        let message = [&[0, u8::from(little), 0, 0], &bytes[..]].concat();
        for schema in ["sensor_msgs/LaserScan", "sensor_msgs/MultiEchoLaserScan", "sensor_msgs/PointCloud2"] {
            let _ = decode(schema, "cdr", &message);
            let _ = decode(schema, "ros1", &bytes);
        }
        for schema in ["foxglove.LaserScan", "foxglove.PointCloud"] {
            let _ = decode(schema, "json", &bytes);
            let _ = decode(schema, "protobuf", &bytes);
        }
    }

    #[test]
    fn a_changed_byte_never_panics_nor_gives_more_points_than_bytes(at in 0usize..200, byte: u8) {
        let mut bytes = packed(false).encode(Endian::Little);
        let at = at % bytes.len();
        bytes[at] = byte;
        if let Ok(message) = decode(PointCloud2::SCHEMA_NAME, "cdr", &bytes) {
            prop_assert!(cloud_of(message).points_m.len() <= bytes.len());
        }
    }

    #[test]
    fn echoes_survive_both_byte_orders(beams in prop::collection::vec(prop::collection::vec(0.0f32..9.0, 0..4), 0..9)) {
        let ranges: Vec<_> = beams.into_iter().map(|echoes| LaserEcho { echoes }).collect();
        let scan = MultiEchoLaserScan { ranges, ..echoes() };
        for endian in [Endian::Little, Endian::Big] {
            prop_assert_eq!(MultiEchoLaserScan::decode(&scan.encode(endian)), Ok(scan.clone()));
        }
    }
}
