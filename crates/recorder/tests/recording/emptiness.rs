//! Revolutions with nothing in them, with too much, and failed ones: nothing stale stays behind.

use crosscut_stage::{Failure, FailureCause, Frame, Step};
use rerun::{Clear, Points3D, TensorBuffer, TextLog, components};

use crate::frames;
use crate::reading::{Recording, recorded};

fn is_cleared(recording: &Recording, entity: &str, seq: i64) -> bool {
    recording.at::<components::ClearIsRecursive>(entity, Clear::descriptor_is_recursive(), seq).is_some()
}

/// Whether the picture was replaced by a dark one.
fn is_dark(recording: &Recording, entity: &str, seq: i64) -> bool {
    recording.picture(entity, seq).is_some_and(|picture| picture.pixels().all(|level| level.0 == [0]))
}

fn returns(recording: &Recording, seq: i64) -> Option<usize> {
    Some(recording.at::<components::Position3D>("/scan/returns", Points3D::descriptor_positions(), seq)?.len())
}

#[test]
fn an_empty_revolution_empties_every_view() {
    let recording = recorded(&[frames::frame(0), frames::empty_frame(1)]);
    assert_eq!(returns(&recording, 1), Some(0));
    for entity in ["/scan/walls", "/scan/openings", "/spectral/embedding", "/kmeans/centroids", "/report/summary"] {
        assert!(recording.revolutions(entity).contains(&1), "{entity} is left as it was");
    }
    for picture in ["/affinity/W", "/spectral/L"] {
        assert!(is_dark(&recording, picture, 1) && !is_dark(&recording, picture, 0), "{picture}");
    }
    let Some((shape, TensorBuffer::I32(labels))) = recording.tensor("/kmeans/labels", 1) else { panic!("no labels") };
    assert_eq!((shape, labels.len()), (vec![0], 0));
    let ranges = recording.tensor("/scan/ranges", 1).unwrap();
    assert_eq!(ranges.1, TensorBuffer::F32(vec![f32::INFINITY; frames::BEAMS].into()), "infinite ranges stay so");
    assert_eq!(recording.scalar("/spectral/margin", 1), None);
    assert_eq!(recording.scalar("/spectral/k", 1), Some(0.0));
}

#[test]
fn a_recording_may_be_empty_from_the_start_or_altogether() {
    assert_eq!(returns(&recorded(&[frames::empty_frame(0), frames::frame(1)]), 0), Some(0));
    let nothing = recorded(&[]);
    assert!(nothing.layout_messages > 20);
    assert!(nothing.of("/config").next().is_some());
}

#[test]
fn beyond_1024_returns_the_pictures_are_left_out_and_a_note_says_so() {
    let recording = recorded(&[frames::frame(0), frames::cloud_frame(1, 1025), frames::cloud_frame(2, 1024)]);
    for picture in ["/affinity/W", "/spectral/L"] {
        assert!(is_dark(&recording, picture, 1), "{picture}");
        assert_eq!(recording.picture(picture, 2).map(|p| p.width()), Some(1024));
    }
    let notes = recording.texts("/log", TextLog::descriptor_text(), 1);
    assert!(notes.iter().any(|note| note.contains("1025")), "{notes:?}");
    assert_eq!(returns(&recording, 1), Some(1025));
    assert!(recording.tensor("/scan/ranges", 1).is_none(), "a cloud has no beams");
}

#[test]
fn buffers_used_for_a_larger_revolution_leave_no_trace_in_a_smaller_one() {
    let sizes = [360, 90, 360];
    let frames: Vec<Frame> =
        sizes.iter().enumerate().map(|(seq, &beams)| frames::frame_of(seq as u64, beams)).collect();
    let together = recorded(&frames).content();
    for (seq, frame) in (0..).zip(&frames) {
        let alone = recorded(std::slice::from_ref(frame)).content();
        let told_once = |entity: &str| {
            entity.starts_with("/timing/")
                || [
                    "/log",
                    "/report/axis",
                    "/report/doubt",
                    "/recording/part",
                    "/affinity/absent",
                    "/report/why",
                    "/scan/notes",
                ]
                .contains(&entity)
                || entity.ends_with("/exact")
        };
        for (key, value) in alone.iter().filter(|(key, _)| key.2 == Some(seq) && !told_once(&key.0)) {
            assert!(together.get(key) == Some(value), "{key:?} depends on what was recorded before");
        }
    }
}

#[test]
fn parts_of_a_failed_frame_are_not_recorded_and_the_failure_is() {
    let mut failed = frames::frame(1);
    let cause = FailureCause::Panic("index out of bounds".to_owned());
    failed.failure = Some(Failure { step: Step::Kmeans, seq: 1, cause });
    let recording = recorded(&[frames::frame(0), failed]);
    assert_eq!(returns(&recording, 1), None);
    assert!(is_cleared(&recording, "/scan", 1) && is_dark(&recording, "/affinity/W", 1));
    let text = recording.texts("/log", TextLog::descriptor_text(), 1);
    assert_eq!(text[0], "kmeans failed on revolution 1: it panicked: index out of bounds");
}
