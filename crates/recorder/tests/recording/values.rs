//! Every entity of the contract, read back with the values that the frame held.

use std::collections::BTreeSet;

use crosscut_explain::Explanation;
use crosscut_recorder::{Detail, Recorder, Scope};
use crosscut_stage::{Affinity, Beam, Frame, Observer as _, Step, Weights};
use faer::Mat;
use rerun::external::image::GrayImage;
use rerun::{
    AnnotationContext, Arrows3D, BarChart, LineStrips3D, Points3D, RecordingInfo, StateChange, TensorBuffer,
    TextDocument, TextLog, components,
};

use crate::frames;
use crate::reading::{Recording, options, record_of, recorded, times};

const EVERY_REVOLUTION: [&str; 34] = [
    "/scan/returns",
    "/scan/ranges",
    "/scan/seen",
    "/scan/count",
    "/scan/links",
    "/scan/walls",
    "/scan/openings",
    "/affinity/W",
    "/affinity/degrees",
    "/spectral/L",
    "/spectral/eigenvalues",
    "/spectral/tolerance",
    "/spectral/k",
    "/spectral/margin",
    "/spectral/chart/values",
    "/spectral/U",
    "/spectral/embedding",
    "/kmeans/labels",
    "/kmeans/centroids",
    "/kmeans/blocks",
    "/kmeans/profile/lines",
    "/report/junctions",
    "/report/confidence",
    "/report/place",
    "/report/summary",
    "/report/why",
    "/report/labels",
    "/report/walls",
    "/timing/total",
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
    let labels: Vec<components::Text> = recording.at("/scan/openings", Points3D::descriptor_labels(), seq).unwrap();
    assert_eq!((arrows.len(), labels.iter().map(rerun::Text::as_str).collect()), (3, vec!["3.5 m"; 3]));
}

/// Whether the picture is dark but where two beams with a return meet in its upper triangle, and there within half a
/// decade of log10 |m|.
fn assert_draws(picture: &GrayImage, m: &Mat<f64>, frame: &Frame, name: &str) {
    assert_eq!((picture.width(), picture.height()), (384, 384), "{name}");
    let beams = &frame.revolution.sweep.as_ref().expect("a sweep").beams;
    let return_at = |pixel: u32| match beams.get(pixel as usize) {
        Some(Beam::Return(i)) => Some(*i as usize),
        _ => None,
    };
    for (x, y, level) in picture.enumerate_pixels() {
        let value = return_at(y).zip(return_at(x)).filter(|(i, j)| i <= j).map_or(0.0, |(i, j)| m[(i, j)]);
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
        let Some((shape, TensorBuffer::F16(u))) = recording.tensor("/spectral/U", seq) else { panic!("no U") };
        assert_eq!(shape, [n as u64, k as u64]);
        for (at, read) in u.iter().map(|u| u.to_f64()).enumerate() {
            let exact = spectrum.u[(at / k, at % k)];
            // Eleven bits, and a step of 2^-24 near 0.
            assert!((read - exact).abs() <= (exact.abs() / 2048.0).max(3.0e-8), "{read} for {exact}");
        }
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
    assert!((farthest - 1.0).abs() < 0.008);
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
                .all(|(drawn, exact)| (f64::from(*drawn) - exact / reach).abs() <= 0.5 / 128.0 + 1e-6)
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
    assert_eq!([3, 100, 299, 300].map(stored), [32, 101, 300, 300]);
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

#[test]
fn exact_matrices_read_back_to_the_last_bit_at_every_nth_revolution_and_where_the_count_changes() {
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
        let (w, n) = (dense(&frame.affinity), frame.revolution.len());
        let upper: Vec<f64> = (0..n * n).map(|at| if at / n <= at % n { w[(at / n, at % n)] } else { 0.0 }).collect();
        assert_eq!(f64s(&recording, "/affinity/W/exact", seq), (vec![n as u64; 2], upper));
        let (u, k) = (&frame.spectrum.u, frame.spectrum.k);
        let rows: Vec<f64> = (0..n * k).map(|at| u[(at / k, at % k)]).collect();
        assert_eq!(f64s(&recording, "/spectral/U/exact", seq), (vec![n as u64, k as u64], rows));
    }
}

#[test]
fn a_light_recording_has_no_matrix_and_everything_else() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("flight.rrd");
    let scope = Scope { detail: Detail::Light, ..Scope::default() };
    record_of(&path, &(0..3).map(frames::frame).collect::<Vec<_>>(), scope);
    let recording = Recording::read(&path);
    let matrices = ["/affinity/W", "/affinity/degrees", "/spectral/L", "/spectral/U", "/spectral/embedding"];
    for entity in EVERY_REVOLUTION {
        let expected = if matrices.contains(&entity) { 0 } else { 3 };
        assert_eq!(recording.revolutions(entity).len(), expected, "{entity}");
    }
}

#[test]
fn labels_and_walls_read_back_as_in_results_and_walls_name_their_class() {
    let mut frame = frames::frame(2);
    frame.junction.wall_of_return[7] = None;
    let recording = recorded(std::slice::from_ref(&frame));
    let Some((_, TensorBuffer::I32(labels))) = recording.tensor("/report/labels", 2) else { panic!("no labels") };
    let beams = &frame.revolution.sweep.as_ref().unwrap().beams;
    let expected = beams.iter().map(|beam| match beam {
        Beam::Return(i) => frame.junction.wall_of_return[*i as usize].map_or(-2, |wall| wall as i32),
        _ => -1,
    });
    assert!(labels.iter().copied().eq(expected));
    let (shape, walls) = f64s(&recording, "/report/walls", 2);
    assert_eq!(shape, [frame.junction.walls.len() as u64, 6]);
    for (row, wall) in walls.chunks_exact(6).zip(&frame.junction.walls) {
        let [from, to] = wall.bearing_rad;
        assert_eq!(row, [f64::from(wall.id), wall.returns as f64, from, to, 0.0, f64::from(wall.id)]);
    }
}

#[test]
fn the_explanation_is_the_one_of_its_crate_and_the_links_join_the_returns_that_it_names() {
    let frame = frames::frame(4);
    let recording = recorded(std::slice::from_ref(&frame));
    let explanation = Explanation::of(&frame);
    let text = recording.texts("/report/why", TextDocument::descriptor_text(), 4);
    assert!(text[0].starts_with("## k = 3, 3 junctions"), "{}", text[0]);
    let strips: Vec<components::LineStrip3D> =
        recording.at("/scan/links", LineStrips3D::descriptor_strips(), 4).unwrap();
    let weakest = explanation.walls.iter().filter_map(|wall| wall.weakest);
    let links: Vec<_> = weakest.chain(explanation.strongest().map(|(_, link)| link)).collect();
    assert_eq!((strips.len(), links.len()), (4, 4), "one a wall, and one between walls");
    for (strip, link) in strips.iter().zip(links) {
        let ends = link.returns.map(|i| frame.revolution.points_m[i]).map(|p| [p.x as f32, p.y as f32, 0.0]);
        assert_eq!([strip.0[0].0, strip.0[1].0], ends);
    }
}

#[test]
fn a_wall_keeps_its_colour_when_results_number_it_otherwise() {
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
