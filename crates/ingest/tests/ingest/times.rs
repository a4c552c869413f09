//! Times of recording and stamps that cannot be right, and flights of which nothing can be decoded.

use crosscut_ingest::{LossKind, ReadOptions, Recording, describe};
use crosscut_messages::{Header, LaserScan, Time};
use crosscut_stage::{Notes, Revolution, Source};

use crate::flight::{Folder, Form, Record, drain, open, plain_flight, record_at, scan, sensor, time_ns};

fn at(i: u64, log_time_ns: u64, stamp_ns: u64) -> Record {
    let header = Header { stamp: Time::from_ns(stamp_ns), frame_id: "laser".to_owned() };
    record_at("/scan", log_time_ns, &LaserScan { header, ..scan(i) })
}

fn selected(folder: &Folder, from_s: f64, to_s: f64) -> Vec<u64> {
    let options = ReadOptions { from_s: Some(from_s), to_s: Some(to_s), ..ReadOptions::default() };
    let mut recording = Recording::open(&[folder.path().to_owned()], &options, sensor(&[])).expect("a flight");
    drain(&mut recording).stamps_ns
}

/// Duration and rate of the only topic.
fn described(folder: &Folder) -> (f64, f64, bool) {
    let path = folder.path().join("f.mcap");
    let description = describe(&path, &sensor(&[]), &ReadOptions::default()).expect("a recording");
    let rate_hz = description.topics[0].rate_hz.expect("a rate");
    (description.duration_s().expect("a duration"), rate_hz, description.has_odd_times)
}

#[test]
fn a_clock_of_a_simulation_that_starts_at_0_keeps_its_first_stamp() {
    let records: Vec<_> = (0..20).map(|i| at(i, time_ns(i), i * 100_000_000)).collect();
    let folder = Folder::new();
    for form in Form::all() {
        let read = drain(&mut open(&folder.add("f.mcap", &form.write(&records))).expect("a recording"));
        assert_eq!(read.stamps_ns, (0..20).map(|i| i * 100_000_000).collect::<Vec<_>>(), "{form:?}");
        assert!(read.notes.concat().is_empty(), "{:?}", read.notes);
    }
}

#[test]
fn scans_from_before_the_clock_was_set_are_at_the_start_of_the_flight() {
    for begin_ns in [time_ns(5), 4_000_500_000_000] {
        let later = |i: u64| begin_ns + (i - 5) * 100_000_000;
        let records: Vec<_> = (0..60).map(|i| if i < 5 { at(i, 0, 0) } else { at(i, later(i), later(i)) }).collect();
        let folder = Folder::new();
        for form in Form::all() {
            let path = folder.add("f.mcap", &form.write(&records));
            let read = drain(&mut open(&path).expect("a recording"));
            assert_eq!(read.stamps_ns[..7], [[begin_ns; 6].as_slice(), &[later(6)]].concat(), "{form:?}");
            assert!(read.notes[0].iter().any(|note| note.contains("implausible time")), "{:?}", read.notes[0]);
            assert_eq!(selected(&folder, 1.0, 1.2), [later(15), later(16), later(17)], "{form:?}");
            let (duration_s, rate_hz, has_odd_times) = described(&folder);
            assert!((duration_s - 5.4).abs() < 1e-6 && rate_hz < 11.5 && has_odd_times, "{form:?}: {duration_s}");
        }
    }
}

#[test]
fn broken_times_of_recording_are_told_by_the_stamps() {
    let log_time = |i: u64| match i {
        25 => u64::MAX - 25,
        26 => 12_345,
        _ => time_ns(i),
    };
    let records: Vec<_> = (0..60).map(|i| at(i, log_time(i), time_ns(i))).collect();
    let folder = Folder::new();
    for form in Form::all() {
        let path = folder.add("f.mcap", &form.write(&records));
        let mut read = drain(&mut open(&path).expect("a recording")).stamps_ns;
        read.sort_unstable();
        assert_eq!(read, (0..60).map(time_ns).collect::<Vec<_>>(), "{form:?}");
        let mut selected = selected(&folder, 2.45, 2.75);
        selected.sort_unstable();
        assert_eq!(selected, [25, 26, 27].map(time_ns), "{form:?}");
        let (duration_s, rate_hz, has_odd_times) = described(&folder);
        assert!((duration_s - 5.9).abs() < 1e-6 && (rate_hz - 10.0).abs() < 0.1 && has_odd_times, "{form:?}");
    }
}

#[test]
fn a_flight_of_which_no_scan_can_be_decoded_gives_nothing_and_fails() {
    let mut records = plain_flight(80);
    records.iter_mut().for_each(|record| record.data[0] = 0x77);
    let folder = Folder::new();
    let mut recording = open(&folder.add("f.mcap", &Form::CHUNKED.write(&records))).expect("a recording");
    let error = recording.next(&mut Revolution::default(), &mut Notes::default()).expect_err("nothing to give");
    assert!(error.to_string().contains("none of the 80 messages of /scan can be decoded"), "{error}");
    assert!(matches!(recording.losses(), [loss] if matches!(loss.kind, LossKind::Messages { count: 80, .. })));
}

#[test]
fn scans_before_the_first_that_can_be_decoded_are_given_once_it_comes() {
    let mut records = plain_flight(80);
    records[..70].iter_mut().for_each(|record| record.data[0] = 0x77);
    let folder = Folder::new();
    let read = drain(&mut open(&folder.add("f.mcap", &Form::CHUNKED.write(&records))).expect("a recording"));
    assert_eq!((read.seqs, read.stamps_ns), ((0..80).collect::<Vec<_>>(), (0..80).map(time_ns).collect::<Vec<_>>()));
    assert!(read.notes[69][0].contains("cannot be decoded") && read.notes[70].is_empty(), "{:?}", read.notes);
}
