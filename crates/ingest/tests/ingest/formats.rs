//! One flight in every format: the same revolutions, and everything that is whole before a cut.

use std::io::Write as _;

use crosscut_ingest::{CSV_PARAMS, CsvGeometry, Found, IngestError, LossKind, ReadOptions, Recording};
use crosscut_messages::LaserScan;
use crosscut_stage::{Params, Value};

use crate::bags::{BAG_COMPRESSIONS, Built, ros1_bag, rosbag2};
use crate::flight::{
    Folder, Form, Read, Record, drain, expected, message_ends, open, plain_flight, record_at, ros1_record_at, scan,
    sensor, time_ns,
};

const SCANS: u64 = 13;

fn ros1_flight(count: u64) -> Vec<Record> {
    (0..count).map(|i| ros1_record_at("/scan", time_ns(i), &scan(i))).collect()
}

/// Rows so long that each continues on other pages: bytes behind the last field of a message are ignored.
fn long_rows(count: u64) -> Vec<Record> {
    let mut records = plain_flight(count);
    records.iter_mut().for_each(|record| record.data.resize(1500, 0));
    records
}

fn seconds(ns: u64) -> String {
    format!("{}.{:09}", ns / 1_000_000_000, ns % 1_000_000_000)
}

fn joined(ranges: &[f32], separator: &str) -> String {
    ranges.iter().map(f32::to_string).collect::<Vec<_>>().join(separator)
}

/// A CARMEN log of the flight.
fn carmen(count: u64) -> Built {
    let (mut text, mut ends) = ("# a log\nPARAM robot_use_laser on nohost 0\n".to_owned(), Vec::new());
    for i in 0..count {
        let LaserScan { ranges, .. } = scan(i);
        let time = seconds(time_ns(i));
        text += &format!("ODOM {i} 0 0 1 0 0 {time} nohost 0\n");
        text +=
            &format!("ROBOTLASER1 0 0 0.7 0.1 30 0.01 0 8 {} 0 0 0 0 0 0 0 0 0 0 0 0 {time} ", joined(&ranges, " "));
        ends.push(text.len() + 1); // the first letter of the next word shows that the time is whole
        text += "nohost 0\n";
    }
    Built { bytes: text.into_bytes(), ends }
}

/// A table of the flight.
fn table(count: u64) -> Built {
    let (mut text, mut ends) = ("\u{feff}stamp_ns,r0,r1,r2,r3,r4,r5,r6,r7\r\n".to_owned(), Vec::new());
    for i in 0..count {
        text += &format!("{},{}\r\n", time_ns(i), joined(&scan(i).ranges, ","));
        ends.push(text.len());
    }
    Built { bytes: text.into_bytes(), ends }
}

fn csv() -> ReadOptions {
    let mut params = Params::defaults(CSV_PARAMS);
    for (name, value) in [("last_rad", 0.7), ("range_max_m", 30.0)] {
        params.set(name, Value::Float(value)).expect("allowed");
    }
    ReadOptions { csv: CsvGeometry::new(&params), ..ReadOptions::default() }
}

fn opened(path: &std::path::Path) -> Result<Recording, IngestError> {
    Recording::open(&[path.to_owned()], &csv(), sensor(&[]))
}

/// The flight in every format that is not MCAP, with a name.
fn all(count: u64) -> Vec<(String, Built)> {
    let mut files = Vec::new();
    for compression in BAG_COMPRESSIONS {
        for indexed in [true, false] {
            files.push((
                format!("{compression}, index {indexed}.bag"),
                ros1_bag(&ros1_flight(count), compression, indexed),
            ));
        }
    }
    files.push(("short rows.db3".to_owned(), rosbag2(&plain_flight(count))));
    files.push(("long rows.db3".to_owned(), rosbag2(&long_rows(count))));
    files.push(("log.clf".to_owned(), carmen(count)));
    files.push(("table.csv".to_owned(), table(count)));
    files
}

#[test]
fn every_format_gives_the_same_revolutions() {
    let folder = Folder::new();
    for (name, Built { bytes, .. }) in all(SCANS) {
        let mut recording = opened(&folder.add("flight", &bytes)).expect("a recording");
        assert_eq!(drain(&mut recording), expected(SCANS), "{name}");
        let is_unclosed = name.ends_with("false.bag");
        assert_eq!(recording.losses().is_empty(), !is_unclosed, "{name}: {:?}", recording.losses());
        assert_eq!(recording.reordered(), 0, "{name}");
    }
}

#[test]
fn a_cut_at_any_byte_costs_no_revolution_that_was_whole() {
    let folder = Folder::new();
    for (name, Built { bytes, ends }) in all(8) {
        for cut in 0..bytes.len() {
            let path = folder.add("cut", &bytes[..cut]);
            let whole = ends.iter().filter(|end| **end <= cut).count();
            let Ok(mut recording) = opened(&path) else {
                assert_eq!(whole, 0, "{name} cut at {cut}: refused");
                continue;
            };
            let read = drain(&mut recording);
            let count = read.len();
            assert!(count >= whole, "{name} cut at {cut}: {count} of {whole}");
            let is_last_line_cut = recording.losses().iter().any(|loss| matches!(loss.kind, LossKind::LastLine { .. }));
            if name.ends_with("db3") {
                // Rows fill a page from its end, so of a page that was cut the last ones are there.
                let all = expected(8);
                let is_true =
                    |(stamp_ns, ranges)| all.stamps_ns.iter().zip(&all.ranges).any(|known| known == (stamp_ns, ranges));
                assert!(read.stamps_ns.iter().zip(&read.ranges).all(is_true), "{name} cut at {cut}");
            } else if !is_last_line_cut {
                assert_eq!(read, expected(count as u64), "{name} cut at {cut}");
            }
            let is_text = name.ends_with("csv") || name.ends_with("clf");
            assert!(is_text || !recording.losses().is_empty(), "{name} cut at {cut}: nothing is reported");
        }
    }
}

#[test]
fn a_compressed_file_cut_at_any_byte_gives_what_can_be_decompressed() {
    let folder = Folder::new();
    let form = Form { chunked: false, summary: false, ..Form::CHUNKED };
    let Built { bytes: bag, ends } = ros1_bag(&ros1_flight(8), "none", false);
    let mcap = form.write(&plain_flight(8));
    let mcap_ends = message_ends(&mcap, &plain_flight(8));
    let files = [("mcap", mcap, mcap_ends), ("bag", bag, ends)];
    for (name, plain, ends) in files {
        // A block for every 100 bytes, each with other bytes than the one before.
        let mut encoder = zstd::stream::write::Encoder::new(Vec::new(), 1).expect("in memory");
        let mut after = Vec::new();
        for block in plain.chunks(100) {
            encoder.write_all(block).expect("in memory");
            encoder.flush().expect("in memory");
            after.push(encoder.get_ref().len());
        }
        let packed = encoder.finish().expect("in memory");
        for cut in 0..packed.len() {
            let there = after.iter().filter(|end| **end <= cut).count() * 100;
            let whole = ends.iter().filter(|end| **end <= there).count();
            let Ok(mut recording) = opened(&folder.add("cut", &packed[..cut])) else {
                assert_eq!(whole, 0, "{name} cut at {cut}: refused");
                continue;
            };
            let read = drain(&mut recording);
            assert!(read.len() >= whole, "{name} cut at {cut}: {} of {whole}", read.len());
            assert_eq!(read, expected(read.len() as u64), "{name} cut at {cut}");
            assert!(!recording.losses().is_empty(), "{name} cut at {cut}: nothing is reported");
        }
    }
}

#[test]
fn altered_bytes_never_panic_nor_hang() {
    let folder = Folder::new();
    for (name, Built { bytes, .. }) in all(7) {
        for at in (0..bytes.len()).step_by(if name.ends_with("bag") { 23 } else { 5 }) {
            for value in [bytes[at] ^ 1, bytes[at] ^ 0x80, 0xff] {
                let mut altered = bytes.clone();
                altered[at] = value;
                if let Ok(mut recording) = opened(&folder.add("altered", &altered)) {
                    assert!(drain(&mut recording).len() <= 21, "{name} byte {at}");
                }
            }
        }
    }
}

#[test]
fn messages_out_of_order_come_by_log_time_from_an_index() {
    let log_times = [0, 1, 2, 2, 9, 4, 3, 2, 8, 5, 10];
    let order = |read: &Read| read.ranges.iter().map(|ranges| f32::from_bits(ranges[0])).collect::<Vec<_>>();
    let by_time: Vec<f32> = [0, 1, 2, 3, 7, 6, 5, 9, 8, 4, 10].iter().map(|i| scan(*i).ranges[0]).collect();
    let folder = Folder::new();
    let ros1: Vec<_> = log_times.iter().zip(0..).map(|(t, i)| ros1_record_at("/scan", time_ns(*t), &scan(i))).collect();
    let ros2: Vec<_> = log_times.iter().zip(0..).map(|(t, i)| record_at("/scan", time_ns(*t), &scan(i))).collect();
    for Built { bytes, .. } in [ros1_bag(&ros1, "lz4", true), rosbag2(&ros2)] {
        let mut recording = open(&folder.add("flight", &bytes)).expect("a recording");
        assert_eq!((order(&drain(&mut recording)), recording.reordered()), (by_time.clone(), 0));
    }
    let mut unindexed = open(&folder.add("flight", &ros1_bag(&ros1, "lz4", false).bytes)).expect("a recording");
    assert_eq!((order(&drain(&mut unindexed)).len(), unindexed.reordered()), (11, 4));
}

#[test]
fn other_topics_are_passed_over_in_every_format() {
    let mixed = |scans: Vec<Record>, type_name: &'static str, encoding: &'static str| {
        let other = |log_time_ns| Record { topic: "/camera", type_name, encoding, log_time_ns, data: vec![0xee; 700] };
        scans.into_iter().flat_map(|scan| [other(scan.log_time_ns), scan]).collect::<Vec<_>>()
    };
    let folder = Folder::new();
    let bags = [
        ros1_bag(&mixed(ros1_flight(SCANS), "sensor_msgs/Image", "ros1"), "bz2", true),
        ros1_bag(&mixed(ros1_flight(SCANS), "sensor_msgs/Image", "ros1"), "none", false),
        rosbag2(&mixed(plain_flight(SCANS), "sensor_msgs/msg/Image", "cdr")),
    ];
    for Built { bytes, .. } in bags {
        let mut recording = open(&folder.add("flight", &bytes)).expect("a recording");
        assert_eq!(drain(&mut recording), expected(SCANS));
    }
}

#[test]
fn a_damaged_chunk_of_a_bag_is_lost_alone() {
    let folder = Folder::new();
    let Built { mut bytes, ends } = ros1_bag(&ros1_flight(SCANS), "bz2", true);
    bytes[ends[7] - 60] ^= 0x55;
    let mut recording = open(&folder.add("flight.bag", &bytes)).expect("a recording");
    assert_eq!(drain(&mut recording).seqs, [0, 1, 2, 3, 4, 10, 11, 12], "seq keeps their numbers");
    let [loss] = recording.losses() else { panic!("{:?}", recording.losses()) };
    assert!(matches!(loss.kind, LossKind::Part { scans: Some(5), .. }), "{loss}");
}

#[test]
fn a_damaged_index_of_a_bag_costs_no_scan() {
    let folder = Folder::new();
    let Built { mut bytes, ends } = ros1_bag(&ros1_flight(SCANS), "lz4", true);
    let at = ends[12] + 70; // in the first connection of the index
    bytes.truncate(bytes.len() - 10);
    bytes[at] ^= 0x40;
    let mut recording = open(&folder.add("flight.bag", &bytes)).expect("a recording");
    assert_eq!(drain(&mut recording), expected(SCANS));
    assert!(matches!(recording.losses(), [loss] if matches!(loss.kind, LossKind::Index { .. })));
}

#[test]
fn compressed_files_are_read_through_a_temporary_copy() {
    let folder = Folder::new();
    let mcap = Form::CHUNKED.write(&plain_flight(SCANS));
    let bag = rosbag2(&plain_flight(SCANS)).bytes;
    let zstd = |bytes: &[u8]| zstd::encode_all(bytes, 3).expect("in memory");
    for (name, bytes) in [("f.mcap.zstd", zstd(&mcap)), ("f.db3.zstd", zstd(&bag))] {
        let mut recording = open(&folder.add(name, &bytes)).expect("a recording");
        assert_eq!((drain(&mut recording), recording.losses()), (expected(SCANS), &[][..]), "{name}");
        let mut cut = open(&folder.add(name, &bytes[..bytes.len() / 2])).ok();
        assert!(cut.as_mut().is_none_or(|cut| !drain(cut).seqs.is_empty() && !cut.losses().is_empty()), "{name}");
    }
    let nested = zstd(&zstd(&mcap));
    assert!(matches!(
        open(&folder.add("f", &nested)),
        Err(IngestError::NotRecording { found: Found::CompressedTwice, .. })
    ));
}

#[test]
fn messages_that_are_compressed_one_by_one_are_read() {
    let mut records = plain_flight(SCANS);
    records.iter_mut().for_each(|record| record.data = zstd::encode_all(&record.data[..], 1).expect("in memory"));
    let folder = Folder::new();
    for bytes in [Form::CHUNKED.write(&records), rosbag2(&records).bytes] {
        let mut recording = open(&folder.add("flight", &bytes)).expect("a recording");
        assert_eq!((drain(&mut recording), recording.losses()), (expected(SCANS), &[][..]));
    }
}

#[test]
fn folders_of_databases_and_unclosed_files_are_flights() {
    let flight = plain_flight(10);
    let folder = Folder::new();
    folder.add("bag_0.db3.zstd", &zstd::encode_all(&rosbag2(&flight[..4]).bytes[..], 3).expect("in memory"));
    folder.add("bag_1.db3", &rosbag2(&flight[4..]).bytes);
    let whole = |folder: &Folder| drain(&mut open(folder.path()).expect("a flight"));
    assert_eq!(whole(&folder), expected(10));
    let active = Folder::new();
    active.add("a_0.mcap.active", &Form::CHUNKED.write(&flight[..6]));
    active.add("a_1.mcap.active", &Form::CHUNKED.write(&flight[6..]));
    assert_eq!(whole(&active), expected(10));
}

#[test]
fn a_table_without_directions_is_refused_with_the_settings_that_it_needs() {
    let folder = Folder::new();
    let error = open(&folder.add("rows.csv", &table(3).bytes)).err().expect("refused").to_string();
    assert!(error.contains("--set csv.first_rad=") && error.contains("--set csv.last_rad="), "{error}");
}

#[test]
fn lines_that_cannot_be_read_are_one_loss_and_empty_revolutions() {
    let folder = Folder::new();
    let text = String::from_utf8(table(5).bytes).expect("a text").replacen(",2,", ",two,", 1);
    let mut recording = opened(&folder.add("rows.csv", text.as_bytes())).expect("a recording");
    let read = drain(&mut recording);
    assert_eq!(read.seqs, [0, 1, 2, 3, 4]);
    assert!(read.ranges[0].is_empty() && read.notes[0].iter().any(|note| note.contains("line 2: `two`")), "{read:?}");
    let [loss] = recording.losses() else { panic!("{:?}", recording.losses()) };
    assert!(matches!(&loss.kind, LossKind::Lines { first: 2, count: 1, .. }), "{loss}");
}
