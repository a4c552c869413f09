//! Scans in the encoding of ROS 1, from outside.

use crosscut_messages::{DecodeError, Header, LaserScan, Time};
use proptest::prelude::{any, prop, proptest};

/// A LaserScan laid out by hand after the rules of ROS 1.
#[rustfmt::skip]
const SCAN: &[u8] = &[
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

fn decode(message: &[u8]) -> Result<LaserScan, DecodeError> {
    let mut scan = LaserScan { ranges: vec![1.0; 9], ..LaserScan::default() };
    scan.decode_ros1_into(message).map(|()| scan)
}

#[test]
fn a_scan_laid_out_by_hand_is_read() {
    let expected = LaserScan {
        header: Header { stamp: Time { sec: 1_577_836_800, nanosec: 700_000_000 }, frame_id: "laser".to_owned() },
        angle_min: -2.0,
        angle_max: 2.0,
        angle_increment: 1.0,
        time_increment: 0.001,
        scan_time: 0.1,
        range_min: 0.02,
        range_max: 5.6,
        ranges: vec![1.5, f32::INFINITY, 2.5],
        intensities: vec![100.0],
    };
    assert_eq!(decode(SCAN), Ok(expected));
}

#[test]
fn a_scan_cut_at_any_byte_is_an_error_and_no_panic() {
    for length in 0..SCAN.len() {
        assert!(decode(&SCAN[..length]).is_err(), "{length} of {} bytes were accepted", SCAN.len());
    }
}

#[test]
fn a_length_beyond_the_message_is_refused_with_both_numbers_and_nothing_is_allocated_for_it() {
    let mut bytes = SCAN.to_vec();
    let count_at = bytes.len() - 6 * 4;
    bytes[count_at..count_at + 4].copy_from_slice(&u32::MAX.to_le_bytes());
    let mut scan = LaserScan::default();
    let error = scan.decode_ros1_into(&bytes).expect_err("must be refused");
    assert_eq!(
        error,
        DecodeError::Length { field: "ranges", claimed: u32::MAX, needed_bytes: 4 * 0xffff_ffff, left_bytes: 20 }
    );
    assert_eq!(scan.ranges.capacity(), 0);
}

#[test]
fn text_that_is_not_utf8_is_refused_with_the_field() {
    let mut bytes = SCAN.to_vec();
    bytes[16] = 0xff;
    assert!(matches!(decode(&bytes), Err(DecodeError::Value { field: "header.frame_id", .. })));
}

proptest! {
    #[test]
    fn random_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        let _ = decode(&bytes);
    }
}
