//! Scans rebuilt from a recording are those that the stages had.

use crosscut_ingest::{ReadOptions, Recording as Flight};
use crosscut_recorder::Recorder;
use crosscut_rrd::Recording;
use crosscut_sensor::Sensor;
use crosscut_stage::NoteCode::N101;
use crosscut_stage::{Frame, Observer as _, Revolution, Source as _};

use crate::{frames, reading};

/// Records a flight without stages, and gives its frames.
fn flown(flight: &str, topics: &[&str], path: &std::path::Path) -> Vec<Frame> {
    let options = ReadOptions {
        topic: topics.first().map(|&topic| topic.to_owned()),
        beside: topics.iter().skip(1).map(|&topic| topic.to_owned()).collect(),
        ..ReadOptions::default()
    };
    let mut flight = Flight::open(&[flight.into()], &options, Sensor::default()).expect("it can be recorded");
    let mut recorder = Recorder::new(reading::options(path)).expect("it can be recorded");
    let mut frames = Vec::new();
    loop {
        let mut frame = Frame::default();
        if !flight.next(&mut frame.revolution, &mut frame.notes).expect("it can be recorded") {
            break;
        }
        frame.notes.begin_stages();
        frame.notes.add(N101, "a stage's own");
        recorder.observe(&frame).expect("it can be recorded");
        frames.push(frame);
    }
    recorder.finish().expect("it can be recorded");
    frames
}

fn compare(flight: &str, topics: &[&str]) {
    let folder = tempfile::tempdir().expect("it can be recorded");
    let path = folder.path().join("flight.rrd");
    let frames = flown(flight, topics, &path);
    let recording = Recording::open(&path).expect("it can be recorded");
    let scans: Vec<_> = recording.revolutions().expect("it can be recorded").map(Result::unwrap).collect();
    assert_eq!(scans.len(), frames.len());
    for (scan, mut frame) in scans.into_iter().zip(frames) {
        frame.revolution.frame_id.clear();
        assert_eq!(scan.notes.coded(), frame.notes.of_revolution());
        // Debug prints numbers so that they read back as the same bits; NaN as itself.
        assert_eq!(format!("{:?}", scan.revolution), format!("{:?}", frame.revolution), "{flight}");
    }
}

#[test]
fn a_scan_rebuilt_from_a_recording_differs_in_a_bit() {
    compare(concat!(env!("CARGO_MANIFEST_DIR"), "/../../recordings/tee.mcap"), &[]);
    let cases = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/cases/T13-exact-not-same");
    for (case, topics) in [("blind_noted", &[][..]), ("turning", &[]), ("two_scanners", &["/scan_front", "/scan_rear"])]
    {
        let path = format!("{cases}/{case}.mcap");
        if std::path::Path::new(&path).is_file() {
            compare(&path, topics);
        } else {
            println!("skipped, {path} is not there");
        }
    }
}

#[test]
fn a_cloud_rebuilt_from_a_recording_differs_in_a_bit_or_appears_where_there_is_none() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("flight.rrd");
    let mut frames = [0, 1, 2].map(frames::frame);
    frames::make_ways(&mut frames[1]);
    reading::record_with(reading::options(&path), &frames);
    let recording = Recording::open(&path).expect("it was recorded");
    let scans = recording.revolutions().expect("it was recorded").map(Result::unwrap);
    assert!(!frames[1].revolution.cloud_m.is_empty());
    let cloud = |revolution: Revolution| (revolution.cloud_m, revolution.cloud_tilt);
    assert!(scans.map(|scan| cloud(scan.revolution)).eq(frames.iter().map(|frame| cloud(frame.revolution.clone()))));
}
