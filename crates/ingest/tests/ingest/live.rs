//! Scans of a live robot beside those of its recording.

use std::f64::consts::PI;

use crosscut_ingest::{ReadOptions, Recording};
use crosscut_messages::{Cloud, Endian, Header, LaserScan, PointCloud2, ScanDecoder, ScanMessage, Time};
use crosscut_sensor::{Live, Odometry};
use crosscut_stage::{Beam, Notes, Revolution, Source, Value};

use crate::flight::{Folder, Form, Record, record_at, sensor, time_ns};
use crate::turning::{odometry, scan};
use crate::turns::turn;

/// Revolutions with their notes, as text: equal where all of their bits are.
type Shown = Vec<(Revolution, String)>;

fn text_of(revolution: &Revolution, notes: &Notes) -> String {
    format!("{revolution:?} {:?}", notes.iter().collect::<Vec<_>>())
}

fn recorded(mut records: Vec<Record>, settings: &[(&str, Value)]) -> Shown {
    records.sort_by_key(|record| record.log_time_ns);
    let folder = Folder::new();
    let path = folder.add("f.mcap", &Form::CHUNKED.write(&records));
    let options = ReadOptions::default();
    let mut recording = Recording::open(&[path], &options, sensor(settings)).expect("a recording");
    let mut shown = Vec::new();
    loop {
        let (mut revolution, mut notes) = (Revolution::default(), Notes::default());
        if !recording.next(&mut revolution, &mut notes).expect("readable") {
            return shown;
        }
        let text = text_of(&revolution, &notes);
        shown.push((revolution, text));
    }
}

/// Each scan is shown when the odometry is there that was sent up to `late_ns` after its stamp.
fn live(records: &[Record], late_ns: u64, settings: &[(&str, Value)]) -> Shown {
    let (poses, scans): (Vec<_>, Vec<_>) = records.iter().partition(|record| Odometry::reads(record.type_name));
    let (sensor, mut live, mut odometry) = (sensor(settings), Live::default(), Odometry::default());
    let mut poses = poses.into_iter().peekable();
    let show = |(seq, record): (u64, &Record)| {
        while let Some(pose) = poses.next_if(|pose| pose.log_time_ns <= record.log_time_ns + late_ns) {
            odometry.push_message(pose.type_name, &pose.data).expect("a pose");
        }
        let mut message = ScanMessage::default();
        let decoder = ScanDecoder::for_schema(record.type_name, "", "cdr").expect("a scan");
        decoder.decode_into(&record.data, &mut message).expect("a scan");
        odometry.forget_before(Live::span_ns(&message)[0]);
        let (mut revolution, mut notes) = (Revolution::default(), Notes::default());
        live.show(&message, &odometry, &sensor, &mut revolution, &mut notes);
        assert_eq!(Live::pose(&message, &odometry).is_some(), revolution.odometry.is_some());
        revolution.seq = seq;
        let text = text_of(&revolution, &notes);
        (revolution, text)
    };
    (0..).zip(scans).map(show).collect()
}

fn assert_equal(live: &[(Revolution, String)], recorded: &[(Revolution, String)]) {
    assert_eq!(live.len(), recorded.len());
    for ((revolution, live), (_, recorded)) in live.iter().zip(recorded) {
        assert_eq!(live, recorded, "revolution {}", revolution.seq);
    }
}

fn of_scans(scans: impl Iterator<Item = LaserScan>) -> impl Iterator<Item = Record> {
    (0..).zip(scans).map(|(number, scan)| record_at("/scan", time_ns(number), &scan))
}

#[test]
fn live_scans_are_corrected_for_motion_as_those_of_the_recording() {
    for settings in [vec![], vec![("upside_down", Value::Boolean(true))], vec![("deskew", Value::Boolean(false))]] {
        for (rate_rad_s, direction) in [(PI, 1.0), (-PI, -1.0), (0.3, 1.0)] {
            // Odometry ends in the middle of the last scan.
            let scans = || of_scans((0..10).map(|number| scan(number, rate_rad_s, direction)));
            let with_odometry: Vec<_> = odometry(2.0, rate_rad_s).take(95).chain(scans()).collect();
            let shown = live(&with_odometry, 110_000_000, &settings);
            assert_equal(&shown, &recorded(with_odometry, &settings));
            let is_corrected = shown.iter().any(|(_, text)| text.contains("turned by"));
            assert_eq!(is_corrected, rate_rad_s != 0.3 && settings.iter().all(|(name, _)| *name != "deskew"));
            let without: Vec<_> = scans().collect();
            assert_equal(&live(&without, 0, &settings), &recorded(without, &settings));
        }
    }
}

#[test]
fn live_clouds_are_corrected_for_motion_as_those_of_the_recording() {
    let times_s: Vec<_> = (0..50).map(|i| 0.002 * f64::from(i) - 0.03).collect();
    let points_m = (0..50).map(|i| [4.0, 0.1 * f64::from(i), 0.1]).collect();
    let header = Header { stamp: Time::from_ns(time_ns(1)), frame_id: "lidar".to_owned() };
    let data = PointCloud2::from(&Cloud { header, points_m, times_s, rings: Vec::new() }).encode(Endian::Little);
    let (type_name, encoding) = (PointCloud2::SCHEMA_NAME, "cdr");
    let of_cloud = Record { topic: "/points", type_name, encoding, log_time_ns: time_ns(1), data };
    let records: Vec<_> = odometry(3.0, 1.5).chain([of_cloud]).collect();
    let shown = live(&records, 100_000_000, &[]);
    assert!(shown[0].1.contains("moved by"), "{}", shown[0].1);
    assert_equal(&shown, &recorded(records, &[]));
}

#[test]
fn blind_sectors_of_a_live_robot_are_known_from_the_hundredth_scan() {
    let room = |beam: usize| if (45..135).contains(&beam) { 0.0 } else { 3.0 };
    let records: Vec<_> = (0..120).map(|number| turn(number, room)).collect();
    let (shown, expected) = (live(&records, 0, &[]), recorded(records.clone(), &[]));
    assert_equal(&shown[99..], &expected[99..]);
    let unknown = |(revolution, _): &(Revolution, String)| {
        let beams = &revolution.sweep.as_ref().expect("beams").beams;
        beams.iter().filter(|beam| **beam == Beam::Unknown).count()
    };
    assert_eq!([98, 99].map(|at| unknown(&shown[at])), [0, 90]);
    let in_view = [("find_blind_sectors", Value::Boolean(false))];
    assert_equal(&live(&records, 0, &in_view), &recorded(records, &in_view));
}
