//! Messages that are parts of a turn, and beams that never return.

use std::f32::consts::{PI, TAU};

use crosscut_ingest::{ReadOptions, Recording};
use crosscut_messages::{Cloud, Endian, Header, LaserScan, Message as _, PointCloud2, Time};
use crosscut_stage::{Beam, Notes, Revolution, Source, Value};

use crate::flight::{Folder, Form, Read, Record, drain, open, record_at, sensor, time_ns};

const PARTS: usize = 6;
const PART_BEAMS: usize = 20;

/// Part `part` of turn `turn`; each range tells both.
fn part(turn: usize, part: usize, direction: f32, span_rad: f32) -> LaserScan {
    let step = span_rad / (PARTS * PART_BEAMS) as f32;
    let range = |beam: usize| 1.0 + turn as f32 / 64.0 + (part * PART_BEAMS + beam) as f32 / 1024.0;
    LaserScan {
        header: Header { stamp: Time::from_ns(part_ns(turn, part)), frame_id: "laser".to_owned() },
        angle_min: direction * (part * PART_BEAMS) as f32 * step - direction * 0.5 * span_rad,
        angle_increment: direction * step,
        range_max: 30.0,
        ranges: (0..PART_BEAMS).map(range).collect(),
        ..LaserScan::default()
    }
}

fn part_ns(turn: usize, part: usize) -> u64 {
    time_ns(turn as u64) + part as u64 * 10_000_000
}

pub(crate) fn parts(turns: usize, direction: f32, span_rad: f32) -> Vec<Record> {
    let all = (0..turns).flat_map(|turn| (0..PARTS).map(move |at| (turn, at)));
    all.map(|(turn, at)| record_at("/scan", part_ns(turn, at), &part(turn, at, direction, span_rad))).collect()
}

fn read(records: &[Record]) -> Read {
    let folder = Folder::new();
    drain(&mut open(&folder.add("f.mcap", &Form::CHUNKED.write(records))).expect("a recording"))
}

fn bits(ranges: impl Iterator<Item = f32>) -> Vec<u32> {
    ranges.map(f32::to_bits).collect()
}

fn whole(turn: usize) -> Vec<u32> {
    bits((0..PARTS).flat_map(|at| part(turn, at, 1.0, 4.8).ranges))
}

#[test]
fn parts_of_a_turn_become_one_revolution() {
    for (direction, span_rad) in [(1.0, 4.8), (-1.0, 4.8), (1.0, TAU), (-1.0, TAU)] {
        let read = read(&parts(30, direction, span_rad));
        assert_eq!(read.seqs, (0..30).collect::<Vec<_>>(), "{direction} {span_rad}");
        assert_eq!(read.stamps_ns, (0..30).map(|turn| part_ns(turn, 0)).collect::<Vec<_>>());
        assert!((0..30).all(|turn| read.ranges[turn] == whole(turn)), "{direction} {span_rad}");
        assert_eq!(read.notes[7], ["a revolution joined of 6 messages: seq counts revolutions"]);
    }
}

#[test]
fn a_missing_part_leaves_its_beams_unknown() {
    let mut records = parts(30, 1.0, 4.8);
    records.remove(10 * PARTS + 2);
    let folder = Folder::new();
    let mut recording = open(&folder.add("f.mcap", &Form::CHUNKED.write(&records))).expect("a recording");
    let mut revolution = Revolution::default();
    for turn in 0..30 {
        let mut notes = Notes::default();
        assert!(recording.next(&mut revolution, &mut notes).expect("readable"));
        assert_eq!(revolution.seq, turn);
        let beams = &revolution.sweep.as_ref().expect("beams").beams;
        let unknown: Vec<usize> = (0..beams.len()).filter(|&beam| beams[beam] == Beam::Unknown).collect();
        let expected = if turn == 10 { (40..60).collect() } else { Vec::new() };
        assert_eq!(unknown, expected, "{turn}");
        assert_eq!(notes.iter().any(|note| note.starts_with("20 beams of messages that are missing")), turn == 10);
    }
}

#[test]
fn a_part_that_cannot_be_decoded_is_a_loss_of_its_turn() {
    let mut records = parts(30, 1.0, 4.8);
    records[10 * PARTS + 2].data.truncate(30);
    let folder = Folder::new();
    let mut recording = open(&folder.add("f.mcap", &Form::CHUNKED.write(&records))).expect("a recording");
    let read = drain(&mut recording);
    assert_eq!(read.len(), 30);
    assert!(read.notes[10].iter().any(|note| note.starts_with("a message of this turn cannot be decoded")));
    let text = recording.losses()[0].to_string();
    assert!(text.starts_with("1 message of /scan cannot be decoded, the first is number 62"), "{text}");
}

#[test]
fn times_select_revolutions_of_parts() {
    let folder = Folder::new();
    folder.add("f.mcap", &Form::CHUNKED.write(&parts(30, 1.0, 4.8)));
    let options = ReadOptions {
        from_s: Some(0.45),
        to_s: Some(1.85),
        every: std::num::NonZero::new(5).expect("not 0"),
        ..ReadOptions::default()
    };
    let mut recording = Recording::open(&[folder.path().to_owned()], &options, sensor(&[])).expect("a flight");
    assert_eq!(drain(&mut recording).seqs, [5, 10, 15]);
}

/// A scan of 360 beams; `range_m` gives the range of each.
pub(crate) fn turn(number: u64, range_m: impl Fn(usize) -> f32) -> Record {
    let scan = LaserScan {
        header: Header { stamp: Time::from_ns(time_ns(number)), frame_id: "laser".to_owned() },
        angle_min: -PI,
        angle_increment: TAU / 360.0,
        range_max: 30.0,
        ranges: (0..360).map(range_m).collect(),
        ..LaserScan::default()
    };
    record_at("/scan", time_ns(number), &scan)
}

/// How many beams of each scan are unknown, and whether the setting that masks them is noted.
fn unknown(records: &[Record], find: bool) -> Vec<(usize, bool)> {
    let folder = Folder::new();
    let path = folder.add("f.mcap", &Form::CHUNKED.write(records));
    let sensor = sensor(&[("find_blind_sectors", Value::Boolean(find))]);
    let mut recording = Recording::open(&[path], &ReadOptions::default(), sensor).expect("a recording");
    let (mut revolution, mut out) = (Revolution::default(), Vec::new());
    loop {
        let mut notes = Notes::default();
        if !recording.next(&mut revolution, &mut notes).expect("readable") {
            return out;
        }
        let beams = &revolution.sweep.as_ref().expect("beams").beams;
        let count = beams.iter().filter(|beam| **beam == Beam::Unknown).count();
        out.push((count, notes.iter().any(|note| note.contains("ingest.masked_sectors_rad = [["))));
    }
}

#[test]
fn a_sector_that_is_always_0_is_unknown_and_named() {
    let room = |beam: usize| if (45..135).contains(&beam) { 0.0 } else { 3.0 };
    let records: Vec<_> = (0..20).map(|number| turn(number, room)).collect();
    assert_eq!(unknown(&records, true), [(90, true); 20]);
    assert_eq!(unknown(&records, false), [(0, false); 20]);
}

#[test]
fn a_dark_passage_seen_from_one_place_stays_in_view() {
    // Its walls are seen at a grazing angle; other beams get lost as well; or the driver says so in another way.
    let grazing =
        |beam: usize| if (50..130).contains(&beam) { 0.0 } else { 60.0 / (beam as f32 - 90.0).abs().powi(2) * 40.0 };
    let lossy = |beam: usize| if (45..135).contains(&beam) || beam == 200 { 0.0 } else { 3.0 };
    let infinite = |beam: usize| if (45..135).contains(&beam) { f32::INFINITY } else { 3.0 };
    let places: [&dyn Fn(usize) -> f32; 3] = [&grazing, &lossy, &infinite];
    for (place, range_m) in places.iter().enumerate() {
        let records: Vec<_> = (0..20).map(|number| turn(number, range_m)).collect();
        assert!(unknown(&records, true).iter().all(|&(unknown, is_noted)| unknown == 0 && !is_noted), "{place}");
    }
}

#[test]
fn a_post_is_told_from_a_dark_passage_by_the_motion() {
    let range_m = |number: u64, beam: usize| 3.0 + (number as f32 * 0.1) + beam as f32 / 360.0;
    let post = |number: u64| {
        turn(number, |beam| if (100..106).contains(&beam) { f32::INFINITY } else { range_m(number, beam) })
    };
    let passage = |number: u64| {
        let shift = number as usize / 2;
        turn(
            number,
            |beam| if (100 + shift..130 + shift).contains(&beam) { f32::INFINITY } else { range_m(number, beam) },
        )
    };
    assert_eq!(unknown(&(0..30).map(post).collect::<Vec<_>>(), true), [(6, true); 30]);
    assert_eq!(unknown(&(0..30).map(passage).collect::<Vec<_>>(), true), [(0, false); 30]);
}

#[test]
fn a_sector_that_returns_after_all_is_in_view_again() {
    let room = |beam: usize| if (45..135).contains(&beam) { 0.0 } else { 3.0 };
    let mut records: Vec<_> = (0..120).map(|number| turn(number, room)).collect();
    records[110] = turn(110, |_| 3.0);
    let unknown = unknown(&records, true);
    assert!(unknown[..110].iter().all(|&(count, _)| count == 90));
    assert!(unknown[110..].iter().all(|&(count, _)| count == 0));
}

/// Parts of turns of a motor that runs unevenly: each has its own increment and number of beams, and they go on where
/// the last one ends. The range of each beam is that of its bearing.
fn uneven(turns: f32, direction: f32, stated: impl Fn(usize, f32) -> f32) -> Vec<Record> {
    let (mut records, mut travel) = (Vec::new(), 0.0f32);
    while travel < turns * TAU {
        let at = records.len();
        let (beams, step) = (10 + at % 4, 0.014 * (1.0 + 0.01 * (at % 5) as f32));
        let range = |beam: usize| 2.0 + (travel + beam as f32 * step).rem_euclid(TAU);
        let ns = time_ns(0) + (f64::from(travel) * 1e8 / f64::from(TAU)) as u64;
        let scan = LaserScan {
            header: Header { stamp: Time::from_ns(ns), frame_id: "laser".to_owned() },
            angle_min: direction * ((travel + PI).rem_euclid(TAU) - PI),
            angle_increment: stated(at, direction * step),
            range_max: 30.0,
            ranges: (0..beams).map(range).collect(),
            ..LaserScan::default()
        };
        records.push(record_at("/scan", ns, &scan));
        travel += beams as f32 * step;
    }
    records
}

#[test]
fn parts_of_an_uneven_motor_are_joined_by_their_bearings() {
    // Some packets state no increment.
    let odd = |at: usize, step: f32| [step, 0.0, step, f32::NAN, step][at % 5];
    for (direction, are_odd) in [(1.0, false), (-1.0, false), (1.0, true)] {
        let read = read(&uneven(12.0, direction, |at, step| if are_odd { odd(at, step) } else { step }));
        assert!((12..=13).contains(&read.len()), "{} turns", read.len());
        for ranges in &read.ranges[1..11] {
            let ranges: Vec<f32> = ranges.iter().map(|bits| f32::from_bits(*bits)).collect();
            let even = ranges.windows(2).filter(|pair| (pair[1] - pair[0]).abs() < 0.05).count();
            assert!(ranges.iter().all(|range| range.is_finite()) && even + 3 > ranges.len(), "{ranges:?}");
        }
    }
}

#[test]
fn a_part_that_looks_where_none_did_stands_alone() {
    let mut records = parts(30, 1.0, PI);
    let last = records.last_mut().expect("a part");
    let mut scan = LaserScan::decode(&last.data).expect("a scan");
    scan.angle_min = 3.0;
    last.data = scan.encode(Endian::Little);
    let read = read(&records);
    assert!(read.notes.last().expect("a turn").iter().any(|note| note.contains("or its sector, is another")));
}

#[test]
fn parts_in_any_order_are_joined_until_one_comes_again() {
    let mut records = parts(30, 1.0, TAU);
    for (turn, records) in records.chunks_mut(PARTS).enumerate() {
        let times: Vec<u64> = records.iter().map(|record| record.log_time_ns).collect();
        (0..PARTS).for_each(|at| records.swap(at, (at * 5 + turn * 2) % PARTS));
        records.iter_mut().zip(times).for_each(|(record, ns)| record.log_time_ns = ns);
    }
    let read = read(&records);
    assert_eq!(read.len(), 30);
    let whole = |turn: usize| bits((0..PARTS).flat_map(|at| part(turn, at, 1.0, TAU).ranges));
    assert!((0..30).all(|turn| read.ranges[turn] == whole(turn)));
}

/// Clouds of this many parts of a turn, each of points on a circle around the sensor.
fn clouds(turns: usize, parts: usize, share: f64) -> Vec<Record> {
    let point = |part: usize, i: usize| {
        let bearing = (part as f64 + share * i as f64 / 200.0) / parts as f64 * f64::from(TAU);
        [3.0 * bearing.cos(), 3.0 * bearing.sin(), 0.0]
    };
    let of = |turn: usize, part: usize| {
        let stamp_ns = part_ns(turn, part);
        let header = Header { stamp: Time::from_ns(stamp_ns), frame_id: "lidar".to_owned() };
        let points_m = (0..200).map(|i| point(part, i)).collect();
        let data = PointCloud2::from(&Cloud { header, points_m, ..Cloud::default() }).encode(Endian::Little);
        Record { topic: "/points", type_name: PointCloud2::SCHEMA_NAME, encoding: "cdr", log_time_ns: stamp_ns, data }
    };
    (0..turns).flat_map(|turn| (0..parts).map(move |part| (turn, part))).map(|(turn, part)| of(turn, part)).collect()
}

#[test]
fn clouds_of_parts_of_a_turn_are_joined_and_others_are_not() {
    let halves = read(&clouds(20, 2, 1.0));
    assert_eq!((halves.len(), halves.stamps_ns[7]), (20, part_ns(7, 0)));
    assert_eq!(halves.notes[7], ["a revolution joined of 2 messages: seq counts revolutions"]);
    assert_eq!(halves.seqs, (0..20).collect::<Vec<_>>());
    assert_eq!(read(&clouds(20, 1, 1.0)).len(), 20, "turns");
    assert_eq!(read(&clouds(20, 1, 0.2)).len(), 20, "a view that is limited");
}
