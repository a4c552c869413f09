//! Two recordings compared: the first revolution and step that differ, whatever the chunks.

use std::path::Path;

use crosscut_recorder::Scope;
use crosscut_rrd::{Differences, Recording, differences};
use crosscut_stage::{Frame, Place, Step};
use faer::Mat;

use crate::frames;
use crate::read_back::with_other_chunks;
use crate::reading::{record, record_of};

fn flight() -> Vec<Frame> {
    (0..8).map(frames::frame).collect()
}

/// The undisturbed flight against what `disturb` makes of it.
fn compared(tolerance: f64, disturb: impl Fn(&mut [Frame])) -> Differences {
    let folder = tempfile::tempdir().expect("readable");
    let [a, b] = ["a.rrd", "b.rrd"].map(|name| folder.path().join(name));
    let mut frames = flight();
    record(&a, &frames);
    disturb(&mut frames);
    record(&b, &frames);
    differences(&open(&a), &open(&b), tolerance).expect("readable")
}

fn open(path: &Path) -> Recording {
    Recording::open(path).expect("readable")
}

fn perturb(points: &mut Mat<f64>) {
    points[(0, 0)] += 1e-3;
}

#[test]
fn equal_flights_are_the_same_in_other_chunks_and_at_another_speed() {
    let folder = tempfile::tempdir().unwrap();
    let [a, b] = ["a.rrd", "b.rrd"].map(|name| folder.path().join(name));
    let mut frames = flight();
    record(&a, &frames);
    frames.iter_mut().for_each(|frame| frame.timings.set_ns(Step::Spectral, 77));
    record(&b, &frames);
    let found = differences(&open(&a), &open(&with_other_chunks(&b)), 0.0).unwrap();
    assert_eq!(found.components, []);
    assert!(found.first.is_none() && found.compared > 8 * 20, "{} rows compared", found.compared);
}

#[test]
fn equal_flights_are_the_same_in_one_file_and_in_parts_and_changed_beams_are_told_all_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let [whole, parts] = ["whole.rrd", "parts.rrd"].map(|name| folder.path().join(name));
    let in_parts = Scope { part_revolutions: 3.try_into().unwrap(), ..Scope::default() };
    let mut frames = flight();
    record(&whole, &frames);
    record_of(&parts, &frames, in_parts.clone());
    for pair in [[&whole, &parts], [&parts, &whole]] {
        let found = differences(&open(pair[0]), &open(pair[1]), 0.0).unwrap();
        assert_eq!(found.components, []);
    }
    for frame in &mut frames[5..] {
        frame.revolution.sweep.as_mut().unwrap().wire_geometry[3] += 1.0;
    }
    record_of(&parts, &frames, in_parts);
    let found = differences(&open(&whole), &open(&parts), 0.0).unwrap();
    let wire = found.components.iter().find(|found| found.entity == "/scan/beams/wire").unwrap();
    assert_eq!((wire.revolution, wire.how.as_str()), (5, "by 1.0e0 at most"));
}

#[test]
fn what_a_missing_part_held_is_no_difference() {
    let folder = tempfile::tempdir().unwrap();
    let [a, b] = ["a.rrd", "b.rrd"].map(|name| folder.path().join(name));
    let in_parts = Scope { part_revolutions: 3.try_into().unwrap(), ..Scope::default() };
    record(&a, &flight());
    record_of(&b, &flight(), in_parts);
    std::fs::remove_file(folder.path().join("b-2.rrd")).unwrap();
    let b = open(&b);
    assert!(!b.damages().is_empty());
    assert_eq!(differences(&open(&a), &b, 0.0).unwrap().components, []);
}

#[test]
fn the_first_revolution_and_at_it_the_first_step_are_named() {
    let found = compared(0.0, |frames| {
        frames[3].spectrum.eigenvalues[1] += 1e-13;
        frames[3].partition.labels[0] = None;
        frames[5].revolution.sweep.as_mut().unwrap().ranges_m[100] = 3.0;
    });
    let first = found.first.unwrap();
    assert_eq!((first.revolution, first.step, first.entity.as_str()), (3, Step::Spectral, "/spectral/eigenvalues"));
    let steps: Vec<Step> = found.components.iter().map(|difference| difference.step).collect();
    assert_eq!(steps.first(), Some(&Step::Ingest), "by step");
    assert!(steps.contains(&Step::Kmeans));
}

#[test]
fn each_step_is_told_by_what_it_makes() {
    type Disturb = fn(&mut [Frame]);
    let disturbances: [(Step, Disturb); 5] = [
        (Step::Ingest, |frames| frames[2].revolution.stamp_ns += 1),
        (Step::Affinity, |frames| frames[2].affinity.degrees[0] += 1.0),
        (Step::Spectral, |frames| perturb(&mut frames[2].spectrum.u)),
        (Step::Kmeans, |frames| perturb(&mut frames[2].partition.centroids)),
        (Step::Report, |frames| frames[2].junction.place = Place::Cross),
    ];
    for (step, disturb) in disturbances {
        let first = compared(0.0, disturb).first.unwrap();
        assert_eq!((first.revolution, first.step), (2, step), "{first:?}");
    }
}

/// `m` times a matrix that turns its first two columns by 0.7 rad, with the first one mirrored.
fn turned(m: &Mat<f64>) -> Mat<f64> {
    let (sin, cos) = 0.7_f64.sin_cos();
    let entry = |i: usize, j: usize| match j {
        0 => -(cos * m[(i, 0)] - sin * m[(i, 1)]),
        1 => sin * m[(i, 0)] + cos * m[(i, 1)],
        j => m[(i, j)],
    };
    Mat::from_fn(m.nrows(), m.ncols(), entry)
}

#[test]
fn other_eigenvectors_of_the_same_span_are_no_difference_rounded_as_well_as_exact() {
    let found = compared(1e-12, |frames| {
        for frame in frames {
            frame.spectrum.u = turned(&frame.spectrum.u);
            frame.partition.centroids = turned(&frame.partition.centroids);
        }
    });
    assert_eq!(found.components, []);
    assert!(found.compared > 8 * 20);
}

#[test]
fn another_span_is_a_difference_that_says_so_in_every_precision() {
    let found = compared(1e-12, |frames| perturb(&mut frames[0].spectrum.u));
    let how: Vec<_> = found.components.iter().map(|found| (found.entity.as_str(), found.how.as_str())).collect();
    let entities: Vec<_> = how.iter().map(|(entity, _)| *entity).collect();
    assert_eq!(entities, ["/spectral/U", "/spectral/U/exact"]);
    assert!(how.iter().all(|(_, how)| how.starts_with("the span by ")), "{how:?}");
}

#[test]
fn numbers_within_the_tolerance_are_the_same_and_words_never_are() {
    let disturb =
        |frames: &mut [Frame]| frames[2].junction.confidence = frames[2].junction.confidence.map(|c| c + 1e-6);
    let differing = |tolerance| {
        let found = compared(tolerance, disturb).components.into_iter();
        found.map(|difference| difference.entity).filter(|entity| entity == "/report/confidence").count()
    };
    assert_eq!([differing(0.0), differing(1e-7), differing(1e-5)], [1, 1, 0]);
    let renamed = compared(1e9, |frames| frames[2].junction.place = Place::Cross);
    assert!(renamed.components.iter().any(|difference| difference.entity == "/report/place"));
}

#[test]
fn a_revolution_that_one_lacks_is_a_difference_unless_that_one_was_cut_off_before_it() {
    let folder = tempfile::tempdir().unwrap();
    let [a, b] = ["a.rrd", "b.rrd"].map(|name| folder.path().join(name));
    let scan = |seq: u64| {
        let mut frame = Frame { revolution: frames::frame(seq % 4).revolution, ..Frame::default() };
        (frame.revolution.seq, frame.revolution.stamp_ns) = (seq, frames::stamp_ns(seq));
        frame
    };
    let frames: Vec<Frame> = (0..100).map(scan).collect();
    record(&a, &frames);
    record(&b, &frames[..30]);
    let first = differences(&open(&a), &open(&b), 0.0).unwrap().first.unwrap();
    assert_eq!((first.revolution, first.step, first.how.as_str()), (30, Step::Ingest, "missing in the second"));
    let whole = std::fs::read(&a).unwrap();
    let mut cuts = (1..100).rev().map(|percent| {
        std::fs::write(&b, &whole[..whole.len() * percent / 100]).unwrap();
        open(&b)
    });
    let cut = cuts.find(|cut| cut.entities()["/scan/ranges"].rows < 100).unwrap();
    assert!(!cut.damages().is_empty());
    assert!(differences(&open(&a), &cut, 0.0).unwrap().first.is_none());
}
