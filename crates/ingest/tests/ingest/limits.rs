//! Files that exceed a limit: what is too large is lost, and takes no memory.

use crosscut_ingest::{Damage, LossKind, ReadOptions, Recording, describe};

use crate::bags::{Built, ros1_bag};
use crate::flight::{
    Folder, Form, Record, drain, expected, open, plain_flight, record_at, ros1_record_at, scan, time_ns,
};

const FOUR_GIB: u64 = 1 << 32;

fn place_of(bytes: &[u8], what: &[u8]) -> usize {
    bytes.windows(what.len()).position(|found| found == what).expect("it is in the file")
}

fn is_too_large(recording: &Recording) -> bool {
    recording.losses().iter().any(|loss| match &loss.kind {
        LossKind::Part { damage, .. }
        | LossKind::Rest { damage, .. }
        | LossKind::Index { damage }
        | LossKind::Compressed { damage, .. } => matches!(damage, Damage::TooLarge { .. }),
        _ => false,
    })
}

fn ros1_flight(count: u64) -> Vec<Record> {
    (0..count).map(|i| ros1_record_at("/scan", time_ns(i), &scan(i))).collect()
}

#[test]
fn a_chunk_of_an_mcap_that_claims_too_much_is_lost_alone() {
    let folder = Folder::new();
    let mut bytes = Form::CHUNKED.write(&plain_flight(15));
    // The first chunk: opcode, length, two times, size.
    let header_at = mcap::MAGIC.len();
    let header_bytes = u64::from_le_bytes(bytes[header_at + 1..header_at + 9].try_into().expect("8 bytes")) as usize;
    let chunk_at = header_at + 9 + header_bytes;
    assert_eq!(bytes[chunk_at], mcap::records::op::CHUNK);
    bytes[chunk_at + 25..chunk_at + 33].copy_from_slice(&(5 * (FOUR_GIB / 4)).to_le_bytes());
    let mut recording = open(&folder.add("flight.mcap", &bytes)).expect("a recording");
    assert_eq!(drain(&mut recording).seqs, (5..15).collect::<Vec<_>>());
    assert!(is_too_large(&recording), "{:?}", recording.losses());
}

#[test]
fn a_message_that_claims_too_much_costs_no_memory() {
    let folder = Folder::new();
    let form = Form { chunked: false, summary: false, ..Form::CHUNKED };
    let mut bytes = form.write(&plain_flight(10));
    let first_range = |i| scan(i).ranges[0].to_le_bytes();
    // Before the first range are the other fields of the scan, the header of the message and that of its record.
    let opcode = place_of(&bytes, &first_range(7)) - 56 - 22 - 9;
    assert_eq!(bytes[opcode], mcap::records::op::MESSAGE);
    bytes[opcode + 1..opcode + 9].copy_from_slice(&FOUR_GIB.to_le_bytes());
    let mut recording = open(&folder.add("flight.mcap", &bytes)).expect("a recording");
    assert_eq!(drain(&mut recording), expected(7));
    assert!(!recording.losses().is_empty());

    let Built { bytes: mut bag, ends } = ros1_bag(&ros1_flight(10), "none", true);
    let data_bytes = ros1_flight(1)[0].data.len();
    let length_at = ends[7] - data_bytes - 4;
    bag[length_at..length_at + 4].copy_from_slice(&u32::MAX.to_le_bytes());
    let mut recording = open(&folder.add("flight.bag", &bag)).expect("a recording");
    assert_eq!(drain(&mut recording).seqs, [0, 1, 2, 3, 4]);
    assert!(is_too_large(&recording), "{:?}", recording.losses());
}

#[test]
fn a_bag_of_too_many_channels_is_read_without_its_index() {
    let folder = Folder::new();
    let mut bytes = ros1_bag(&ros1_flight(8), "lz4", true).bytes;
    let count_at = place_of(&bytes, b"conn_count=") + b"conn_count=".len();
    bytes[count_at..count_at + 4].copy_from_slice(&65_537u32.to_le_bytes());
    let mut recording = open(&folder.add("flight.bag", &bytes)).expect("a recording");
    assert_eq!(drain(&mut recording), expected(8));
    assert!(matches!(recording.losses(), [loss] if matches!(loss.kind, LossKind::Index { .. })));
}

#[test]
fn a_scan_of_too_many_beams_is_an_empty_revolution() {
    let folder = Folder::new();
    let mut large = scan(1);
    large.ranges = vec![1.0; (1 << 20) + 1];
    let mut flight = plain_flight(3);
    flight[1] = record_at("/scan", time_ns(1), &large);
    let mut recording = open(&folder.add("flight.mcap", &Form::CHUNKED.write(&flight))).expect("a recording");
    let read = drain(&mut recording);
    assert_eq!(read.ranges.iter().map(Vec::len).collect::<Vec<_>>(), [8, 0, 8]);
    assert!(read.notes[1][0].contains("more than 1048576"), "{:?}", read.notes[1]);
}

/// The note of the second of three messages, which alone cannot be decoded.
fn note_of_the_second(type_name: &'static str, encoding: &'static str, good: &[u8], bad: Vec<u8>) -> String {
    let folder = Folder::new();
    let record = |i, data| Record { topic: "/scan", type_name, encoding, log_time_ns: time_ns(i), data };
    let flight = [record(0, good.to_vec()), record(1, bad), record(2, good.to_vec())];
    let mut recording = open(&folder.add("flight.mcap", &Form::CHUNKED.write(&flight))).expect("a recording");
    let read = drain(&mut recording);
    assert_eq!(read.seqs, [0, 1, 2]);
    read.notes[1][0].clone()
}

#[test]
fn a_list_that_is_too_long_is_refused_before_its_end() {
    // What is wrong at the end of each list would be noted if it were read that far.
    let json = |numbers: &str| format!("{{\"start_angle\":0,\"end_angle\":1,\"ranges\":[{numbers}").into_bytes();
    let (good, bad) = (json("1,2,3]}"), json(&"1,".repeat((1 << 20) + 1)));
    let note = note_of_the_second("foxglove.LaserScan", "json", &good, bad);
    assert!(note.contains("more than 1048576"), "{note}");
    let echoes = |beams: usize| {
        let geometry = [&[0u8, 1, 0, 0][..], &[0; 8], &1u32.to_le_bytes(), &[0; 4], &[0; 28]].concat();
        [geometry, (beams as u32).to_le_bytes().to_vec(), vec![0; 4 * beams], vec![0; 4]].concat()
    };
    let mut bad = echoes((1 << 20) + 1);
    let last = bad.len() - 8;
    bad[last..last + 4].fill(0xFF);
    let note = note_of_the_second("sensor_msgs/msg/MultiEchoLaserScan", "cdr", &echoes(3), bad);
    assert!(note.contains("1048577 are more than 1048576"), "{note}");
}

#[test]
fn a_message_that_decompresses_to_too_much_is_an_empty_revolution() {
    let folder = Folder::new();
    let mut flight = plain_flight(3);
    // 257 MiB of a text that the scan claims as the name of its frame.
    let text_bytes = 257u32 << 20;
    let mut bomb = zstd::stream::Encoder::new(Vec::new(), 1).expect("in memory");
    let start = [&[0, 1, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0][..], &text_bytes.to_le_bytes()].concat();
    let rest = std::io::repeat(0);
    let all = std::io::Read::take(std::io::Read::chain(&start[..], rest), u64::from(text_bytes) + 1000);
    std::io::copy(&mut { all }, &mut bomb).expect("in memory");
    flight[1].data = bomb.finish().expect("in memory");
    let mut recording = open(&folder.add("flight.mcap", &Form::CHUNKED.write(&flight))).expect("a recording");
    let read = drain(&mut recording);
    assert_eq!(read.seqs, [0, 1, 2]);
    assert!(read.notes[1][0].contains("claims"), "{:?}", read.notes[1]);
}

#[test]
fn a_line_without_end_is_cut_and_the_lines_behind_it_are_read() {
    let folder = Folder::new();
    let line = |second: u64| format!("FLASER 3 1 2 3 0 0 0 0 0 0 {second}.5 host 0\n");
    let text = [line(1), "9".repeat(16 << 20), line(2), line(3)].concat();
    let mut recording = open(&folder.add("log.clf", text.as_bytes())).expect("a log");
    assert_eq!(drain(&mut recording).len(), 3, "the second begins where the long line is cut");
}

#[test]
fn a_record_of_the_index_that_is_too_large_costs_the_index_alone() {
    let folder = Folder::new();
    let mut bytes = Form::CHUNKED.write(&plain_flight(10));
    // The footer: where the summary begins, where its offsets begin, its checksum; then the magic bytes.
    let footer_at = bytes.len() - mcap::MAGIC.len() - 20;
    let summary_at = u64::from_le_bytes(bytes[footer_at..footer_at + 8].try_into().expect("8 bytes")) as usize;
    bytes[footer_at + 16..footer_at + 20].fill(0);
    let record_bytes: u64 = (64 << 20) + 1;
    let head = [&[mcap::records::op::STATISTICS][..], &record_bytes.to_le_bytes()].concat();
    bytes.splice(summary_at..summary_at, head.into_iter().chain(std::iter::repeat_n(0, record_bytes as usize)));
    let mut recording = open(&folder.add("flight.mcap", &bytes)).expect("a recording");
    assert_eq!(drain(&mut recording), expected(10));
    assert!(is_too_large(&recording), "{:?}", recording.losses());
}

#[test]
fn a_file_that_decompresses_to_too_much_is_cut() {
    let folder = Folder::new();
    let flight = Form { summary: false, ..Form::CHUNKED }.write(&plain_flight(10));
    let mut bomb = zstd::stream::Encoder::new(Vec::new(), 1).expect("in memory");
    let zeros = std::io::Read::take(std::io::repeat(0), 200 << 20);
    std::io::copy(&mut std::io::Read::chain(&flight[..], zeros), &mut bomb).expect("in memory");
    let mut recording = open(&folder.add("flight.mcap.zstd", &bomb.finish().expect("in memory"))).expect("a recording");
    assert_eq!(drain(&mut recording), expected(10));
    assert!(is_too_large(&recording), "{:?}", recording.losses());
}

#[test]
fn a_compressed_file_in_a_compressed_file_is_refused() {
    let folder = Folder::new();
    let flight = Form::CHUNKED.write(&plain_flight(3));
    let compressed = |bytes: &[u8]| zstd::stream::encode_all(bytes, 1).expect("in memory");
    assert!(open(&folder.add("once.mcap.zst", &compressed(&flight))).is_ok());
    let refused = open(&folder.add("twice.mcap.zst", &compressed(&compressed(&flight)))).err().expect("refused");
    assert!(refused.to_string().contains("decompress it first"), "{refused}");
}

#[test]
fn messages_that_wait_beyond_their_memory_are_lost_and_counted() {
    let folder = Folder::new();
    for summary in [true, false] {
        let flight = Form { summary, ..Form::CHUNKED }.write(&plain_flight(10));
        let path = folder.add("flight.mcap", &flight);
        let one = plain_flight(1)[0].data.len() as u64;
        let options = ReadOptions { waiting_bytes: 2 * one + 1, ..ReadOptions::default() };
        let mut recording = Recording::open(&[path], &options, crate::flight::sensor(&[])).expect("a recording");
        // Of five messages in a chunk three begin within the limit.
        assert_eq!(drain(&mut recording).len(), 6, "index: {summary}");
        assert!(is_too_large(&recording), "{:?}", recording.losses());
    }
}

#[test]
fn of_more_topics_than_are_described_the_first_scans_are_not_looked_at() {
    let folder = Folder::new();
    let name = |i: u64| -> &'static str { Box::leak(format!("/scan_{i:03}").into_boxed_str()) };
    let flight: Vec<Record> = (0..257).map(|i| record_at(name(i), time_ns(i), &scan(i))).collect();
    let path = folder.add("flight.mcap", &Form::CHUNKED.write(&flight));
    let described = describe(&path, &crate::flight::sensor(&[]), &ReadOptions::default()).expect("a recording");
    let looked_at: Vec<bool> = described.topics.iter().map(|topic| topic.first_scan.is_some()).collect();
    assert_eq!(looked_at, [vec![true; 256], vec![false]].concat());
}
