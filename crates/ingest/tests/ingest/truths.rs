//! Truths beside scans: which belongs to which, in every way of writing a recording.

use crosscut_ingest::{IngestError, Truths, truth_map};
use crosscut_messages::{TRUTH_MAP_SCHEMA_NAME, TRUTH_MAP_TOPIC, TRUTH_SCHEMA_NAME, Truth, TruthMap};

use crate::flight::{Folder, Form, Record, plain_flight, time_ns};

/// A truth with so many walls, so that it can be told from others.
fn truth_at(log_time_ns: u64, walls: u32) -> Record {
    let data = Truth { walls, ..Truth::default() }.to_json();
    Record { topic: "/truth", type_name: TRUTH_SCHEMA_NAME, encoding: "json", log_time_ns, data }
}

/// Scans with the truths of those in `of` behind them.
fn with_truths(scans: u64, of: impl Iterator<Item = u64>) -> Vec<Record> {
    let mut records = plain_flight(scans);
    for i in of {
        records.push(truth_at(time_ns(i), i as u32 + 1));
    }
    records.sort_by_key(|record| record.log_time_ns);
    records
}

fn walls(truths: &mut Truths, log_time_ns: u64) -> Option<u32> {
    truths.at(log_time_ns).expect("it can be read").map(|truth| truth.walls)
}

#[test]
fn each_scan_gets_the_truth_of_its_log_time_in_every_form_of_recording() {
    let folder = Folder::new();
    for form in Form::all() {
        // No truth for scans 3 and 11, the last.
        let bytes = form.write(&with_truths(12, (0..11).filter(|&i| i != 3)));
        let mut truths = Truths::open(&folder.add("flight.mcap", &bytes)).expect("there are truths");
        for i in 0..12 {
            let expected = (i != 3 && i != 11).then_some(i as u32 + 1);
            assert_eq!(walls(&mut truths, time_ns(i)), expected, "scan {i}, {form:?}");
        }
    }
}

#[test]
fn scans_that_are_left_out_do_not_shift_the_truths() {
    let folder = Folder::new();
    for form in Form::all() {
        let mut truths =
            Truths::open(&folder.add("flight.mcap", &form.write(&with_truths(12, 0..12)))).expect("truths");
        for i in [2, 7, 11] {
            assert_eq!(walls(&mut truths, time_ns(i)), Some(i as u32 + 1), "scan {i}, {form:?}");
        }
    }
}

#[test]
fn of_several_with_one_log_time_the_first_belongs_to_the_first() {
    let folder = Folder::new();
    let records = [truth_at(time_ns(0), 1), truth_at(time_ns(0), 2), truth_at(time_ns(1), 3)];
    for form in Form::all() {
        let mut truths = Truths::open(&folder.add("flight.mcap", &form.write(&records))).expect("truths");
        let found = [0, 0, 0, 1].map(|i| walls(&mut truths, time_ns(i)));
        assert_eq!(found, [Some(1), Some(2), None, Some(3)], "{form:?}");
    }
}

#[test]
fn without_an_index_truths_out_of_order_are_found() {
    let folder = Folder::new();
    let form = Form { summary: false, ..Form::CHUNKED };
    let bytes = form.write(&[truth_at(time_ns(2), 3), truth_at(time_ns(0), 1), truth_at(time_ns(1), 2)]);
    let mut truths = Truths::open(&folder.add("flight.mcap", &bytes)).expect("truths");
    assert_eq!([2, 0, 1].map(|i| walls(&mut truths, time_ns(i))), [Some(3), Some(1), Some(2)]);
}

#[test]
fn a_truth_that_cannot_be_read_is_an_error_of_its_own_scan_only() {
    let folder = Folder::new();
    let mut records = with_truths(3, 0..3);
    let broken = records.iter_mut().filter(|record| record.topic == "/truth").nth(1).expect("the second");
    broken.data = br#"{"walls":1,"islands":0,"openings":[],"labels":[1]}"#.to_vec();
    let mut truths = Truths::open(&folder.add("flight.mcap", &Form::CHUNKED.write(&records))).expect("truths");
    assert_eq!(walls(&mut truths, time_ns(0)), Some(1));
    assert!(truths.at(time_ns(1)).expect_err("label 1 of 1 wall").to_string().contains("beam 0 is 1"));
    assert_eq!(walls(&mut truths, time_ns(2)), Some(3));
}

#[test]
fn a_recording_without_truth_is_refused_with_what_needs_none() {
    let folder = Folder::new();
    let refused = |records: &[Record]| {
        let path = folder.add("flight.mcap", &Form::CHUNKED.write(records));
        let error = Truths::open(&path).err().expect("there is none");
        assert!(matches!(error, IngestError::NoTruth { .. }), "{error:?}");
        error.to_string()
    };
    let text = refused(&plain_flight(2));
    assert!(text.contains("/truth") && text.contains("crosscut compare") && text.contains("flight.mcap"), "{text}");
    let mut in_cdr = truth_at(time_ns(0), 1);
    in_cdr.encoding = "cdr";
    assert!(refused(&[in_cdr]).contains("in JSON"));
}

#[test]
fn the_map_of_a_mine_is_found_and_a_broken_one_is_an_error() {
    let folder = Folder::new();
    let with_map = |data: Vec<u8>| {
        let mut records = with_truths(3, 0..3);
        let (topic, type_name) = (TRUTH_MAP_TOPIC, TRUTH_MAP_SCHEMA_NAME);
        records.push(Record { topic, type_name, encoding: "json", log_time_ns: time_ns(0), data });
        records.sort_by_key(|record| record.log_time_ns);
        records
    };
    for form in Form::all() {
        let of = |records: &[Record]| truth_map(&folder.add("flight.mcap", &form.write(records))).expect("readable");
        assert!(of(&with_truths(3, 0..3)).is_none());
        let map = of(&with_map(TruthMap::default().to_json())).expect("there is one").expect("of the schema");
        assert_eq!(map, TruthMap::default());
        assert!(of(&with_map(b"{}".to_vec())).expect("there is one").is_err());
    }
}
