//! What a scan is answered does not depend on how its message lists the beams, nor on left and right.

use std::collections::BTreeMap;

use crosscut_detector::Engine;
use crosscut_simulator::suites;
use crosscut_stage::{Frame, Revolution};

use crate::scenes::{engine, looking, scans};

/// One scan in this many is taken.
const SCENES_STEP: usize = 3;

/// What may not change.
#[derive(Debug, PartialEq)]
struct Answer {
    k: usize,
    junctions: usize,
    openings: usize,
    /// In millionths.
    confidence: u32,
    /// Of each beam as it was first listed: walls are numbered as they come, and may be islands.
    walls: Vec<Option<(usize, bool)>>,
}

/// The answer to a scan of which the beams are listed in this order.
fn answer(engine: &mut Engine, scan: &Revolution, order: &[usize], mirrored: bool) -> Answer {
    let of = scan.sweep.as_ref().expect("beams");
    let sign = if mirrored { -1.0 } else { 1.0 };
    let seen = order.iter().map(|&beam| (sign * of.bearings_rad[beam], of.beams[beam]));
    let mut revolution = looking(scan, seen, of.full_turn);
    revolution.points_m.iter_mut().for_each(|point| point.y *= sign);
    let mut frame = Frame { revolution, ..Frame::default() };
    engine.process(&mut frame).expect("a sound scan");
    let mut label_of_beam = vec![Frame::NO_RETURN; order.len()];
    order.iter().zip(frame.labels()).for_each(|(&beam, label)| label_of_beam[beam] = label);
    let junction = frame.junction;
    let mut numbers = BTreeMap::new();
    let wall_of = |label: i32| {
        let wall = junction.walls.get(usize::try_from(label).ok()?)?;
        let next = numbers.len();
        Some((*numbers.entry(label).or_insert(next), wall.island))
    };
    Answer {
        k: frame.spectrum.k,
        junctions: junction.junctions,
        openings: junction.openings.len(),
        confidence: (1e6 * junction.confidence.expect("a kind of the program")).round() as u32,
        walls: label_of_beam.into_iter().map(wall_of).collect(),
    }
}

#[test]
fn neither_the_order_of_the_beams_nor_left_and_right_changes_an_answer() {
    let mut engine = engine(&[]);
    for (name, scan) in suites().iter().flat_map(|suite| scans(suite, SCENES_STEP)) {
        let of = scan.sweep.as_ref().expect("beams");
        let listed: Vec<usize> = (0..of.len()).collect();
        let clockwise: Vec<usize> = listed.iter().rev().copied().collect();
        let mut elsewhere = listed.clone();
        elsewhere.rotate_left(if of.full_turn { of.len() / 3 } else { 0 });
        let expected = answer(&mut engine, &scan, &listed, false);
        assert_eq!(answer(&mut engine, &scan, &elsewhere, false), expected, "{name}, from another beam on");
        assert_eq!(answer(&mut engine, &scan, &clockwise, false), expected, "{name}, listed clockwise");
        assert_eq!(answer(&mut engine, &scan, &clockwise, true), expected, "{name}, mirrored");
        assert_eq!(answer(&mut engine, &scan, &listed, true), expected, "{name}, mirrored and listed clockwise");
    }
}
