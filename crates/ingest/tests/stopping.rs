//! Reading is ended for the whole process: a process of its own, as other tests read too.

use crosscut_ingest::{CSV_PARAMS, CsvGeometry, LossKind, ReadOptions, Recording, stop_reading};
use crosscut_sensor::Sensor;
use crosscut_stage::{Notes, Params, Revolution, Source as _, Value};

#[test]
fn a_reader_that_is_stopped_gives_what_it_has_read() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("rows.csv");
    let row = "1.0,2.0,3.0,4.0,5.0,5.5,2.0,1.0,".repeat(45).trim_end_matches(',').to_owned() + "\n";
    std::fs::write(&path, row.repeat(4000)).expect("written");
    let mut params = Params::defaults(CSV_PARAMS);
    params.set("last_rad", Value::Float(3.0)).expect("allowed");
    let options = ReadOptions { csv: CsvGeometry::new(&params), ..ReadOptions::default() };
    let mut recording = Recording::open(std::slice::from_ref(&path), &options, Sensor::default()).expect("a table");
    let next = |recording: &mut Recording| {
        recording.next(&mut Revolution::default(), &mut Notes::default()).expect("the source goes on")
    };
    assert!(next(&mut recording));
    stop_reading();
    let rest = std::iter::from_fn(|| next(&mut recording).then_some(())).count();
    assert!((99..2000).contains(&rest), "{rest} more: those that were read before");
    let losses = recording.losses();
    assert!(matches!(losses, [loss] if matches!(loss.kind, LossKind::Rest { .. })), "{losses:?}");
    let error = Recording::open(&[path], &options, Sensor::default()).err().expect("nothing can be read");
    assert!(format!("{error:?}").contains("stopped by a signal"), "{error:?}");
}
