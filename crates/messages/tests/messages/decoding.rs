//! Messages from outside: all in CDR, in both byte orders, and scans of ROS 1; whole and damaged.

use std::fmt::Debug;

use crosscut_messages::{
    DecodeError, Endian, Header, LaserScan, Message, Odometry, Pose, PoseWithCovariance, Quaternion, TfMessage, Time,
    Transform, TransformStamped, Twist, TwistWithCovariance, Vector3,
};
use proptest::prelude::{Just, Strategy, any, prop, prop_assert_eq, prop_assume, prop_oneof, proptest};

/// A LaserScan in big endian, laid out by hand after the CDR rules: 4-byte header; values aligned to their size.
#[rustfmt::skip]
const BIG_ENDIAN_SCAN: &[u8] = &[
    0x00, 0x00, 0x00, 0x00,                         // CDR, big endian
    0x5e, 0x0b, 0xe1, 0x00,                         // stamp.sec = 1577836800
    0x29, 0xb9, 0x27, 0x00,                         // stamp.nanosec = 700000000
    0x00, 0x00, 0x00, 0x06, b'l', b'a', b's', b'e', b'r', 0, // frame_id, with its length and final zero
    0x00, 0x00,                                     // to the next multiple of 4
    0xc0, 0x00, 0x00, 0x00,                         // angle_min = -2
    0x40, 0x00, 0x00, 0x00,                         // angle_max = 2
    0x3f, 0x80, 0x00, 0x00,                         // angle_increment = 1
    0x3a, 0x83, 0x12, 0x6f,                         // time_increment = 0.001
    0x3d, 0xcc, 0xcc, 0xcd,                         // scan_time = 0.1
    0x3c, 0xa3, 0xd7, 0x0a,                         // range_min = 0.02
    0x40, 0xb3, 0x33, 0x33,                         // range_max = 5.6
    0x00, 0x00, 0x00, 0x03,                         // three ranges
    0x3f, 0xc0, 0x00, 0x00,                         // 1.5
    0x7f, 0x80, 0x00, 0x00,                         // infinity
    0x40, 0x20, 0x00, 0x00,                         // 2.5
    0x00, 0x00, 0x00, 0x01,                         // one intensity
    0x42, 0xc8, 0x00, 0x00,                         // 100
];

/// A LaserScan laid out by hand after the rules of ROS 1.
#[rustfmt::skip]
const ROS1_SCAN: &[u8] = &[
    0x07, 0x00, 0x00, 0x00,                         // seq = 7
    0x00, 0xe1, 0x0b, 0x5e,                         // stamp.sec = 1577836800
    0x00, 0x27, 0xb9, 0x29,                         // stamp.nsec = 700000000
    0x05, 0x00, 0x00, 0x00, b'l', b'a', b's', b'e', b'r', // frame_id, with its length
    0x00, 0x00, 0x00, 0xc0,                         // angle_min = -2
    0x00, 0x00, 0x00, 0x40,                         // angle_max = 2
    0x00, 0x00, 0x80, 0x3f,                         // angle_increment = 1
    0x6f, 0x12, 0x83, 0x3a,                         // time_increment = 0.001
    0xcd, 0xcc, 0xcc, 0x3d,                         // scan_time = 0.1
    0x0a, 0xd7, 0xa3, 0x3c,                         // range_min = 0.02
    0x33, 0x33, 0xb3, 0x40,                         // range_max = 5.6
    0x03, 0x00, 0x00, 0x00,                         // three ranges
    0x00, 0x00, 0xc0, 0x3f,                         // 1.5
    0x00, 0x00, 0x80, 0x7f,                         // infinity
    0x00, 0x00, 0x20, 0x40,                         // 2.5
    0x01, 0x00, 0x00, 0x00,                         // one intensity
    0x00, 0x00, 0xc8, 0x42,                         // 100
];

/// The same scan both ways, and how it is read.
const HAND_MADE: [(&[u8], Decode); 2] =
    [(BIG_ENDIAN_SCAN, LaserScan::decode_into), (ROS1_SCAN, LaserScan::decode_ros1_into)];
type Decode = fn(&mut LaserScan, &[u8]) -> Result<(), DecodeError>;

fn hand_made_scan() -> LaserScan {
    LaserScan {
        header: header("laser", Time { sec: 1_577_836_800, nanosec: 700_000_000 }),
        angle_min: -2.0,
        angle_max: 2.0,
        angle_increment: 1.0,
        time_increment: 0.001,
        scan_time: 0.1,
        range_min: 0.02,
        range_max: 5.6,
        ranges: vec![1.5, f32::INFINITY, 2.5],
        intensities: vec![100.0],
    }
}

fn header(frame_id: &str, stamp: Time) -> Header {
    Header { stamp, frame_id: frame_id.to_owned() }
}

fn odometry(frame_id: &str, numbers: [f64; 6]) -> Odometry {
    let [x, y, z, a, b, c] = numbers;
    let (linear, angular) = (Vector3 { x, y, z }, Vector3 { x: a, y: b, z: c });
    let mut covariance = [[0.0; 6]; 6];
    covariance[1] = numbers;
    Odometry {
        header: header(frame_id, Time { sec: 7, nanosec: 8 }),
        child_frame_id: "base_link".to_owned(),
        pose: PoseWithCovariance { pose: Pose { position: linear, orientation: quaternion(a) }, covariance },
        twist: TwistWithCovariance { twist: Twist { linear, angular }, covariance },
    }
}

fn quaternion(yaw_rad: f64) -> Quaternion {
    Quaternion::from_yaw_rad(yaw_rad)
}

fn transforms(frame_ids: &[String], x: f64) -> TfMessage {
    let transform = Transform { translation: Vector3 { x, y: 2.0, z: 3.0 }, rotation: quaternion(0.25) };
    let stamped = |frame_id: &String| TransformStamped {
        header: header(frame_id, Time { sec: 1, nanosec: 2 }),
        child_frame_id: format!("{frame_id}_child"),
        transform,
    };
    TfMessage { transforms: frame_ids.iter().map(stamped).collect() }
}

#[test]
fn a_scan_laid_out_by_hand_is_read_whatever_its_place_held_before() {
    for (bytes, decode_into) in HAND_MADE {
        let mut scan = LaserScan { ranges: vec![1.0; 9], ..LaserScan::default() };
        assert_eq!(decode_into(&mut scan, bytes), Ok(()));
        assert_eq!(scan, hand_made_scan());
    }
}

#[test]
fn a_scan_is_written_byte_for_byte_as_laid_out_by_hand() {
    assert_eq!(hand_made_scan().encode(Endian::Big), BIG_ENDIAN_SCAN);
}

#[test]
fn f64_fields_are_aligned_to_8_bytes_from_the_end_of_the_header() {
    let bytes = transforms(&["a".to_owned()], 1.0).encode(Endian::Little);
    // count 4, stamp 8, "a" 4 + 2, to 4: 20, "a_child" 4 + 8: 32, so x starts at 32 after the 4-byte header.
    assert_eq!(bytes[4 + 32..4 + 40], 1.0f64.to_le_bytes());
}

#[test]
fn a_length_beyond_the_message_is_refused_with_both_numbers_and_nothing_is_allocated_for_it() {
    for (bytes, decode_into) in HAND_MADE {
        let mut bytes = bytes.to_vec();
        let count_at = bytes.len() - 6 * 4;
        bytes[count_at..count_at + 4].fill(0xff);
        let mut scan = LaserScan::default();
        let error = decode_into(&mut scan, &bytes).expect_err("must be refused");
        assert_eq!(
            error,
            DecodeError::Length { field: "ranges", claimed: u32::MAX, needed_bytes: 4 * 0xffff_ffff, left_bytes: 20 }
        );
        assert_eq!(scan.ranges.capacity(), 0);
    }
}

#[test]
fn encodings_other_than_plain_cdr_are_refused_by_name() {
    let refused = |id: u8| LaserScan::decode(&[0, id, 0, 0, 0, 0, 0, 0]).expect_err("must be refused").to_string();
    assert_eq!(refused(3), "the message is PL_CDR (header 0x0003); only plain CDR and plain XCDR2 can be read");
    for (ids, name) in [([0x09, 0x15], "delimited"), ([0x0b, 0x13], "PL_CDR2")] {
        for id in ids {
            assert!(refused(id).contains(name), "{}", refused(id));
        }
    }
    assert!(refused(0xff).contains("unknown encoding"));
}

#[test]
fn text_that_is_not_utf8_costs_a_replacement_character() {
    for (bytes, decode_into) in HAND_MADE {
        let mut bytes = bytes.to_vec();
        bytes[17] = 0xff;
        let mut scan = LaserScan::default();
        assert_eq!(decode_into(&mut scan, &bytes), Ok(()));
        assert!(scan.header.frame_id.contains('\u{fffd}'), "{}", scan.header.frame_id);
        assert_eq!(scan.ranges, hand_made_scan().ranges);
    }
}

#[test]
fn xcdr2_aligns_f64_to_4_bytes_and_prefixes_sequences_of_structures() {
    let transforms = transforms(&["a".to_owned()], 1.0);
    for (id, endian) in [(0x07, Endian::Little), (0x11, Endian::Little), (0x06, Endian::Big), (0x10, Endian::Big)] {
        let mut bytes = transforms.encode(endian);
        // The f64 of the transform begin at 32 after the header already: 4 bytes before the sequence move them to 36.
        bytes[1] = id;
        let size = (bytes.len() as u32 - 4).to_be_bytes();
        bytes.splice(4..4, size);
        assert_eq!(TfMessage::decode(&bytes), Ok(transforms.clone()), "{id:#x}");
        assert!(TfMessage::decode(&bytes[..bytes.len() - 1]).is_err());
    }
    let mut scan = BIG_ENDIAN_SCAN.to_vec();
    scan[1] = 0x10;
    assert_eq!(LaserScan::decode(&scan), Ok(hand_made_scan()));
}

#[test]
fn bytes_after_the_last_field_are_ignored() {
    for (bytes, decode_into) in HAND_MADE {
        let mut scan = LaserScan::default();
        assert_eq!(decode_into(&mut scan, &[bytes, &[0, 0, 0]].concat()), Ok(()));
        assert_eq!(scan, hand_made_scan());
    }
}

fn cut_anywhere_is_an_error<M: Message + Debug>(message: &M) {
    for endian in [Endian::Little, Endian::Big] {
        let bytes = message.encode(endian);
        for length in 0..bytes.len() {
            assert!(M::decode(&bytes[..length]).is_err(), "{length} of {} bytes were accepted", bytes.len());
        }
    }
}

#[test]
fn a_message_cut_at_any_byte_is_an_error_and_no_panic() {
    cut_anywhere_is_an_error(&hand_made_scan());
    cut_anywhere_is_an_error(&odometry("odom", [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]));
    cut_anywhere_is_an_error(&transforms(&["a".to_owned(), "bcd".to_owned()], 1.0));
    for length in 0..ROS1_SCAN.len() {
        let cut = &ROS1_SCAN[..length];
        assert!(
            LaserScan::default().decode_ros1_into(cut).is_err(),
            "{length} of {} bytes were accepted",
            ROS1_SCAN.len()
        );
    }
}

fn survives<M: Message + Debug + PartialEq>(message: &M, reused: &mut M) -> Result<(), DecodeError> {
    for endian in [Endian::Little, Endian::Big] {
        let bytes = message.encode(endian);
        reused.decode_into(&bytes)?;
        assert_eq!(reused, message);
        assert_eq!(&M::decode(&bytes)?, message);
    }
    Ok(())
}

/// Any range but NaN, which is not equal to itself.
fn ranges() -> impl Strategy<Value = Vec<f32>> {
    let range = prop_oneof![8 => 0.0f32..100.0, 1 => Just(f32::INFINITY), 1 => Just(f32::NEG_INFINITY)];
    prop::collection::vec(range, 0..40)
}

proptest! {
    #[test]
    fn scans_survive_both_byte_orders(
        frame_id in ".{0,9}", sec: i32, nanosec: u32, geometry in any::<[f32; 7]>(), ranges in ranges(),
        intensities in ranges(), before in ranges(),
    ) {
        prop_assume!(geometry.iter().all(|value| !value.is_nan()));
        let [angle_min, angle_max, angle_increment, time_increment, scan_time, range_min, range_max] = geometry;
        let scan = LaserScan {
            header: header(&frame_id, Time { sec, nanosec }),
            angle_min, angle_max, angle_increment, time_increment, scan_time, range_min, range_max, ranges, intensities,
        };
        let mut reused = LaserScan { ranges: before, ..LaserScan::default() };
        prop_assert_eq!(survives(&scan, &mut reused), Ok(()));
    }

    #[test]
    fn odometry_and_transforms_survive_both_byte_orders(
        frame_ids in prop::collection::vec("[a-z/_]{0,9}", 0..5), numbers in prop::array::uniform6(-1e9..1e9f64),
    ) {
        let frame_id = frame_ids.first().map_or("", String::as_str);
        prop_assert_eq!(survives(&odometry(frame_id, numbers), &mut Odometry::default()), Ok(()));
        prop_assert_eq!(survives(&transforms(&frame_ids, numbers[0]), &mut TfMessage::default()), Ok(()));
    }

    #[test]
    fn random_bytes_never_panic(endian in 0u8..2, bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        let message = [&[0, endian, 0, 0], &bytes[..]].concat();
        let _ = LaserScan::decode(&message);
        let _ = Odometry::decode(&message);
        let _ = TfMessage::decode(&message);
        let _ = LaserScan::default().decode_ros1_into(&bytes);
    }
}
