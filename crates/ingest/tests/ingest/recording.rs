//! Whole recordings: every form that an MCAP can have, order, selection, parts, topics.

use std::num::NonZero;

use crosscut_ingest::{Found, IngestError, ReadOptions, Recording, describe};
use crosscut_messages::{Endian, Header, LaserScan, Message, Time};
use crosscut_stage::{Notes, Revolution, Source, Value};

use crate::flight::{
    Folder, Form, Record, START_NS, drain, expected, open, plain_flight, record_at, ros1_record_at, scan, sensor,
    time_ns,
};

fn options(topic: Option<&str>) -> ReadOptions {
    ReadOptions { topic: topic.map(str::to_owned), ..ReadOptions::default() }
}

fn refused(folder: &Folder, topic: Option<&str>) -> IngestError {
    match Recording::open(&[folder.path().to_owned()], &options(topic), sensor(&[])) {
        Ok(_) => panic!("must be refused"),
        Err(error) => error,
    }
}

fn of_type(topic: &'static str, type_name: &'static str, encoding: &'static str) -> Record {
    Record { type_name, encoding, ..record_at(topic, START_NS, &scan(0)) }
}

#[test]
fn every_form_of_mcap_gives_the_same_revolutions() {
    let folder = Folder::new();
    for form in Form::all() {
        let path = folder.add("flight.mcap", &form.write(&plain_flight(23)));
        let mut recording = open(&path).expect("a recording");
        assert_eq!((recording.total_revolutions(), recording.topic()), (Some(23), "/scan"), "{form:?}");
        assert_eq!(drain(&mut recording), expected(23), "{form:?}");
        assert_eq!((recording.losses(), recording.reordered()), (&[][..], 0), "{form:?}");
        assert_eq!(recording.last_log_time_ns(), time_ns(22));
    }
}

#[test]
fn big_endian_scans_read_like_little_endian_ones() {
    let mut records = plain_flight(4);
    records[2].data = scan(2).encode(Endian::Big);
    let folder = Folder::new();
    let mut recording = open(&folder.add("f.mcap", &Form::CHUNKED.write(&records))).expect("a recording");
    assert_eq!(drain(&mut recording), expected(4));
}

#[test]
fn an_index_gives_log_time_order_with_ties_in_file_order_and_none_gives_file_order_and_counts() {
    // Chunks of five: the second one begins before the first one ends; 3 and 7 have the same log time as 2.
    let log_times = [0, 1, 2, 2, 9, 4, 3, 2, 8, 5, 10];
    let records: Vec<_> =
        log_times.iter().enumerate().map(|(i, &t)| record_at("/scan", time_ns(t), &scan(i as u64))).collect();
    let folder = Folder::new();
    for form in Form::all() {
        let mut recording = open(&folder.add("f.mcap", &form.write(&records))).expect("a recording");
        let read = drain(&mut recording);
        let order: Vec<u64> = read.stamps_ns.iter().map(|stamp| (stamp - START_NS) / crate::flight::STEP_NS).collect();
        assert_eq!(read.seqs, (0..11).collect::<Vec<_>>(), "seq is the place in the order that is delivered");
        if form.is_indexed() {
            assert_eq!(order, [0, 1, 2, 3, 7, 6, 5, 9, 8, 4, 10], "{form:?}");
            assert_eq!(recording.reordered(), 0);
        } else {
            assert_eq!(order, (0..11).collect::<Vec<_>>(), "{form:?}");
            assert_eq!(recording.reordered(), 4);
            assert_eq!(read.notes[5], ["recorded 0.500 s before the scan before it"]);
        }
        assert!(recording.losses().is_empty(), "nothing is lost by order");
    }
}

#[test]
fn messages_of_other_topics_are_passed_over() {
    let mut records = Vec::new();
    for record in plain_flight(12) {
        records.push(Record { data: vec![0xee; 3000], ..of_type("/camera", "sensor_msgs/msg/Image", "cdr") });
        records.push(record);
    }
    let folder = Folder::new();
    for form in Form::all() {
        let mut recording = open(&folder.add("f.mcap", &form.write(&records))).expect("a recording");
        assert_eq!(drain(&mut recording), expected(12), "{form:?}");
    }
}

#[test]
fn another_type_under_the_name_of_the_scan_topic_is_left_alone() {
    let mut records = plain_flight(3);
    records.insert(1, of_type("/scan", "std_msgs/msg/String", "cdr"));
    let folder = Folder::new();
    for form in Form::all() {
        let mut recording = open(&folder.add("f.mcap", &form.write(&records))).expect("a recording");
        assert_eq!((drain(&mut recording), recording.losses()), (expected(3), &[][..]), "{form:?}");
    }
}

#[test]
fn a_flight_in_the_encoding_of_ros_1_is_read_like_one_of_ros_2_and_named_where_it_is_damaged() {
    let mut records: Vec<_> = (0..12).map(|i| ros1_record_at("/scan", time_ns(i), &scan(i))).collect();
    let folder = Folder::new();
    for form in Form::all() {
        let mut recording = open(&folder.add("f.mcap", &form.write(&records))).expect("a recording");
        assert_eq!((drain(&mut recording), recording.losses()), (expected(12), &[][..]), "{form:?}");
    }
    let description =
        describe(&folder.path().join("f.mcap"), &sensor(&[]), &ReadOptions::default()).expect("a recording");
    assert_eq!(description.topics[0].first_scan.as_ref().map(|scan| (scan.beams, scan.returns)), Some((8, 7)));

    records[3].data.truncate(40);
    let mut recording = open(&folder.add("f.mcap", &Form::CHUNKED.write(&records))).expect("a recording");
    assert_eq!(drain(&mut recording).len(), 12);
    let [loss] = recording.losses() else { panic!("{:?}", recording.losses()) };
    assert!(loss.to_string().contains("the message ends in `scan_time`, after 40 bytes"), "{loss}");
}

#[test]
fn several_scan_topics_have_to_be_told_apart_by_name() {
    let folder = Folder::new();
    let records =
        [record_at("/front", START_NS, &scan(0)), record_at("/rear", START_NS, &scan(1)), of_type("/odom", "O", "cdr")];
    let path = folder.add("f.mcap", &Form::CHUNKED.write(&records));
    assert_eq!(
        refused(&folder, None).to_string(),
        "there are several scan topics; name one with --topic, or each of a vehicle's scanners:\n  \
         /front  sensor_msgs/msg/LaserScan  cdr  1 message\n  /rear  sensor_msgs/msg/LaserScan  cdr  1 message"
    );
    let mut rear = Recording::open(&[path], &options(Some("/rear")), sensor(&[])).expect("named");
    assert_eq!(drain(&mut rear).ranges, expected(2).ranges[1..]);
}

#[test]
fn a_wrong_topic_lists_what_there_is_nearest_first() {
    let folder = Folder::new();
    folder
        .add("f.mcap", &Form::CHUNKED.write(&[of_type("/camera", "I", "cdr"), record_at("/scan", START_NS, &scan(0))]));
    let IngestError::NoSuchTopic { wanted, topics } = refused(&folder, Some("/scam")) else { panic!("another error") };
    assert_eq!((wanted.as_str(), topics.0[0].name.as_str(), topics.0.len()), ("/scam", "/scan", 2));
    assert!(matches!(refused(&folder, Some("/camera")), IngestError::NotAScanTopic { .. }));
}

#[test]
fn a_topic_is_found_with_a_slash_in_front_or_without() {
    let folder = Folder::new();
    for (in_file, asked_for) in [("/scan", "scan"), ("scan", "/scan")] {
        let records = [record_at(in_file, START_NS, &scan(0)), record_at("/rear", START_NS, &scan(1))];
        let path = folder.add("f.mcap", &Form::CHUNKED.write(&records));
        let recording = Recording::open(&[path], &options(Some(asked_for)), sensor(&[])).expect("the same topic");
        assert_eq!(recording.topic(), in_file);
    }
    folder.add(
        "f.mcap",
        &Form::CHUNKED.write(&[record_at("/scan", START_NS, &scan(0)), record_at("scan", START_NS, &scan(1))]),
    );
    let of = |topic| {
        Recording::open(&[folder.path().to_owned()], &options(Some(topic)), sensor(&[])).expect("by its own name")
    };
    assert_eq!((of("scan").topic(), of("/scan").topic()), ("scan", "/scan"));
}

#[test]
fn scans_in_another_encoding_are_named_with_what_to_do() {
    let says = |type_name: &'static str, encoding: &'static str, what: &str| {
        let folder = Folder::new();
        folder.add("f.mcap", &Form::CHUNKED.write(&[of_type("/scan", type_name, encoding)]));
        let text = refused(&folder, None).to_string();
        assert!(text.contains(what) && text.contains(type_name), "{text}");
        assert!(refused(&folder, Some("/scan")).to_string().contains(what));
    };
    says("sensor_msgs/msg/LaserScan", "json", "scans are read in cdr");
    says("foxglove.LaserScan", "flatbuffer", "in json and protobuf");
    says("sensor_msgs/msg/PointCloud2", "xml", "--as LaserScan");
}

#[test]
fn files_of_other_kinds_are_named() {
    let folder = Folder::new();
    let found = |name: &str, bytes: &[u8]| match open(&folder.add(name, bytes)) {
        Err(IngestError::NotRecording { found, .. }) => found,
        other => panic!("{:?}", other.err()),
    };
    assert!(found("a.bag", b"#ROSRECORD V1.2\n...").to_string().contains("rosbag fix"));
    assert!(found("a.rrd", b"RRF2....").to_string().contains("Rerun"));
    assert_eq!(found("a.mcap", b""), Found::Empty);
    #[cfg(unix)]
    assert!(matches!(open(std::path::Path::new("/dev/null")), Err(IngestError::NotAFile { .. })));
    assert!(matches!(open(&folder.path().join("none.mcap")), Err(IngestError::Missing { .. })));
    assert!(matches!(open(&folder.add("b.mcap", mcap::MAGIC)), Err(IngestError::NothingReadable { .. })));
    for cut in [&b"#ROSBAG V2.0\n..."[..], b"SQLite format 3\0..."] {
        assert!(matches!(open(&folder.add("cut", cut)), Err(IngestError::NothingReadable { .. })));
    }
}

#[test]
fn a_hole_in_the_stamps_is_noted_and_a_slow_or_unsteady_sensor_is_not() {
    let notes = |seconds: &[f64]| {
        let at = |s: &f64| {
            let (stamp_ns, mut scan) = (START_NS + (s * 1e9).round() as u64, scan(0));
            scan.header.stamp = Time::from_ns(stamp_ns);
            record_at("/scan", stamp_ns, &scan)
        };
        let folder = Folder::new();
        folder.add("f.mcap", &Form::CHUNKED.write(&seconds.iter().map(at).collect::<Vec<_>>()));
        let all = drain(&mut open(folder.path()).expect("a flight")).notes.concat();
        all.into_iter().filter(|note| note.contains("after that of the scan before")).collect::<Vec<_>>()
    };
    assert_eq!(notes(&[0.0, 0.1, 0.2, 3.3, 3.4]), ["the stamp is 3.100 s after that of the scan before"]);
    let two = notes(&[0.0, 0.1, 0.2, 3.2, 6.2, 6.3]);
    assert_eq!(two, ["the stamp is 3.000 s after that of the scan before"; 2], "one beside the other");
    assert_eq!(notes(&[0.0, 0.0, 2.0, 2.0, 4.0, 4.0]), [""; 0], "two scans with each stamp");
    assert_eq!(notes(&[0.0, 2.0, 4.0, 7.0, 9.0]), [""; 0], "a revolution every 2 s");
    assert_eq!(notes(&[0.0, 0.1, 0.9, 1.0, 1.1]), [""; 0], "less than a second");
}

#[test]
fn times_and_every_select_and_seq_stays_that_of_the_whole_topic() {
    let folder = Folder::new();
    let (first, second) = (plain_flight(20), (20..30).map(|i| record_at("/scan", time_ns(i), &scan(i))));
    for form in Form::all() {
        folder.add("f_1.mcap", &form.write(&first));
        folder.add("f_2.mcap", &form.write(&second.clone().collect::<Vec<_>>()));
        let seqs = |from_s: Option<f64>, to_s: Option<f64>, every: u64| {
            let every = NonZero::new(every).expect("not 0");
            let options = ReadOptions { from_s, to_s, every, ..ReadOptions::default() };
            let mut recording = Recording::open(&[folder.path().to_owned()], &options, sensor(&[])).expect("a flight");
            let total = recording.total_revolutions();
            let read = drain(&mut recording);
            assert!(total.is_none_or(|total| total == read.len() as u64));
            assert_eq!(read.stamps_ns, read.seqs.iter().map(|&seq| time_ns(seq)).collect::<Vec<_>>());
            read.seqs
        };
        assert_eq!(seqs(None, None, 7), [0, 7, 14, 21, 28], "{form:?}");
        assert_eq!(seqs(Some(0.5), Some(0.8), 1), [5, 6, 7, 8], "{form:?}");
        assert_eq!(seqs(Some(1.95), None, 4), [20, 24, 28], "{form:?}");
        assert_eq!(seqs(None, Some(0.2), 2), [0, 2], "{form:?}");
    }
}

#[test]
fn a_time_without_scans_is_an_error_of_the_source_and_not_its_end() {
    let folder = Folder::new();
    for form in Form::all() {
        folder.add("f_1.mcap", &form.write(&plain_flight(20)));
        let options = ReadOptions { from_s: Some(99.0), ..ReadOptions::default() };
        let mut recording = Recording::open(&[folder.path().to_owned()], &options, sensor(&[])).expect("a flight");
        let error = recording.next(&mut Revolution::default(), &mut Notes::default()).expect_err("no scan");
        assert!(error.to_string().contains("from 99 s on; the last one before that is at 1.9 s"), "{form:?}: {error}");
    }
}

fn with_stamp(i: u64, stamp_ns: u64) -> Record {
    let odd = LaserScan { header: Header { stamp: Time::from_ns(stamp_ns), frame_id: "laser".to_owned() }, ..scan(i) };
    record_at("/scan", time_ns(i), &odd)
}

#[test]
fn missing_repeated_and_backward_stamps_are_kept_in_order_and_noted() {
    let stamps = [time_ns(0), 0, time_ns(5), time_ns(5), time_ns(4)];
    let records: Vec<_> = stamps.iter().enumerate().map(|(i, &stamp)| with_stamp(i as u64, stamp)).collect();
    let folder = Folder::new();
    let read = drain(&mut open(&folder.add("f.mcap", &Form::CHUNKED.write(&records))).expect("a recording"));
    assert_eq!(read.stamps_ns, [time_ns(0), time_ns(1), time_ns(5), time_ns(5), time_ns(4)]);
    assert_eq!(
        read.notes.concat(),
        [
            "no stamp: the time of recording is used",
            "the stamp is that of the scan before",
            "the stamp is 0.100 s before that of the scan before"
        ]
    );
}

fn two_sensors() -> Vec<Record> {
    let of_frame = |i: u64, frame_id: &str| LaserScan {
        header: Header { stamp: Time::from_ns(time_ns(i)), frame_id: frame_id.to_owned() },
        ..scan(i)
    };
    let frames = ["front", "front", "rear", "front"];
    frames.iter().zip(0..).map(|(frame, i)| record_at("/scan", time_ns(i), &of_frame(i, frame))).collect()
}

#[test]
fn two_frames_on_one_topic_are_noted_at_each_change() {
    let folder = Folder::new();
    let read = drain(&mut open(&folder.add("f.mcap", &Form::CHUNKED.write(&two_sensors()))).expect("a recording"));
    let begins = |note: &[String], start: &str| note.len() == 1 && note[0].starts_with(start);
    assert!(read.notes[1].is_empty(), "{:?}", read.notes);
    assert!(begins(&read.notes[2], "frame_id `rear` after `front`"), "{:?}", read.notes);
    assert!(begins(&read.notes[3], "frame_id `front` after `rear`"), "{:?}", read.notes);
    assert!(read.notes[3][0].contains("ingest.frame_id"), "what to do: {:?}", read.notes);
}

#[test]
fn one_frame_can_be_selected_and_one_that_is_not_there_is_an_error() {
    let folder = Folder::new();
    let path = folder.add("f.mcap", &Form::CHUNKED.write(&two_sensors()));
    let of_frame = |frame: &str| {
        let sensor = sensor(&[("frame_id", Value::String(frame.to_owned()))]);
        Recording::open(std::slice::from_ref(&path), &ReadOptions::default(), sensor).expect("a recording")
    };
    let mut front = of_frame("front");
    let read = drain(&mut front);
    assert_eq!((read.seqs, front.of_other_frames()), (vec![0, 1, 3], 1));
    assert!(read.notes.concat().is_empty());
    let error = of_frame("top").next(&mut Revolution::default(), &mut Notes::default()).expect_err("no such frame");
    assert!(error.to_string().contains("\"top\"") && error.to_string().contains("\"front\""), "{error}");
}

#[test]
fn messages_that_cannot_be_decoded_are_empty_revolutions_and_one_loss() {
    let mut records = plain_flight(12);
    records[3].data.truncate(60);
    records[7].data = vec![0, 3, 0, 0];
    let folder = Folder::new();
    let mut recording = open(&folder.add("f.mcap", &Form::CHUNKED.write(&records))).expect("a recording");
    let read = drain(&mut recording);
    assert_eq!((read.len(), read.stamps_ns[3]), (12, time_ns(3)));
    assert!(read.ranges[3].is_empty() && read.notes[3][0].starts_with("the message cannot be decoded"), "{read:?}");
    assert!(read.notes[7][0].contains("PL_CDR"));
    let counts: Vec<usize> = read.notes.iter().map(Vec::len).collect();
    assert_eq!(counts, [0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0], "their neighbours are as they were: {:?}", read.notes);
    let [loss] = recording.losses() else { panic!("{:?}", recording.losses()) };
    let text = loss.to_string();
    assert!(text.starts_with("2 messages of /scan cannot be decoded, the first is number 3: "), "{text}");
    assert!(text.ends_with("f.mcap"), "{text}");
}

#[test]
fn a_description_says_what_is_in_the_file() {
    let mut records = plain_flight(11);
    records.push(of_type("/odom", "nav_msgs/msg/Odometry", "cdr"));
    let folder = Folder::new();
    for form in Form::all() {
        let path = folder.add("f.mcap", &form.write(&records));
        let description = describe(&path, &sensor(&[]), &ReadOptions::default()).expect("a recording");
        let index = description.properties.iter().find(|(name, _)| *name == "index").map(|(_, index)| index.as_str());
        assert_eq!(
            (description.format, index.is_some_and(|index| index.starts_with("3 chunks"))),
            ("MCAP", form.is_indexed()),
            "{form:?}"
        );
        assert!(description.properties.contains(&("profile", "ros2".to_owned())), "{form:?}");
        assert!(description.properties.contains(&("writer", "test".to_owned())), "{form:?}");
        assert_eq!(description.duration_s(), Some(1.0));
        let [odometry, scans] = &description.topics[..] else { panic!("{:?}", description.topics) };
        assert_eq!((odometry.info.messages, odometry.first_scan.is_none()), (Some(1), true));
        assert_eq!((scans.info.messages, scans.rate_hz), (Some(11), Some(10.0)));
        let first = scans.first_scan.as_ref().expect("a scan");
        assert_eq!((first.frame_id.as_str(), first.beams, first.returns, first.full_turn), ("laser", 8, 7, false));
        assert!(
            (first.field_of_view_rad - 0.7).abs() < 1e-6 && first.notes == ["1 beam of range NaN read as no return"]
        );
        assert!(description.losses.is_empty(), "{form:?}");
    }
}
