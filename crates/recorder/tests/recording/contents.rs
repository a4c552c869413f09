//! What is in a recording, and when: every entity at its revolutions, the entities that are written once, and those of
//! some revolutions only.

use std::collections::BTreeSet;

use crosscut_recorder::schema::{ENTITIES, When};
use crosscut_recorder::{Detail, Recorder, Scope};
use crosscut_stage::{Frame, Observer as _};
use rerun::{AnnotationContext, BarChart, Points3D, RecordingInfo, TextDocument, components};

use crate::frames;
use crate::reading::{Recording, options, record_of, recorded, times};

/// The paths of the entities that are written then.
fn written(when: When) -> impl Iterator<Item = &'static str> {
    // Edges are drawn of a sparse W alone.
    let entities = ENTITIES.iter().filter(move |entity| entity.when == when && entity.path != "/affinity/links");
    entities.map(|entity| entity.path)
}

fn flight() -> (Vec<Frame>, Recording) {
    let frames: Vec<Frame> = (7..10).map(frames::frame).collect();
    let recording = recorded(&frames);
    (frames, recording)
}

#[test]
fn every_entity_is_there_at_every_revolution_on_both_timelines() {
    let (frames, recording) = flight();
    let seqs: BTreeSet<i64> = frames.iter().map(|f| f.revolution.seq as i64).collect();
    let stamps: BTreeSet<i64> = frames.iter().map(|f| f.revolution.stamp_ns as i64).collect();
    for entity in written(When::Revolution).chain(written(When::Matrices)) {
        assert_eq!(recording.revolutions(entity), seqs, "{entity}");
        let found: BTreeSet<i64> = recording.of(entity).flat_map(|chunk| times(chunk, "stamp")).collect();
        assert_eq!(found, stamps, "{entity}");
    }
    for chunk in &recording.chunks {
        let names: BTreeSet<&str> = chunk.timelines().keys().map(rerun::TimelineName::as_str).collect();
        assert!(chunk.is_static() || names == BTreeSet::from(["revolution", "stamp"]), "{}", chunk.entity_path());
    }
}

#[test]
fn configuration_texts_colours_and_layout_are_there_once() {
    let (_, recording) = flight();
    let text = |entity: &str| -> String {
        let chunk = recording.of(entity).find(|chunk| chunk.is_static()).unwrap();
        let text: Vec<components::Text> =
            chunk.component_batch(TextDocument::descriptor_text().component, 0).unwrap().unwrap();
        text[0].to_string()
    };
    assert_eq!(text("/config"), "[affinity]\nkind = \"rbf\"\n");
    for entity in ENTITIES {
        assert!(text("/about").contains(&format!("| `{}` | {}", entity.path, entity.what)), "{}", entity.path);
    }
    let root = recording.of("/").find(|chunk| chunk.is_static()).unwrap();
    let classes: Vec<components::AnnotationContext> =
        root.component_batch(AnnotationContext::descriptor_context().component, 0).unwrap().unwrap();
    assert!(classes[0].0.iter().any(|class| class.class_id.0 == u16::MAX), "returns of no wall have a colour");
    assert!(recording.layout_messages > 20);
}

#[test]
fn a_recording_starts_at_the_first_stamp() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("flight.rrd");
    let mut recorder = Recorder::new(options(&path)).unwrap();
    recorder.observe(&frames::frame(5)).unwrap();
    recorder.finish().unwrap();
    let recording = Recording::read(&path);
    let start = RecordingInfo::descriptor_start_time().component;
    let starts = recording.chunks.iter().filter_map(|chunk| chunk.component_batch::<components::Timestamp>(start, 0));
    assert_eq!(starts.last().unwrap().unwrap()[0].0.0, frames::stamp_ns(5) as i64);
}

#[test]
fn the_beams_are_logged_when_they_change() {
    let mut frames: Vec<Frame> = (0..4).map(frames::frame).collect();
    frames[2].revolution.sweep.as_mut().unwrap().wire_geometry[3] = 20.0;
    frames[3].revolution.sweep.as_mut().unwrap().wire_geometry[3] = 20.0;
    let recording = recorded(&frames);
    assert_eq!(recording.revolutions("/scan/beams"), BTreeSet::from([0, 2]));
    let bearings = &frames[0].revolution.sweep.as_ref().unwrap().bearings_rad;
    assert_eq!(recording.f64s("/scan/beams", 0), (vec![360], bearings.clone()));
    assert_eq!(recording.f32s("/scan/beams/wire", 2).1[3], 20.0);
}

#[test]
fn the_smallest_eigenvalues_and_all_zeros_and_the_next_are_kept() {
    let stored = |k: usize| -> usize {
        let mut frame = frames::frame(0);
        frame.spectrum.eigenvalues = (0..300).map(f64::from).collect();
        frame.spectrum.k = k;
        let recording = recorded(&[frame]);
        let values: Vec<components::TensorData> =
            recording.at("/spectral/eigenvalues", BarChart::descriptor_values(), 0).unwrap();
        values[0].0.shape[0] as usize
    };
    assert_eq!([3, 100, 299, 300].map(stored), [32, 101, 300, 300]);
}

#[test]
fn exact_matrices_read_back_to_the_last_bit() {
    let mut frames: Vec<Frame> = (0..6).map(frames::frame).collect();
    frames[4].junction.junctions = 4;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("flight.rrd");
    let scope = Scope { exact_every: std::num::NonZeroU64::new(3), ..Scope::default() };
    record_of(&path, &frames, scope);
    let recording = Recording::read(&path);
    assert_eq!(recording.revolutions("/affinity/W/exact"), BTreeSet::from([0, 3, 4, 5]));
    for seq in [0, 3, 4, 5] {
        let frame = &frames[seq as usize];
        let (w, n) = (frames::dense(&frame.affinity), frame.revolution.len());
        let upper: Vec<f64> = (0..n * n).map(|at| if at / n <= at % n { w[(at / n, at % n)] } else { 0.0 }).collect();
        assert_eq!(recording.f64s("/affinity/W/exact", seq), (vec![n as u64; 2], upper));
        let (u, k) = (&frame.spectrum.u, frame.spectrum.k);
        let rows: Vec<f64> = (0..n * k).map(|at| u[(at / k, at % k)]).collect();
        assert_eq!(recording.f64s("/spectral/U/exact", seq), (vec![n as u64, k as u64], rows));
    }
}

#[test]
fn a_light_recording_has_everything_but_matrices() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("flight.rrd");
    let scope = Scope { detail: Detail::Light, ..Scope::default() };
    record_of(&path, &(0..3).map(frames::frame).collect::<Vec<_>>(), scope);
    let recording = Recording::read(&path);
    for (when, expected) in [(When::Revolution, 3), (When::Matrices, 0), (When::Sampled, 0)] {
        for entity in written(when) {
            assert_eq!(recording.revolutions(entity).len(), expected, "{entity}");
        }
    }
}

#[test]
fn a_renumbered_wall_keeps_its_colour() {
    let mut frames: Vec<Frame> = (0..2).map(frames::frame).collect();
    for wall in frames[1].junction.wall_of_return.iter_mut().flatten() {
        *wall = 2 - *wall;
    }
    let recording = recorded(&frames);
    let classes = |seq: i64| -> Vec<u16> {
        let classes: Vec<components::ClassId> =
            recording.at("/scan/returns", Points3D::descriptor_class_ids(), seq).unwrap();
        classes.iter().map(|class| class.0.0).collect()
    };
    for (seq, number) in [(0, 0), (1, 2)] {
        let wall_of = &frames[seq as usize].junction.wall_of_return;
        let first = wall_of.iter().position(|wall| *wall == Some(number)).unwrap();
        assert_eq!(classes(seq)[first], 0, "the wall to the right at revolution {seq}");
    }
}
