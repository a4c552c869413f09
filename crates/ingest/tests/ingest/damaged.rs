//! Recordings that were cut off or altered: everything that is whole, and never a word too little about the rest.

use std::path::Path;

use crosscut_ingest::{Damage, LossKind, ReadOptions, Recording, describe};
use mcap::Compression;
use mcap::records::op;
use proptest::prelude::{ProptestConfig, any, prop, prop_assert, proptest};

use crate::flight::{Folder, Form, Read, drain, expected, message_ends, open, plain_flight, record_at, scan, sensor};

const SCANS: u64 = 23;

/// All that can be read, and the losses; nothing if it is refused.
fn read(path: &Path) -> Option<(Read, Recording)> {
    let mut recording = open(path).ok()?;
    Some((drain(&mut recording), recording))
}

/// Where each record outside of chunks begins, with its opcode.
fn records_in(bytes: &[u8]) -> Vec<(usize, u8)> {
    let mut at = mcap::MAGIC.len();
    let mut records = Vec::new();
    while at + 9 < bytes.len() {
        records.push((at, bytes[at]));
        at += 9 + u64::from_le_bytes(bytes[at + 1..at + 9].try_into().expect("8 bytes")) as usize;
    }
    records
}

fn positions_of(bytes: &[u8], opcode: u8) -> Vec<usize> {
    records_in(bytes).into_iter().filter(|(_, found)| *found == opcode).map(|(at, _)| at).collect()
}

#[test]
fn a_cut_anywhere_gives_every_whole_scan_before_it_and_says_so() {
    let folder = Folder::new();
    for form in Form::all() {
        let whole = form.write(&plain_flight(SCANS));
        let end_of_data = positions_of(&whole, op::DATA_END)[0];
        // Compressed blocks of this size are decoded as a whole; all else gives scan after scan.
        let ends =
            if form.compression.is_none() { message_ends(&whole, &plain_flight(SCANS)) } else { vec![end_of_data] };
        let mut before = 0;
        for cut in mcap::MAGIC.len()..whole.len() {
            let Some((read, mut recording)) = read(&folder.add("cut.mcap", &whole[..cut])) else {
                assert!(cut < ends[0], "{form:?} cut at {cut}: refused");
                continue;
            };
            let count = read.len() as u64;
            assert_eq!(read, expected(count), "{form:?} cut at {cut}");
            assert!(count >= before, "{form:?} cut at {cut}: fewer scans than in a shorter file");
            let complete = ends.iter().filter(|end| **end <= cut).count() as u64;
            assert!(count >= complete, "{form:?} cut at {cut}: {count} of {complete}");
            assert_eq!(recording.total_revolutions(), Some(count));
            assert!(!recording.losses().is_empty(), "{form:?} cut at {cut}: nothing is said");
            if cut >= end_of_data + 13 {
                assert_eq!(count, SCANS, "{form:?} cut at {cut}: all scans are before the cut");
                assert!(matches!(recording.losses()[0].kind, LossKind::Index { damage: Damage::Ended }));
            } else {
                assert!(matches!(recording.losses()[0].kind, LossKind::CutOff { at_byte } if at_byte <= cut as u64));
            }
            before = count;
        }
    }
}

#[test]
fn a_cut_inside_a_compressed_chunk_gives_the_scans_of_the_blocks_before_it() {
    let mut records = plain_flight(4000);
    for (i, record) in records.iter_mut().enumerate() {
        record.log_time_ns += (i as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) % 1000; // hard to compress
    }
    for compression in [Compression::Zstd, Compression::Lz4] {
        let one_chunk = mcap::WriteOptions::new().compression(Some(compression)).chunk_size(None);
        let mut writer = one_chunk.create(std::io::Cursor::new(Vec::new())).expect("in memory");
        let schema = writer.add_schema("sensor_msgs/msg/LaserScan", "ros2msg", b"").expect("a schema");
        let channel = writer.add_channel(schema, "/scan", "cdr", &Default::default()).expect("a channel");
        for record in &records {
            let (log_time, publish_time) = (record.log_time_ns, record.log_time_ns);
            let header = mcap::records::MessageHeader { channel_id: channel, sequence: 0, log_time, publish_time };
            writer.write_to_known_channel(&header, &record.data).expect("in memory");
        }
        writer.finish().expect("in memory");
        let bytes = writer.into_inner().into_inner();
        let chunk = positions_of(&bytes, op::CHUNK)[0];
        let length = positions_of(&bytes, op::MESSAGE_INDEX)[0] - chunk;
        let folder = Folder::new();
        let path = folder.add("cut.mcap", &bytes[..chunk + length * 3 / 4]);
        let (read, recording) = read(&path).expect("a part of the chunk");
        assert!((1000..4000).contains(&read.len()), "{compression:?}: {} scans", read.len());
        assert_eq!(read.ranges, expected(read.len() as u64).ranges);
        let [loss] = recording.losses() else { panic!("{:?}", recording.losses()) };
        assert_eq!(loss.kind, LossKind::CutOff { at_byte: chunk as u64 });
    }
}

#[test]
fn a_corrupt_chunk_in_the_middle_loses_that_chunk_alone() {
    let folder = Folder::new();
    for form in Form::all().into_iter().filter(|form| form.chunked) {
        let mut bytes = form.write(&plain_flight(SCANS));
        let chunks = positions_of(&bytes, op::CHUNK);
        let middle = (chunks[1] + chunks[2]) / 2 - 40;
        bytes[middle] ^= 0x10;
        let (read, recording) = read(&folder.add("f.mcap", &bytes)).expect("the rest");
        let [loss] = recording.losses() else { panic!("{form:?}: {:?}", recording.losses()) };
        let LossKind::Part { at_byte, scans, .. } = loss.kind else { panic!("{loss}") };
        assert_eq!((at_byte, scans), (chunks[1] as u64, form.is_indexed().then_some(5)), "{form:?}");
        let kept: Vec<u64> = (0..5).chain(10..SCANS).collect();
        assert_eq!(read.stamps_ns, kept.iter().map(|&i| crate::flight::time_ns(i)).collect::<Vec<_>>(), "{form:?}");
        if form.is_indexed() {
            assert_eq!(read.seqs, kept, "scans that are known to be lost keep their numbers");
        }
    }
}

#[test]
fn a_damaged_index_is_a_loss_and_costs_no_scan() {
    let folder = Folder::new();
    for form in Form::all().into_iter().filter(|form| form.is_indexed()) {
        let whole = form.write(&plain_flight(SCANS));
        let index = positions_of(&whole, op::CHUNK_INDEX)[1];
        for offset in [0, 3, 9, 20, 28] {
            let mut bytes = whole.clone();
            bytes[index + offset] ^= 0x04;
            let (read, recording) = read(&folder.add("f.mcap", &bytes)).expect("all scans");
            assert_eq!(read, expected(SCANS), "{form:?} at {offset}");
            assert!(matches!(recording.losses(), [loss] if matches!(loss.kind, LossKind::Index { .. })));
        }
    }
}

#[test]
fn scans_that_are_counted_but_not_there_are_a_loss() {
    let mut bytes = Form::CHUNKED.write(&plain_flight(SCANS));
    let footer = positions_of(&bytes, op::FOOTER)[0];
    bytes[footer + 9 + 16..footer + 9 + 20].fill(0); // a summary without a checksum
    let statistics = positions_of(&bytes, op::STATISTICS)[0];
    let count_at = statistics + 9 + 8 + 2 + 4 * 4 + 2 * 8 + 4 + 2; // the count of the only channel, in the map at the end
    assert_eq!(bytes[count_at], SCANS as u8);
    bytes[count_at] += 2;
    let folder = Folder::new();
    let (read, recording) = read(&folder.add("f.mcap", &bytes)).expect("a recording");
    assert_eq!(read, expected(SCANS));
    let [loss] = recording.losses() else { panic!("{:?}", recording.losses()) };
    assert_eq!(loss.kind, LossKind::Missing { topic: "/scan".to_owned(), count: 2 });
}

#[test]
fn a_tail_of_zeros_as_a_power_cut_leaves_it_is_a_loss_and_nothing_else() {
    let whole = Form { chunked: false, ..Form::CHUNKED }.write(&plain_flight(SCANS));
    let messages = positions_of(&whole, op::MESSAGE);
    let bytes = [&whole[..messages[9]], &[0; 5000]].concat();
    let folder = Folder::new();
    let (read, recording) = read(&folder.add("f.mcap", &bytes)).expect("a recording");
    assert_eq!(read, expected(9));
    let [loss] = recording.losses() else { panic!("{:?}", recording.losses()) };
    assert!(matches!(loss.kind, LossKind::Rest { at_byte, .. } if at_byte == messages[9] as u64), "{loss}");
}

#[test]
fn messages_whose_topic_is_lost_with_its_definition_are_counted() {
    let form = Form { chunked: false, summary: false, ..Form::CHUNKED };
    let mut records = plain_flight(4);
    records.push(record_at("/rear", crate::flight::time_ns(9), &scan(0)));
    let mut bytes = form.write(&records);
    let rear = positions_of(&bytes, op::CHANNEL)[1];
    bytes[rear] = 0x7f; // a type that is not defined, so it is passed over
    let folder = Folder::new();
    let (read, recording) = read(&folder.add("f.mcap", &bytes)).expect("a recording");
    assert_eq!(read, expected(4));
    assert!(recording.losses().iter().any(|loss| loss.kind == LossKind::UnknownTopic { count: 1 }));
}

#[test]
fn any_single_altered_byte_is_noticed_if_it_changes_a_revolution() {
    let folder = Folder::new();
    for form in Form::all() {
        let whole = form.write(&plain_flight(11));
        let all = expected(11);
        for at in (0..whole.len()).step_by(2) {
            let mut bytes = whole.clone();
            bytes[at] ^= 1 << (at % 8);
            let path = folder.add("f.mcap", &bytes);
            let _ = describe(&path, &sensor(&[]), &ReadOptions::default());
            let Some((read, recording)) = read(&path) else { continue };
            if read.stamps_ns != all.stamps_ns || read.ranges != all.ranges {
                assert!(!recording.losses().is_empty(), "{form:?} byte {at}: {read:?}");
            }
            if form.chunked {
                for (stamp_ns, ranges) in read.stamps_ns.iter().zip(&read.ranges) {
                    let i = all.stamps_ns.iter().position(|known| known == stamp_ns);
                    assert_eq!(i.map(|i| &all.ranges[i]), Some(ranges), "{form:?} byte {at}: altered scan delivered");
                }
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn many_altered_bytes_and_a_cut_never_panic_nor_hang(
        form in 0usize..8, edits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..12),
        cut in any::<prop::sample::Index>(),
    ) {
        let mut bytes = Form::all()[form].write(&plain_flight(12));
        for (at, value) in &edits {
            let at = at.index(bytes.len() - 8) + 8;
            bytes[at] = *value;
        }
        if cut.index(3) == 0 {
            bytes.truncate(cut.index(bytes.len()));
        }
        let folder = Folder::new();
        let path = folder.add("f.mcap", &bytes);
        let _ = describe(&path, &sensor(&[]), &ReadOptions::default());
        if let Some((read, _)) = read(&path) {
            prop_assert!(read.len() <= 24);
        }
    }

    #[test]
    fn random_records_never_panic_nor_hang(
        records in prop::collection::vec((0u8..17, prop::collection::vec(any::<u8>(), 0..120), any::<Option<u64>>()), 0..12),
    ) {
        let mut bytes = mcap::MAGIC.to_vec();
        for (opcode, body, lie) in &records {
            bytes.push(*opcode);
            bytes.extend(lie.unwrap_or(body.len() as u64).to_le_bytes());
            bytes.extend(body);
        }
        bytes.extend(mcap::MAGIC);
        let folder = Folder::new();
        let path = folder.add("f.mcap", &bytes);
        let _ = read(&path);
        let _ = describe(&path, &sensor(&[]), &ReadOptions::default());
    }
}
