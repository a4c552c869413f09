//! Figures of maps, on a mine of three places in a row: tee 0, 20 m, tee 1, 20 m, dead end 2.

use crosscut_evaluate::maps::{
    Counts, MapFigures, MapTruth, TruePassage, TruePlace, WhereAt, every_change, within_radius,
};
use crosscut_flight::{HereKind, Map, Node, NodeWay, Passage};
use crosscut_messages::{TruthEdge, TruthKind, TruthMap, TruthNode, TruthWay};
use nalgebra::Point2;

/// From 10 m before the first place to the third and back to the second, a metre and a nanosecond at a time; at stamp 100
/// the vehicle is at the first place.
fn truth() -> MapTruth {
    let place = |x_m: f64, ways| TruePlace { position_m: [x_m, 0.0], ways, width_m: 4.0, narrowest_m: 4.0 };
    let there_and_back = (-10..=40).chain((20..40).rev());
    let at = |(stamp, x): (u64, i32)| WhereAt { stamp_ns: stamp, position_m: [f64::from(x), 0.0] };
    MapTruth {
        places: vec![place(0.0, 3), place(20.0, 3), place(40.0, 1)],
        passages: vec![TruePassage { ends: [0, 1], length_m: 20.0 }, TruePassage { ends: [1, 2], length_m: 20.0 }],
        at: (90..).zip(there_and_back).map(at).collect(),
        bays: Vec::new(),
    }
}

fn node(ways: usize, visits: &[[u64; 2]]) -> Node {
    let kind = if ways == 1 { HereKind::DeadEnd } else { HereKind::Junction };
    let way = NodeWay { bearing_rad: 0.0, width_m: 4.0, taken: false, passage: None };
    Node { kind, position_m: Point2::origin(), ways: vec![way; ways], visits: visits.to_vec() }
}

fn passage(from: usize, to: usize, length_m: f64) -> Passage {
    Passage { from, to, length_m, length_sd_m: None, width_m: 4.0, stretch_ns: [0, 0], via_m: Vec::new() }
}

fn right_map() -> Map {
    Map {
        nodes: vec![node(3, &[[97, 103]]), node(3, &[[117, 123], [157, 160]]), node(1, &[[137, 143]])],
        passages: vec![passage(0, 1, 21.0), passage(1, 2, 20.0)],
        ..Map::default()
    }
}

#[test]
fn a_right_map_is_exact_in_every_figure() {
    let figures = MapFigures::of(&right_map(), &truth());
    let shares = [figures.exact, figures.precision, figures.recall, figures.same_precision, figures.same_recall];
    assert_eq!(shares.map(|share| share.value()), [Some(1.0); 5], "{figures:?}");
    assert_eq!((figures.f1(), figures.over_count(), figures.false_merges), (Some(1.0), Some(1.0), 0));
    assert_eq!((figures.degree.value(), figures.passages.value(), figures.false_passages), (Some(1.0), Some(1.0), 0));
    assert!((figures.length_errors[0] - 0.05).abs() < 1e-12 && figures.length_errors[1] == 0.0);
    assert_eq!((figures.loops.of, figures.false_loops), (0, 0));
}

#[test]
fn a_place_there_twice_costs_precision_and_recall_of_pairs() {
    let mut map = right_map();
    let visit = map.nodes[1].visits.pop().expect("the second one");
    map.nodes.push(node(3, &[visit]));
    let figures = MapFigures::of(&map, &truth());
    assert_eq!((figures.exact.hits, figures.precision.hits, figures.precision.of, figures.recall.hits), (0, 3, 4, 3));
    assert_eq!((figures.same_recall.hits, figures.same_recall.of, figures.false_merges), (0, 1, 0));
    assert!((figures.over_count().expect("places") - 4.0 / 3.0).abs() < 1e-12);
}

#[test]
fn two_places_in_one_node_are_a_false_merge() {
    let mut map = right_map();
    map.nodes[0].visits.push([117, 123]);
    map.nodes[1].visits.remove(0);
    let figures = MapFigures::of(&map, &truth());
    assert_eq!((figures.false_merges, figures.exact.hits), (1, 0));
    assert_eq!((figures.same_precision.hits, figures.same_precision.of, figures.same_recall.hits), (0, 1, 0));
}

#[test]
fn a_passage_that_is_not_there_is_false_and_closes_a_false_loop() {
    let mut map = right_map();
    map.passages.push(passage(0, 2, 40.0));
    let figures = MapFigures::of(&map, &truth());
    assert_eq!((figures.false_passages, figures.false_loops, figures.exact.hits), (1, 1, 0));
    map.passages.remove(0);
    assert_eq!(MapFigures::of(&map, &truth()).passages.hits, 1);
}

#[test]
fn every_change_counts_a_place_twice_and_a_radius_does_not() {
    let mut counts = Counts::default();
    let truth = truth();
    for at in &truth.at {
        let x_m = at.position_m[0];
        let near = [0.0, 20.0, 40.0].map(|place_m: f64| (place_m - x_m).abs() <= 3.0);
        counts.add(if near[2] { 1 } else { 2 + usize::from(near[0] || near[1]) }, *at);
    }
    let stays = counts.stays();
    let changes = MapFigures::of_visits(&every_change(&stays), &truth);
    assert_eq!((changes.precision.of, changes.same_recall.hits, changes.same_recall.of), (4, 0, 1));
    let radius = MapFigures::of_visits(&within_radius(&stays, 8.0), &truth);
    assert_eq!((radius.f1(), radius.same_recall.value(), radius.degree.of), (Some(1.0), Some(1.0), 0));
    let mut both = changes.clone();
    both.merge(&radius);
    assert_eq!((both.precision.of, both.recall.of), (7, 6));
}

#[test]
fn a_place_where_the_flight_begins_need_not_be_found() {
    let mut truth = truth();
    let mut map = right_map();
    map.nodes[0].visits[0] = [99, 103];
    truth.at.drain(..9);
    assert_eq!(MapFigures::of(&map, &truth).exact.hits, 1, "a flight that begins in the first place");
    let without = Map { nodes: map.nodes.split_off(1), passages: vec![passage(0, 1, 20.0)], ..Map::default() };
    let figures = MapFigures::of(&without, &truth);
    assert_eq!((figures.exact.hits, figures.recall.of), (1, 2));
}

#[test]
fn two_passages_between_the_same_places_are_two() {
    let mut truth = truth();
    truth.passages.push(TruePassage { ends: [0, 1], length_m: 40.0 });
    let mut map = right_map();
    assert_eq!(MapFigures::of(&map, &truth).exact.hits, 1, "the longer one was not flown");
    map.passages.push(passage(0, 1, 39.0));
    let figures = MapFigures::of(&map, &truth);
    assert_eq!((figures.false_passages, figures.passages.of, figures.exact.hits), (0, 2, 1));
    map.passages.push(passage(0, 1, 39.0));
    assert_eq!(MapFigures::of(&map, &truth).false_passages, 1, "there is no third");
}

#[test]
fn places_past_one_that_was_passed_too_far_off_are_joined_by_no_passage() {
    let mut truth = truth();
    let off = truth.at.iter_mut().filter(|at| (10.0..30.0).contains(&at.position_m[0]));
    off.for_each(|at| at.position_m[1] = 2.0);
    let figures = MapFigures::of(&right_map(), &truth);
    assert_eq!((figures.recall.of, figures.passages.of, figures.exact.hits), (2, 0, 1), "{figures:?}");
}

#[test]
fn a_dead_end_in_sight_of_the_place_before_it_is_a_part_of_that_place() {
    let node = |id, x_m: f64, y_m: f64, kind, edges: &[usize]| TruthNode {
        id,
        kind,
        x_m,
        y_m,
        ways: edges.iter().map(|&edge| TruthWay { bearing_rad: 0.0, width_m: 4.0, edge }).collect(),
    };
    let edge = |id, from, to, length_m| TruthEdge { id, from, to, length_m, width_m: 4.0 };
    let mine = |pocket_m| TruthMap {
        nodes: vec![
            node(0, 0.0, 0.0, TruthKind::DeadEnd, &[0]),
            node(1, 20.0, 0.0, TruthKind::Junction, &[0, 1, 2]),
            node(2, 20.0, pocket_m, TruthKind::DeadEnd, &[1]),
            node(3, 50.0, 0.0, TruthKind::DeadEnd, &[2]),
        ],
        edges: vec![edge(0, 0, 1, 20.0), edge(1, 1, 2, pocket_m), edge(2, 1, 3, 30.0)],
    };
    let far = MapTruth::from(&mine(7.0));
    assert_eq!((far.places.len(), far.passages.len(), far.places[1].ways), (4, 3, 3));
    let near = MapTruth::from(&mine(5.0));
    assert_eq!(near.passages, [TruePassage { ends: [0, 1], length_m: 50.0 }], "{near:?}");
    assert_eq!((near.places.len(), near.places[1].position_m), (2, [50.0, 0.0]));
    assert_eq!([&far, &near].map(|truth| truth.bays.len()), [1, 0], "between the looks either is right");
    assert_eq!(MapTruth::from(&mine(8.0)).bays, [0_usize; 0]);
}

#[test]
fn a_junction_of_a_bay_may_be_on_the_map_or_not() {
    let place = |x_m: f64, y_m: f64, ways| TruePlace { position_m: [x_m, y_m], ways, width_m: 4.0, narrowest_m: 4.0 };
    let passage = |from, to, length_m| TruePassage { ends: [from, to], length_m };
    let at = (0..60).map(|at| WhereAt { stamp_ns: at, position_m: [at as f64, 0.0] }).collect();
    let truth = MapTruth {
        places: vec![place(0.0, 0.0, 1), place(20.0, 0.0, 3), place(20.0, 6.0, 1), place(50.0, 0.0, 1)],
        passages: vec![passage(0, 1, 20.0), passage(1, 2, 6.0), passage(1, 3, 30.0)],
        at,
        bays: vec![1],
    };
    let figures = |visits: &[Vec<[u64; 2]>]| {
        let MapFigures { precision, recall, .. } = MapFigures::of_visits(visits, &truth);
        [precision, recall].map(|of| (of.hits, of.of))
    };
    assert_eq!(figures(&[vec![[18, 22]], vec![[48, 52]]]), [(2, 2); 2], "with it");
    assert_eq!(figures(&[vec![[48, 52]]]), [(1, 1); 2], "without it");
    assert_eq!(figures(&[vec![[18, 22]]]), [(1, 1), (1, 2)], "the end is missing");
}
