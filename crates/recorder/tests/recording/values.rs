//! Every entity of the contract, read back with the values that the frame held.

use std::collections::BTreeSet;

use crosscut_recorder::Recorder;
use crosscut_stage::{Affinity, Beam, Frame, Observer as _, Step, Weights};
use faer::Mat;
use rerun::external::image::GrayImage;
use rerun::{
    AnnotationContext, Arrows3D, BarChart, LineStrips3D, Points3D, RecordingInfo, StateChange, TensorBuffer,
    TextDocument, TextLog, components,
};

use crate::frames;
use crate::reading::{Recording, options, recorded, times};

const EVERY_REVOLUTION: [&str; 27] = [
    "/scan/returns",
    "/scan/ranges",
    "/scan/seen",
    "/scan/walls",
    "/scan/openings",
    "/affinity/W",
    "/affinity/degrees",
    "/spectral/L",
    "/spectral/eigenvalues",
    "/spectral/tolerance",
    "/spectral/k",
    "/spectral/margin",
    "/spectral/chart/columns",
    "/spectral/chart/tolerance",
    "/spectral/U",
    "/spectral/embedding",
    "/kmeans/labels",
    "/kmeans/centroids",
    "/report/junctions",
    "/report/confidence",
    "/report/place",
    "/report/summary",
    "/timing/ingest",
    "/timing/affinity",
    "/timing/spectral",
    "/timing/kmeans",
    "/timing/report",
];

fn flight() -> (Vec<Frame>, Recording) {
    let frames: Vec<Frame> = (7..10).map(frames::frame).collect();
    let recording = recorded(&frames);
    (frames, recording)
}

fn f64s(recording: &Recording, entity: &str, seq: i64) -> (Vec<u64>, Vec<f64>) {
    match recording.tensor(entity, seq) {
        Some((shape, TensorBuffer::F64(values))) => (shape, values.to_vec()),
        other => panic!("{entity} at {seq}: {other:?}"),
    }
}

fn f32s(recording: &Recording, entity: &str, seq: i64) -> (Vec<u64>, Vec<f32>) {
    match recording.tensor(entity, seq) {
        Some((shape, TensorBuffer::F32(values))) => (shape, values.to_vec()),
        other => panic!("{entity} at {seq}: {other:?}"),
    }
}

#[test]
fn every_entity_is_there_at_every_revolution_on_both_timelines_and_on_no_other() {
    let (frames, recording) = flight();
    let seqs: BTreeSet<i64> = frames.iter().map(|f| f.revolution.seq as i64).collect();
    let stamps: BTreeSet<i64> = frames.iter().map(|f| f.revolution.stamp_ns as i64).collect();
    for entity in EVERY_REVOLUTION {
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
fn what_holds_for_the_whole_recording_is_static_and_a_layout_goes_with_it() {
    let (_, recording) = flight();
    let text = |entity: &str| -> String {
        let chunk = recording.of(entity).find(|chunk| chunk.is_static()).unwrap();
        let text: Vec<components::Text> =
            chunk.component_batch(TextDocument::descriptor_text().component, 0).unwrap().unwrap();
        text[0].to_string()
    };
    assert_eq!(text("/config"), "[affinity]\nkind = \"rbf\"\n");
    assert!(text("/about").contains("Quantised"));
    let root = recording.of("/").find(|chunk| chunk.is_static()).unwrap();
    let classes: Vec<components::AnnotationContext> =
        root.component_batch(AnnotationContext::descriptor_context().component, 0).unwrap().unwrap();
    assert!(classes[0].0.iter().any(|class| class.class_id.0 == u16::MAX), "returns of no wall have a colour");
    assert!(recording.layout_messages > 20);
}

#[test]
fn a_recording_starts_at_the_first_stamp_and_not_when_it_was_made() {
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
fn the_scan_reads_back() {
    let (frames, recording) = flight();
    for frame in &frames {
        let (seq, revolution) = (frame.revolution.seq as i64, &frame.revolution);
        let sweep = revolution.sweep.as_ref().unwrap();
        assert_eq!(f32s(&recording, "/scan/ranges", seq), (vec![360], sweep.ranges_m.clone()));
        let positions: Vec<components::Position3D> =
            recording.at("/scan/returns", Points3D::descriptor_positions(), seq).unwrap();
        let expected = revolution.points_m.iter().map(|p| [p.x as f32, p.y as f32, p.z as f32]);
        assert!(positions.iter().map(|p| p.0.0).eq(expected));
        let classes: Vec<components::ClassId> =
            recording.at("/scan/returns", Points3D::descriptor_class_ids(), seq).unwrap();
        assert!(classes.iter().map(|c| Some(u32::from(c.0.0))).eq(frame.junction.wall_of_return.iter().copied()));
        let Some((_, TensorBuffer::U8(seen))) = recording.tensor("/scan/seen", seq) else { panic!("no /scan/seen") };
        let expected = sweep.beams.iter().map(|beam| if matches!(beam, Beam::Return(_)) { 2 } else { 1 });
        assert!(seen.iter().copied().eq(expected));
    }
}

#[test]
fn the_beams_are_logged_once_and_again_only_when_they_change() {
    let mut frames: Vec<Frame> = (0..4).map(frames::frame).collect();
    frames[2].revolution.sweep.as_mut().unwrap().wire_geometry[3] = 20.0;
    frames[3].revolution.sweep.as_mut().unwrap().wire_geometry[3] = 20.0;
    let recording = recorded(&frames);
    assert_eq!(recording.revolutions("/scan/beams"), BTreeSet::from([0, 2]));
    let bearings = &frames[0].revolution.sweep.as_ref().unwrap().bearings_rad;
    assert_eq!(f64s(&recording, "/scan/beams", 0), (vec![360], bearings.clone()));
    assert_eq!(f32s(&recording, "/scan/beams/wire", 2).1[3], 20.0);
}

#[test]
fn walls_pass_their_returns_and_openings_keep_bearing_and_width() {
    let (frames, recording) = flight();
    let (frame, seq) = (&frames[0], 7);
    let strips: Vec<components::LineStrip3D> =
        recording.at("/scan/walls", LineStrips3D::descriptor_strips(), seq).unwrap();
    let classes: Vec<components::ClassId> =
        recording.at("/scan/walls", LineStrips3D::descriptor_class_ids(), seq).unwrap();
    assert_eq!(strips.len(), classes.len());
    assert_eq!(classes.iter().map(|class| class.0.0).collect::<BTreeSet<_>>(), BTreeSet::from([0, 1, 2]));
    for point in strips.iter().flat_map(|strip| strip.0.iter()) {
        let is_a_return = |p: &crosscut_stage::Point| [p.x as f32, p.y as f32, p.z as f32] == point.0;
        assert!(frame.revolution.points_m.iter().any(is_a_return));
    }
    let expected = frame.junction.openings.iter().flat_map(|o| [o.bearing_rad, o.width_m]).collect();
    assert_eq!(f64s(&recording, "/scan/openings", seq), (vec![3, 2], expected));
    let arrows: Vec<components::Vector3D> =
        recording.at("/scan/openings", Arrows3D::descriptor_vectors(), seq).unwrap();
    let labels: Vec<components::Text> = recording.at("/scan/openings", LineStrips3D::descriptor_labels(), seq).unwrap();
    assert_eq!((arrows.len(), labels.iter().map(rerun::Text::as_str).collect()), (3, vec!["3.5 m"; 3]));
}

/// Whether the picture is dark but where two beams with a return meet, and there within half a decade of log10 |m|.
fn assert_draws(picture: &GrayImage, m: &Mat<f64>, frame: &Frame, name: &str) {
    assert_eq!((picture.width(), picture.height()), (384, 384), "{name}");
    let beams = &frame.revolution.sweep.as_ref().expect("a sweep").beams;
    let return_at = |pixel: u32| match beams.get(pixel as usize) {
        Some(Beam::Return(i)) => Some(*i as usize),
        _ => None,
    };
    for (x, y, level) in picture.enumerate_pixels() {
        let value = return_at(y).zip(return_at(x)).map_or(0.0, |(i, j)| m[(i, j)]);
        let (level, decades) = (f64::from(level.0[0]), value.abs().log10());
        let right = if decades <= -16.0 { level == 0.0 } else { (level - 16.0 - decades).abs() <= 0.501 };
        assert!(right, "{name} at row {y}, column {x}: level {level} for 1e{decades}");
    }
}

fn dense(affinity: &Affinity) -> Mat<f64> {
    let mut w = Mat::zeros(affinity.weights.n(), affinity.weights.n());
    affinity.weights.for_each(|i, j, value| w[(i, j)] = value);
    w
}

#[test]
fn pictures_of_w_and_l_are_right_to_half_a_decade() {
    let (frames, recording) = flight();
    for frame in &frames {
        let seq = frame.revolution.seq as i64;
        assert_draws(&recording.picture("/affinity/W", seq).unwrap(), &dense(&frame.affinity), frame, "W");
        assert_draws(&recording.picture("/spectral/L", seq).unwrap(), &frames::laplacian(&frame.affinity), frame, "L");
        let degrees: Vec<f32> = frame.affinity.degrees.iter().map(|&d| d as f32).collect();
        assert_eq!(f32s(&recording, "/affinity/degrees", seq).1, degrees);
    }
}

#[test]
fn a_return_that_is_nearly_alone_shows_its_leak_on_the_diagonal_of_l() {
    let mut frame = frames::frame(0);
    let mut w = dense(&frame.affinity);
    for j in 1..w.ncols() {
        let leak = if j == 1 { 1e-9 } else { 0.0 };
        (w[(0, j)], w[(j, 0)]) = (leak, leak);
    }
    frame.affinity.degrees = w.row_iter().map(|row| row.iter().sum()).collect();
    frame.affinity.weights = Weights::Dense(w);
    let recording = recorded(std::slice::from_ref(&frame));
    assert_draws(&recording.picture("/spectral/L", 0).unwrap(), &frames::laplacian(&frame.affinity), &frame, "L");
}

#[test]
fn a_sparse_w_is_drawn_like_the_dense_matrix_that_it_stands_for() {
    let mut frame = frames::frame(3);
    let full = dense(&frame.affinity);
    let sparse = frame.affinity.weights.make_sparse();
    for i in 0..full.nrows() {
        for j in (0..full.ncols()).filter(|&j| full[(i, j)] > 1e-6) {
            sparse.push(j as u32, full[(i, j)]);
        }
        sparse.end_row();
    }
    assert!(matches!(frame.affinity.weights, Weights::Sparse(_)));
    let recording = recorded(std::slice::from_ref(&frame));
    assert_draws(&recording.picture("/affinity/W", 3).unwrap(), &dense(&frame.affinity), &frame, "sparse W");
    assert_draws(
        &recording.picture("/spectral/L", 3).unwrap(),
        &frames::laplacian(&frame.affinity),
        &frame,
        "L of sparse W",
    );
}

#[test]
fn the_spectrum_reads_back() {
    let (frames, recording) = flight();
    for frame in &frames {
        let (seq, spectrum) = (frame.revolution.seq as i64, &frame.spectrum);
        let values: Vec<components::TensorData> =
            recording.at("/spectral/eigenvalues", BarChart::descriptor_values(), seq).unwrap();
        assert_eq!(values[0].0.buffer, TensorBuffer::F64(spectrum.eigenvalues.clone().into()));
        assert_eq!(recording.scalar("/spectral/tolerance", seq), Some(spectrum.tolerance));
        assert_eq!(recording.scalar("/spectral/k", seq), Some(spectrum.k as f64));
        assert_eq!(recording.scalar("/spectral/margin", seq), spectrum.margin_decades);
        let (n, k) = (spectrum.u.nrows(), spectrum.u.ncols());
        let u: Vec<f32> = (0..n * k).map(|at| spectrum.u[(at / k, at % k)] as f32).collect();
        assert_eq!(f32s(&recording, "/spectral/U", seq), (vec![n as u64, k as u64], u));
    }
}

#[test]
fn the_embedding_is_u_scaled_to_reach_one_and_the_centroids_lie_in_it() {
    let frame = frames::frame(0);
    let recording = recorded(std::slice::from_ref(&frame));
    let points = |entity: &str| -> Vec<components::Position3D> {
        recording.at(entity, Points3D::descriptor_positions(), 0).unwrap()
    };
    let norm = |p: &components::Position3D| p.0.0.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>().sqrt();
    let (embedding, centroids) = (points("/spectral/embedding"), points("/kmeans/centroids"));
    let farthest = embedding.iter().map(norm).fold(0.0, f64::max);
    assert!((farthest - 1.0).abs() < 0.004);
    let (u, c) = (&frame.spectrum.u, &frame.partition.centroids);
    let row_norm = |i: usize| (0..3).map(|j| u[(i, j)].powi(2)).sum::<f64>().sqrt();
    let reach = (0..u.nrows()).map(row_norm).fold(0.0, f64::max);
    for (drawn, exact) in
        [(embedding[5].0.0, [0, 1, 2].map(|j| u[(5, j)])), (centroids[1].0.0, [0, 1, 2].map(|j| c[(1, j)]))]
    {
        assert!(
            drawn
                .iter()
                .zip(exact)
                .all(|(drawn, exact)| (f64::from(*drawn) - exact / reach).abs() <= 0.5 / 256.0 + 1e-6)
        );
    }
}

#[test]
fn an_embedding_of_one_column_lies_on_the_first_axis() {
    let mut frame = frames::frame(0);
    let n = frame.revolution.len();
    frame.spectrum.u = Mat::from_fn(n, 1, |i, _| (i + 1) as f64).into();
    let recording = recorded(&[frame]);
    let points: Vec<components::Position3D> =
        recording.at("/spectral/embedding", Points3D::descriptor_positions(), 0).unwrap();
    assert_eq!(points[n - 1].0.0, [1.0, 0.0, 0.0]);
}

#[test]
fn of_many_eigenvalues_the_smallest_are_kept_and_always_the_zeros_and_the_next() {
    let stored = |k: usize| -> usize {
        let mut frame = frames::frame(0);
        frame.spectrum.eigenvalues = (0..300).map(f64::from).collect();
        frame.spectrum.k = k;
        let recording = recorded(&[frame]);
        let values: Vec<components::TensorData> =
            recording.at("/spectral/eigenvalues", BarChart::descriptor_values(), 0).unwrap();
        values[0].0.shape[0] as usize
    };
    assert_eq!([3, 100, 299, 300].map(stored), [64, 101, 300, 300]);
}

#[test]
fn the_partition_reads_back() {
    let mut frame = frames::frame(1);
    frame.partition.labels[4] = None;
    let recording = recorded(std::slice::from_ref(&frame));
    let Some((_, TensorBuffer::I32(labels))) = recording.tensor("/kmeans/labels", 1) else { panic!("no labels") };
    let expected = frame.partition.labels.iter().map(|label| label.map_or(-1, |l| l as i32));
    assert!(labels.iter().copied().eq(expected));
    let centroids = &frame.partition.centroids;
    let rows = (0..centroids.nrows()).flat_map(|c| (0..centroids.ncols()).map(move |j| centroids[(c, j)])).collect();
    let shape = vec![centroids.nrows() as u64, centroids.ncols() as u64];
    assert_eq!(f64s(&recording, "/kmeans/centroids", 1), (shape, rows));
}

#[test]
fn the_answer_notes_and_timings_read_back() {
    let mut frame = frames::frame(2);
    frame.notes.add("3 beams masked");
    let recording = recorded(std::slice::from_ref(&frame));
    assert_eq!(recording.scalar("/report/junctions", 2), Some(3.0));
    assert_eq!(recording.scalar("/report/confidence", 2), Some(0.97));
    let place: Vec<components::Text> = recording.at("/report/place", StateChange::descriptor_state(), 2).unwrap();
    assert_eq!(place[0].as_str(), "tee");
    let summary: Vec<components::Text> = recording.at("/report/summary", TextDocument::descriptor_text(), 2).unwrap();
    assert!(summary[0].starts_with("# 3 junctions · tee"), "{}", summary[0].as_str());
    let note: Vec<components::Text> = recording.at("/log", TextLog::descriptor_text(), 2).unwrap();
    assert_eq!(note[0].as_str(), "3 beams masked");
    for step in Step::ALL {
        let ms = recording.scalar(&format!("/timing/{step}"), 2).unwrap();
        assert_eq!(ms, frame.timings.ns(step) as f64 * 1e-6, "{step}");
    }
}
