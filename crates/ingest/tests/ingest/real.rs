//! Real recordings, where they are at hand.

use std::path::{Path, PathBuf};

use crosscut_ingest::{CSV_PARAMS, CsvGeometry, IngestError, ReadOptions, Recording, describe};
use crosscut_stage::{Params, Value};

use crate::flight::{drain, open, sensor};

fn data(name: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data").join(name);
    if path.is_file() {
        return Some(path);
    }
    println!("skipped: {} is not there", path.display());
    None
}

#[test]
fn the_corridors_give_all_their_scans() {
    for (name, scans) in [("cross", 688), ("threeway", 233), ("dead", 285), ("left", 112)] {
        let Some(path) = data(&format!("corridor_{name}.mcap")) else { return };
        let mut recording = open(&path).expect("a recording");
        assert_eq!(recording.total_revolutions(), Some(scans));
        let read = drain(&mut recording);
        assert_eq!((read.len() as u64, recording.losses()), (scans, &[][..]), "{name}");
        assert!(read.ranges.iter().all(|ranges| ranges.len() == 726));
        let near = "beams below range_min 0.02 m left out";
        assert!(read.notes.iter().flatten().all(|note| note.ends_with(near)), "{name} has notes of another kind");
    }
}

#[test]
fn a_corridor_is_described_as_it_is_documented() {
    let Some(path) = data("corridor_cross.mcap") else { return };
    let description = describe(&path, &sensor(&[]), &ReadOptions::default()).expect("a recording");
    let [scans] = &description.topics[..] else { panic!("{:?}", description.topics) };
    let first = scans.first_scan.as_ref().expect("a scan");
    assert_eq!((description.format, first.beams, first.range_m), ("MCAP", 726, [0.02, 5.6]));
    // Counted with an independent reader: 293 NaN and 54 below range_min.
    let notes = ["293 beams of range NaN read as no return", "54 beams below range_min 0.02 m left out"];
    assert_eq!((first.returns, &first.notes[..]), (726 - 293 - 54, &notes.map(str::to_owned)[..]));
    assert!(
        (first.field_of_view_rad.to_degrees() - 254.9).abs() < 0.1
            && (scans.rate_hz.expect("a rate") - 10.0).abs() < 1e-9
    );
}

#[test]
fn real_bags_and_logs_give_all_their_scans() {
    let files = [
        ("corridor_ros1.bag", "/scan", 183),
        ("aces_excerpt.clf", "/flaser", 1993),
        ("intel_excerpt.clf", "/flaser", 673),
        ("frclinic_robotlaser_excerpt.clf", "/robotlaser1", 150),
    ];
    for (name, topic, scans) in files {
        let Some(path) = data(name) else { return };
        let mut recording = open(&path).expect("a recording");
        assert_eq!((recording.total_revolutions(), recording.topic()), (Some(scans), topic), "{name}");
        let read = drain(&mut recording);
        assert_eq!((read.len() as u64, recording.losses()), (scans, &[][..]), "{name}");
    }
}

#[test]
fn a_real_table_gives_its_rows_once_its_directions_are_given() {
    let Some(path) = data("corridor_dead_rows.csv") else { return };
    assert!(matches!(open(&path), Err(IngestError::NoGeometry { .. })));
    let mut params = Params::defaults(CSV_PARAMS);
    for (name, value) in [("first_rad", -2.356), ("last_rad", 2.093), ("range_max_m", 5.6)] {
        params.set(name, Value::Float(value)).expect("allowed");
    }
    let options = ReadOptions { csv: CsvGeometry::new(&params), ..ReadOptions::default() };
    let mut recording = Recording::open(&[path], &options, sensor(&[])).expect("a recording");
    let read = drain(&mut recording);
    assert_eq!((read.len(), recording.losses()), (117, &[][..]));
    assert!(read.ranges.iter().all(|ranges| ranges.len() == 726));
}
