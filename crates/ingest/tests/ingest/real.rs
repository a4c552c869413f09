//! Real recordings, where they are at hand.

use std::path::{Path, PathBuf};

use crosscut_ingest::{Found, IngestError, describe};

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
        assert_eq!(recording.total_messages(), Some(scans));
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
    let description = describe(&path, &sensor(&[]), None).expect("a recording");
    let [scans] = &description.topics[..] else { panic!("{:?}", description.topics) };
    let first = scans.first_scan.as_ref().expect("a scan");
    assert_eq!((description.profile.as_str(), first.beams, first.range_m), ("ros2", 726, [0.02, 5.6]));
    // Counted with an independent reader: 293 NaN and 54 below range_min.
    let notes = ["293 beams of range NaN read as no return", "54 beams below range_min 0.02 m left out"];
    assert_eq!((first.returns, &first.notes[..]), (726 - 293 - 54, &notes.map(str::to_owned)[..]));
    assert!(
        (first.field_of_view_rad.to_degrees() - 254.9).abs() < 0.1
            && (scans.rate_hz.expect("a rate") - 10.0).abs() < 1e-9
    );
}

#[test]
fn recordings_of_other_kinds_are_told_apart() {
    let kinds = [
        ("corridor_ros1.bag", Found::Ros1Bag),
        ("corridor_dead_rows.csv", Found::Table),
        ("aces_excerpt.clf", Found::Carmen),
        ("intel_excerpt.clf", Found::Carmen),
        ("frclinic_robotlaser_excerpt.clf", Found::Carmen),
    ];
    for (name, kind) in kinds {
        let Some(path) = data(name) else { return };
        match open(&path) {
            Err(IngestError::NotMcap { found, .. }) => assert_eq!(found, kind, "{name}"),
            other => panic!("{name}: {:?}", other.err()),
        }
    }
}
