//! What no answer may claim, whatever is there: no label is needed.

use crosscut_detector::{Preset, Settings};
use crosscut_evaluate::{Contradiction, contradictions};
use crosscut_ingest::{ReadOptions, Recording};
use crosscut_report::{VEHICLE_PARAMS, VEHICLE_WIDTH_M};
use crosscut_sensor::Sensor;
use crosscut_stage::{Frame, Params, Source as _};

use crate::{CORRIDORS, data};

pub(crate) fn no_answer_contradicts_its_own_returns() {
    let width_m = Params::defaults(VEHICLE_PARAMS).get(VEHICLE_WIDTH_M);
    let mut engine = Settings::new(Preset::Default).engine().expect("preset");
    let mut found: Vec<String> = Vec::new();
    for (file, _) in CORRIDORS {
        let mut recording =
            Recording::open(&[data(file)], &ReadOptions::default(), Sensor::default()).expect("a recording");
        let mut frame = Frame::default();
        for scan in 0.. {
            if !recording.next(&mut frame.revolution, &mut frame.notes).expect("readable") {
                break;
            }
            engine.process(&mut frame).expect("processed");
            frame.notes.clear();
            let all = contradictions(&frame, width_m);
            found.extend(all.iter().map(|one: &Contradiction| format!("{file} {scan}: {one}")));
        }
    }
    assert!(found.is_empty(), "{found:#?}");
}
