//! What is heard of a live robot, beside the recording of the same messages.

use std::thread;
use std::time::Duration;

use crosscut_ingest::{Feed, Following, LossKind, ReadOptions, Recording};
use crosscut_stage::{Notes, Revolution, Source as _, SourceError};

use crate::flight::{Folder, Form, Record, plain_flight, sensor};
use crate::scanners::{fixed, scans};
use crate::turns::parts;

const ADDRESS: &str = "zenoh://robot/scan";

fn never() -> Following {
    Following::until(|| false)
}

fn options(topic: &str, beside: &[&str]) -> ReadOptions {
    let beside = beside.iter().map(ToString::to_string).collect();
    ReadOptions { topic: Some(topic.to_owned()), beside, ..ReadOptions::default() }
}

/// Each revolution in full, with its notes.
type Seen = Vec<(String, Vec<String>)>;

fn read_on(recording: &mut Recording, seen: &mut Seen) -> Result<(), SourceError> {
    let (mut revolution, mut notes) = (Revolution::default(), Notes::default());
    while recording.next(&mut revolution, &mut notes)? {
        seen.push((format!("{revolution:?}"), notes.iter().map(str::to_owned).collect()));
        notes = Notes::default();
    }
    Ok(())
}

fn recorded(records: &[Record], options: &ReadOptions) -> Seen {
    let (folder, mut seen) = (Folder::new(), Seen::new());
    let path = folder.add("f.mcap", &Form::CHUNKED.write(records));
    let mut recording = Recording::open(&[path], options, sensor(&[])).expect("a recording");
    read_on(&mut recording, &mut seen).expect("it goes on");
    seen
}

fn hear(feed: &Feed, record: &Record) {
    feed.hear(record.topic, record.type_name, record.data.clone(), 0).expect("somebody reads");
}

/// What is heard of these messages, which come one after the other.
fn heard(records: &[Record], options: &ReadOptions) -> Seen {
    let (feed, messages) = Feed::of_robot();
    thread::scope(|scope| {
        let send = move || {
            for record in records {
                hear(&feed, record);
                thread::sleep(Duration::from_millis(1));
            }
        };
        thread::Builder::new().spawn_scoped(scope, send).expect("a thread");
        let mut seen = Seen::new();
        let recording = Recording::of_robot(ADDRESS, messages, options, &sensor(&[]), &never());
        read_on(&mut recording.expect("scans are heard"), &mut seen).expect("it goes on");
        seen
    })
}

#[test]
fn parts_of_turns_of_a_live_robot_are_joined() {
    let records = parts(12, 1.0, 6.0);
    let options = options("/scan", &[]);
    let of_file = recorded(&records, &options);
    assert!(of_file.len() < records.len(), "they are joined");
    assert_eq!(heard(&records, &options), of_file);
}

#[test]
fn several_scanners_of_a_live_robot_are_joined() {
    let records: Vec<Record> = fixed().into_iter().chain(scans(120, 0, 30.0)).collect();
    let options = options("/front/scan", &["/rear/scan"]);
    let of_file = recorded(&records, &options);
    assert!(of_file[0].1.iter().any(|note| note.contains("joined with /rear/scan")), "{:?}", of_file[0].1);
    // Who waits for the next scan of the other scanner finds none after the last one.
    assert_eq!(heard(&records, &options)[..119], of_file[..119]);
}

#[test]
fn of_more_messages_than_can_wait_the_oldest_are_left_out_and_counted() {
    let (feed, messages) = Feed::of_robot();
    plain_flight(164).iter().for_each(|record| hear(&feed, record));
    feed.hear("/scan", "sensor_msgs/msg/LaserScan", b"no scan".to_vec(), 7).expect("somebody reads");
    drop(feed);
    let options = options("/scan", &[]);
    let mut recording = Recording::of_robot(ADDRESS, messages, &options, &sensor(&[]), &never()).expect("scans");
    let mut seen = Seen::new();
    read_on(&mut recording, &mut seen).expect("it goes on");
    assert_eq!(seen.len(), 64);
    let mut counts = [0; 3];
    for loss in recording.losses() {
        match &loss.kind {
            LossKind::TooLate { count, .. } => counts[0] += count,
            LossKind::NotArrived { count, .. } => counts[1] += count,
            LossKind::Messages { count, .. } => counts[2] += count,
            other => panic!("{other}"),
        }
    }
    assert_eq!(counts, [101, 7, 1], "left out, lost on the way, not to be decoded");
}

#[test]
fn a_robot_that_can_no_longer_be_heard_ends_the_flight_with_an_error() {
    let (feed, messages) = Feed::of_robot();
    plain_flight(5).iter().for_each(|record| hear(&feed, record));
    feed.fail("the network is gone".to_owned()).expect("somebody reads");
    let mut recording = Recording::of_robot(ADDRESS, messages, &options("/scan", &[]), &sensor(&[]), &never());
    let mut seen = Seen::new();
    let ended = read_on(recording.as_mut().expect("scans are heard"), &mut seen);
    let why = ended.expect_err("it is an error").to_string();
    assert_eq!((seen.len(), why.as_str()), (5, "the network is gone"));
}
