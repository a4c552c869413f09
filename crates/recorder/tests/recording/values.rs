//! Values read back with Rerun's own types, and what they are in special cases; `every_entity` goes through all of
//! them.

use std::collections::BTreeSet;

use crosscut_explain::Explanation;
use crosscut_stage::NoteCode::N101;
use crosscut_stage::{Beam, Frame, Step, Weights};
use faer::Mat;
use rerun::external::image::GrayImage;
use rerun::{
    Arrows3D, BarChart, LineStrips2D, LineStrips3D, Points3D, StateChange, TensorBuffer, TextDocument, TextLog,
    components,
};

use crate::frames;
use crate::reading::{Recording, recorded};

fn flight() -> (Vec<Frame>, Recording) {
    let frames: Vec<Frame> = (7..10).map(frames::frame).collect();
    let recording = recorded(&frames);
    (frames, recording)
}

#[test]
fn the_scan_reads_back() {
    let (frames, recording) = flight();
    for frame in &frames {
        let (seq, revolution) = (frame.revolution.seq as i64, &frame.revolution);
        let sweep = revolution.sweep.as_ref().unwrap();
        assert_eq!(recording.f32s("/scan/ranges", seq), (vec![360], sweep.ranges_m.clone()));
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
fn the_chart_by_beam_is_as_wide_as_the_beams_also_where_the_pictures_are_by_return() {
    let frame = frames::frame_of(7, 1440);
    let beams = &frame.revolution.sweep.as_ref().unwrap().beams;
    let last = beams.iter().rposition(|beam| matches!(beam, Beam::Return(_))).unwrap();
    let strips: Vec<components::LineStrip2D> =
        recorded(&[frame]).at("/kmeans/profile/lines", LineStrips2D::descriptor_strips(), 7).unwrap();
    let right = strips.iter().flat_map(|strip| &strip.0).map(|vertex| vertex.0[0]).fold(0.0, f32::max);
    assert!((right - 100.0 * (last + 1) as f32 / 1440.0).abs() < 0.01, "the last return is at beam {last}: {right}");
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
    assert_eq!(recording.f64s("/scan/openings", seq), (vec![3, 2], expected));
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

#[test]
fn pictures_of_w_and_l_are_right_to_half_a_decade() {
    let (frames, recording) = flight();
    for frame in &frames {
        let seq = frame.revolution.seq as i64;
        assert_draws(&recording.picture("/affinity/W", seq).unwrap(), &frames::dense(&frame.affinity), frame, "W");
        assert_draws(&recording.picture("/spectral/L", seq).unwrap(), &frames::laplacian(&frame.affinity), frame, "L");
        let degrees: Vec<f32> = frame.affinity.degrees.iter().map(|&d| d as f32).collect();
        assert_eq!(recording.f32s("/affinity/degrees", seq).1, degrees);
    }
}

#[test]
fn a_return_that_is_nearly_alone_shows_its_leak_on_the_diagonal_of_l() {
    let mut frame = frames::frame(0);
    let mut w = frames::dense(&frame.affinity);
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
    frames::make_sparse(&mut frame.affinity);
    assert!(matches!(frame.affinity.weights, Weights::Sparse(_)));
    let recording = recorded(std::slice::from_ref(&frame));
    assert_draws(&recording.picture("/affinity/W", 3).unwrap(), &frames::dense(&frame.affinity), &frame, "sparse W");
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
    frame.spectrum.u = Mat::from_fn(n, 1, |i, _| (i + 1) as f64);
    let recording = recorded(&[frame]);
    let points: Vec<components::Position3D> =
        recording.at("/spectral/embedding", Points3D::descriptor_positions(), 0).unwrap();
    assert_eq!(points[n - 1].0.0, [1.0, 0.0, 0.0]);
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
    assert_eq!(recording.f64s("/kmeans/centroids", 1), (shape, rows));
}

#[test]
fn the_answer_notes_and_timings_read_back() {
    let mut frame = frames::frame(2);
    frame.notes.add(N101, "3 beams masked");
    let recording = recorded(std::slice::from_ref(&frame));
    assert_eq!(recording.scalar("/report/junctions", 2), Some(3.0));
    assert_eq!(recording.scalar("/report/confidence", 2), Some(0.97));
    let place: Vec<components::Text> = recording.at("/report/place", StateChange::descriptor_state(), 2).unwrap();
    assert_eq!(place[0].as_str(), "tee");
    let summary: Vec<components::Text> = recording.at("/report/summary", TextDocument::descriptor_text(), 2).unwrap();
    assert!(summary[0].starts_with("# 3 walls · tee"), "{}", summary[0].as_str());
    let note: Vec<components::Text> = recording.at("/log", TextLog::descriptor_text(), 2).unwrap();
    assert_eq!(note[0].as_str(), "3 beams masked");
    for step in Step::ALL {
        let ms = recording.scalar(&format!("/timing/{step}"), 2).unwrap();
        assert_eq!(ms, frame.timings.ns(step) as f64 * 1e-6, "{step}");
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
    let (shape, walls) = recording.f64s("/report/walls", 2);
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
    assert!(text[0].starts_with("## 3 walls."), "{}", text[0]);
    let strips: Vec<components::LineStrip3D> =
        recording.at("/scan/links", LineStrips3D::descriptor_strips(), 4).unwrap();
    let named = explanation.nearest.as_ref().expect("walls that are near each other").returns;
    let ends = named.map(|i| frame.revolution.points_m[i]).map(|p| [p.x as f32, p.y as f32, 0.0]);
    assert_eq!([strips[0].0[0].0, strips[0].0[1].0], ends, "what the sentence names is drawn first");
}
