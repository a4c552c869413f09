//! The map of a simulated flight that comes back to places it has seen.

use std::collections::BTreeSet;

use crosscut_evaluate::maps::MapTruth;
use crosscut_flight::{FlightAnswer, Here, HereKind, Map, Mapper, Steady, Way};
use crosscut_messages::Time;
use crosscut_simulator::network::Point;
use crosscut_simulator::{Plan, Scene};
use crosscut_stage::{Frame, Revolution};
use nalgebra::{Isometry2, Vector2};

use crate::{Flown, Follower, TUNNEL, scenario};

impl Flown {
    /// The true node that is nearest in the middle of a visit, of those that are no mere bend.
    fn true_node(&self, [from_ns, to_ns]: [u64; 2]) -> usize {
        let during: Vec<_> =
            self.revolutions.iter().filter(|seen| (from_ns..=to_ns).contains(&seen.stamp_ns)).collect();
        let place_m = Point::from(during[during.len() / 2].true_pose.translation.vector);
        let off_m = |node: &usize| (self.network.nodes[*node].position_m - place_m).norm();
        let nodes = (0..self.network.nodes.len()).filter(|&node| self.network.degree(node) != 2);
        nodes.min_by(|a, b| off_m(a).total_cmp(&off_m(b))).expect("a mine has nodes")
    }
}

#[test]
fn places_seen_again_are_one_node_and_no_two_places_are() {
    let flown = Flown::of("loops", 1, 2300);
    let map = &flown.map;
    let of = |node: usize| -> BTreeSet<usize> {
        map.nodes[node].visits.iter().map(|visit| flown.true_node(*visit)).collect()
    };
    assert!((0..map.nodes.len()).all(|node| of(node).len() == 1), "a node mixes two places");
    assert!(!map.merges.is_empty() && map.loops() >= 1, "{:?}", map.merges);
    assert!(map.merges.iter().all(|merge| map.nodes[merge.node].visits.len() > 1));
    let places: BTreeSet<usize> = (0..map.nodes.len()).flat_map(of).collect();
    assert!(map.nodes.len() <= places.len() + 1, "{} nodes of {} places", map.nodes.len(), places.len());
    // In the frame of the first pose, each node lies where the vehicle was at its visits.
    let first = flown.revolutions[0].true_pose;
    for node in &map.nodes {
        let true_m = first.inverse() * flown.network.nodes[flown.true_node(node.visits[0])].position_m;
        assert!((node.position_m - true_m).norm() < 8.0, "{node:?} lies at {true_m}");
        assert!(node.ways.is_sorted_by(|a, b| {
            let from_first =
                |way: &crosscut_flight::NodeWay| (way.bearing_rad - node.ways[0].bearing_rad).rem_euclid(6.3);
            from_first(a) <= from_first(b) + 0.1
        }));
    }
    for passage in &map.passages {
        let apart_m: Vector2<f64> = map.nodes[passage.from].position_m - map.nodes[passage.to].position_m;
        assert!(passage.length_m > 0.8 * apart_m.norm() && !passage.via_m.is_empty(), "{passage:?}");
        let ways = |node: usize| map.nodes[node].ways.iter().filter(|way| way.taken && way.passage.is_some()).count();
        assert!(ways(passage.from) > 0 && ways(passage.to) > 0);
    }
}

#[test]
fn a_tunnel_with_branches_is_a_chain_of_junctions() {
    let map = &TUNNEL.map;
    assert_eq!((places(map), map.passages.len()), ((vec![3, 3, 3, 3, 4, 4], 2, 0), map.nodes.len() - 1));
    assert!(map.merges.is_empty() && map.ways_not_taken() >= 6);
}

/// How many ways each junction has, in order, how many dead ends there are, and how many loops.
fn places(map: &Map) -> (Vec<usize>, usize, usize) {
    let of = |kind| map.nodes.iter().filter(move |node| node.kind == kind);
    let mut ways: Vec<usize> = of(HereKind::Junction).map(|node| node.ways.len()).collect();
    ways.sort_unstable();
    (ways, of(HereKind::DeadEnd).chain(of(HereKind::Chamber)).count(), map.loops())
}

/// The map of a straight flight along x, as [`flown`].
fn straight(stretches: &[(f64, HereKind)], look_m: f64) -> Map {
    flown(stretches, look_m, |way_m| [way_m, 0.0])
}

/// The map of a flight, five frames a metre, without turning: after each length of way the vehicle is in what goes with it.
/// Ways of passages and junctions lead along x and back, those of dead ends and chambers back, those of junctions also to the
/// left.
fn flown(stretches: &[(f64, HereKind)], look_m: f64, place_m: impl Fn(f64) -> [f64; 2]) -> Map {
    let mut mapper = Mapper::default();
    let mut step = 0;
    for &(to_m, kind) in stretches {
        let bearings_rad: &[f64] = match kind {
            HereKind::DeadEnd | HereKind::Chamber => &[3.1],
            HereKind::Junction => &[0.0, 1.6, 3.1],
            HereKind::Passage => &[0.0, 3.1],
        };
        let way = |&bearing_rad: &f64| Way { bearing_rad, width_m: 3.0, opening: None };
        let here =
            Here { kind, look_m, ways: bearings_rad.iter().map(way).collect(), is_middle: true, confidence: 0.9 };
        while 0.2 * f64::from(step) < to_m {
            let [x_m, y_m] = place_m(0.2 * f64::from(step));
            let pose = Isometry2::translation(x_m, y_m);
            let steady =
                Steady { junctions: 2, here: Some(here.clone()), openings: Vec::new(), closed_rad: Vec::new() };
            let revolution = Revolution { stamp_ns: 100_000_000 * u64::from(step as u32), ..Revolution::default() };
            let mut frame = Frame { revolution, ..Frame::default() };
            FlightAnswer { pose: Some(pose), doubt: None, here: Some(here.clone()), steady: Some(steady) }
                .put(&mut frame);
            mapper.add(&frame);
            step += 1;
        }
    }
    mapper.map()
}

#[test]
fn a_dead_end_that_is_flown_through_is_no_node() {
    use HereKind::{DeadEnd, Junction, Passage};
    let map = straight(&[(4.0, Junction), (20.0, Passage), (26.0, DeadEnd), (40.0, Passage), (44.0, Junction)], 5.0);
    assert_eq!((places(&map), map.passages.len()), ((vec![3, 3], 0, 0), 1), "{map:?}");
    let passage = &map.passages[0];
    let ends_m = [passage.from, passage.to].map(|node| map.nodes[node].position_m.x);
    assert!((passage.length_m - (ends_m[1] - ends_m[0])).abs() < 0.5, "{passage:?}");
    assert!(passage.via_m.windows(2).all(|two| two[0].x < two[1].x), "the course does not double back: {passage:?}");
    assert!(passage.via_m.iter().all(|place_m| ends_m[0] < place_m.x && place_m.x < ends_m[1]), "{passage:?}");
    let to_the_face = straight(&[(4.0, Junction), (20.0, Passage), (26.0, DeadEnd)], 5.0);
    assert_eq!(places(&to_the_face).1, 1, "{to_the_face:?}");
}

#[test]
fn a_wide_place_is_left_by_the_way_beyond_the_look() {
    use HereKind::{Junction, Passage};
    let stays = [(6.0, Passage), (12.0, Junction), (50.0, Passage)];
    let taken = |place_m: fn(f64) -> [f64; 2]| {
        let map = flown(&stays, 8.0, place_m);
        map.nodes[0].ways.iter().map(|way| way.taken).collect::<Vec<_>>()
    };
    assert_eq!(taken(|way_m| [way_m, 0.0]), [true, false, true]);
    // Straight on until the place is no junction any more, to the left within the look.
    assert_eq!(taken(|way_m| [way_m.min(13.0), (way_m - 13.0).max(0.0)]), [false, true, true]);
}

#[test]
fn a_way_looked_into_from_a_wide_place_and_not_left_by_is_not_taken() {
    use HereKind::{Junction, Passage};
    let stays = [(10.8, Passage), (12.2, Junction), (15.0, Passage), (18.0, Junction), (60.0, Passage)];
    // 3 m to the left within the look, back, and straight on.
    let map = flown(&stays, 8.0, |way_m| match way_m {
        ..12.0 => [way_m, 0.0],
        ..15.0 => [12.0, way_m - 12.0],
        ..18.0 => [12.0, 18.0 - way_m],
        _ => [way_m - 6.0, 0.0],
    });
    let taken: Vec<bool> = map.nodes[0].ways.iter().map(|way| way.taken).collect();
    assert_eq!((map.nodes.len(), taken), (1, vec![true, false, true]), "{map:?}");
}

#[test]
fn a_way_that_was_flown_and_not_seen_is_the_one_that_is_taken() {
    use HereKind::{Junction, Passage};
    let stays = [(4.0, Junction), (20.0, Passage), (24.0, Junction), (60.0, Passage)];
    // To the left, into a junction that no way is seen to lead back from, and on to the right.
    let map = flown(&stays, 5.0, |way_m| [(way_m - 22.0).max(0.0), way_m.min(22.0)]);
    let ways = |node: usize| map.nodes[node].ways.iter().map(|way| (way.bearing_rad.round(), way.taken, way.passage));
    assert_eq!(ways(0).collect::<Vec<_>>(), [(0.0, false, None), (2.0, true, Some(0)), (3.0, false, None)]);
    let second = [(0.0, true, None), (2.0, false, None), (3.0, false, None), (-2.0, true, Some(0))];
    assert_eq!(ways(1).collect::<Vec<_>>(), second, "{map:?}");
}

#[test]
fn two_stays_within_half_a_look_are_one_visit_and_others_are_not() {
    use HereKind::{Junction, Passage};
    let stays =
        [(4.0, Junction), (30.0, Passage), (33.0, Junction), (36.0, Passage), (39.0, Junction), (60.0, Passage)];
    let wide = straight(&stays, 12.5);
    assert_eq!((wide.nodes.len(), wide.passages.len(), wide.nodes[1].visits.len()), (2, 1, 2), "{wide:?}");
    // Each has a mouth to its left.
    for look_m in [4.0, 6.0] {
        let close = straight(&stays, look_m);
        assert_eq!((close.nodes.len(), close.passages.len()), (3, 2), "{close:?}");
    }
}

#[test]
fn a_junction_that_looks_like_a_dead_end_for_a_while_is_one_node() {
    use HereKind::{DeadEnd, Junction, Passage};
    for (first, second) in [(Junction, DeadEnd), (DeadEnd, Junction)] {
        let map = straight(&[(4.0, Junction), (30.0, Passage), (32.0, first), (34.0, second), (60.0, Passage)], 12.5);
        assert_eq!(places(&map), (vec![3, 3], 0, 0), "{map:?}");
    }
}

#[test]
fn junctions_ten_metres_apart_are_nodes_of_their_own() {
    // A drift 4 m wide with crosscuts to one side and the other, as they are spaced in real mines.
    let nodes = [(-20, 0), (0, 0), (10, 0), (21, 0), (40, 0), (-1, 20), (11, -20), (21, 20)];
    let nodes = nodes.iter().enumerate().map(|(id, (x, y))| format!(r#"{{"id":{id},"x_m":{x},"y_m":{y}}}"#));
    let edges = [(0, 1), (1, 2), (2, 3), (3, 4), (1, 5), (2, 6), (3, 7)];
    let edges = edges.map(|(from, to)| format!(r#"{{"from":{from},"to":{to},"width_m":4}}"#)).join(",");
    let plan = format!(r#"{{"nodes":[{}],"edges":[{edges}]}}"#, nodes.collect::<Vec<_>>().join(","));
    let (map, differences) = map_of(&plan, |_| true);
    assert!(differences.is_empty(), "{}: {differences:#?}", map.summary());
}

#[test]
fn a_pocket_beyond_a_bend_is_no_way() {
    // Straight on at the bend, the wall is 6.6 m away: within the look from there, beyond it from either side.
    let plan = r#"{"nodes":[{"id":0,"x_m":-45,"y_m":0},{"id":1,"x_m":0,"y_m":0},{"id":2,"x_m":0,"y_m":-45},
        {"id":3,"x_m":6.6,"y_m":1}],"edges":[{"from":0,"to":1,"width_m":5.6},{"from":1,"to":2,"width_m":5.6},
        {"from":1,"to":3,"width_m":5.6}],"roughness_m":0.15}"#;
    let (map, differences) = map_of(plan, |place_m| place_m.y > -35.0);
    assert!(differences.is_empty(), "{}: {differences:#?}", map.summary());
}

#[test]
fn a_row_of_twins_beyond_a_gap_is_not_the_row_before_it() {
    // Three tees 11 m apart, a gap of four seconds, three more of them; nothing tells how far it is between.
    let nodes = (0..6).map(|tee| (11 * tee, 0)).chain((0..6).map(|tee| (11 * tee, 15))).chain([(-30, 0), (85, 0)]);
    let nodes = nodes.enumerate().map(|(id, (x, y))| format!(r#"{{"id":{id},"x_m":{x},"y_m":{y}}}"#));
    let edges =
        [(12, 0), (0, 1), (1, 2), (2, 3), (3, 4), (4, 5), (5, 13)].into_iter().chain((0..6).map(|tee| (tee, tee + 6)));
    let edges = edges.map(|(from, to)| format!(r#"{{"from":{from},"to":{to},"width_m":4}}"#));
    let [nodes, edges] = [nodes.collect::<Vec<_>>(), edges.collect()].map(|of| of.join(","));
    let plan = format!(r#"{{"nodes":[{nodes}],"edges":[{edges}],"roughness_m":0.02,"start":{{"node":12}}}}"#);
    let (map, _) = map_with(&plan, |place_m| place_m.x < 100.0, |place_m| !(52.0..58.0).contains(&place_m.x));
    let tees = map.nodes.iter().filter(|node| node.kind == HereKind::Junction).count();
    assert_eq!((tees, map.merges.len()), (6, 0), "{}: {:?}", map.summary(), map.merges);
}

#[test]
fn a_stretch_beyond_a_gap_joins_again_by_three_places() {
    // Out past four tees that differ, into the end, and back, with a gap of four seconds each time at 100 m.
    let plan = r#"{"nodes":[{"id":0,"x_m":-30,"y_m":0},{"id":1,"x_m":0,"y_m":0},{"id":2,"x_m":19,"y_m":3},{"id":3,"x_m":33,"y_m":0},
        {"id":4,"x_m":57,"y_m":-4},{"id":5,"x_m":95,"y_m":0},{"id":6,"x_m":-4,"y_m":44},{"id":7,"x_m":28,"y_m":-44},
        {"id":8,"x_m":46,"y_m":44},{"id":9,"x_m":48,"y_m":-48}],
        "edges":[{"from":0,"to":1,"width_m":4},{"from":1,"to":2,"width_m":3.5},{"from":2,"to":3,"width_m":4.5},
        {"from":3,"to":4,"width_m":3.6},{"from":4,"to":5,"width_m":4},{"from":1,"to":6,"width_m":3},{"from":2,"to":7,"width_m":4},
        {"from":3,"to":8,"width_m":3.4},{"from":4,"to":9,"width_m":4.4}],"roughness_m":0.1,"start":{"node":0}}"#;
    let (map, _) = map_with(plan, |_| true, |place_m| !(100.0..106.0).contains(&place_m.x));
    let tees = map.nodes.iter().filter(|node| node.kind == HereKind::Junction).count();
    assert_eq!(tees, 4, "{}: {:#?}", map.summary(), map.merges);
    // The first two places of the stretch lie, by a guess, near those that they are; the third one decides.
    let is_by_position = |merge: &&crosscut_flight::Decided| merge.why.starts_with("after the correction");
    assert_eq!(map.merges[..3].iter().filter(is_by_position).count(), 0, "{:#?}", map.merges);
}

#[test]
fn stretches_of_two_places_prove_nothing_to_each_other() {
    // The first minute of a flight, three times: from the end of each, all at once back at the beginning.
    let minute: Vec<Scene> = (scenario("mine").fly)(1).take(600).collect();
    let (follower, mut mapper) = (&mut Follower::default(), Mapper::default());
    for (at, scene) in minute.iter().cycle().take(3 * minute.len()).enumerate() {
        let mut scene = scene.clone();
        scene.scan.header.stamp = Time::from_ns(100_000_000 * at as u64);
        mapper.add(follower.follow(&scene));
    }
    let map = mapper.map();
    assert!(map.nodes.len() >= 6 && map.merges.is_empty(), "{}: {:?}", map.summary(), map.merges);
}

/// The map of a flight through a plan as long as `lasts` is true of its places, and the errors of that map.
fn map_of(plan: &str, lasts: impl Fn(Point) -> bool) -> (Map, Vec<String>) {
    map_with(plan, lasts, |_| true)
}

/// The map of such a flight whose recording has only the places for which `has` is true.
fn map_with(plan: &str, lasts: impl Fn(Point) -> bool, has: impl Fn(Point) -> bool) -> (Map, Vec<String>) {
    let scenes = Plan::from_json(plan).and_then(|plan| plan.fly(1)).expect("a plan");
    let mut mapper = Mapper::default();
    let mut truth: Option<MapTruth> = None;
    let follower = &mut Follower::default();
    for scene in scenes {
        let pose = scene.truth.pose.expect("a scene of a flight");
        if !lasts(Point::new(pose.x_m, pose.y_m)) {
            break;
        }
        if !has(Point::new(pose.x_m, pose.y_m)) {
            continue;
        }
        let frame = follower.follow(&scene);
        mapper.add(frame);
        let mine = scene.map.as_ref();
        let truth = truth.get_or_insert_with(|| MapTruth::from(mine.expect("a flight begins with its map")));
        truth.add(frame.revolution.stamp_ns, &pose);
    }
    let map = mapper.map();
    let differences = truth.expect("a scene").differences(&map);
    (map, differences)
}

#[test]
fn a_chamber_with_one_way_is_a_dead_end_of_the_map() {
    use HereKind::{Chamber, Junction, Passage};
    let map = straight(&[(4.0, Junction), (20.0, Passage), (26.0, Chamber)], 5.0);
    assert_eq!(places(&map), (vec![3], 1, 0), "{map:?}");
}
