//! Claims of answers that their own returns contradict, in real recordings, which are not part of the repository.

use std::path::Path;

use crosscut_detector::{Preset, Settings};
use crosscut_ingest::{ReadOptions, Recording};
use crosscut_lab::contradictions;
use crosscut_report::{VEHICLE_PARAMS, VEHICLE_WIDTH_M};
use crosscut_sensor::Sensor;
use crosscut_stage::{Frame, Params, Source as _};

#[test]
fn no_answer_in_corridors_contradicts_its_own_returns() {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data");
    let width_m = Params::defaults(VEHICLE_PARAMS).get(VEHICLE_WIDTH_M);
    let mut engine = Settings::new(Preset::Default).engine().expect("preset");
    let mut found: Vec<String> = Vec::new();
    for name in ["cross", "threeway", "dead", "left"] {
        let path = data.join(format!("corridor_{name}.mcap"));
        if !path.is_file() {
            println!("skipped: there is no {}", path.display());
            continue;
        }
        let mut recording = Recording::open(&[path], &ReadOptions::default(), Sensor::default()).expect("a recording");
        let mut frame = Frame::default();
        for scan in 0.. {
            if !recording.next(&mut frame.revolution, &mut frame.notes).expect("readable") {
                break;
            }
            engine.process(&mut frame).expect("processed");
            frame.notes.clear();
            found.extend(contradictions(&frame, width_m).iter().map(|one| format!("{name} {scan}: {one}")));
        }
    }
    assert!(found.is_empty(), "{found:#?}");
}
