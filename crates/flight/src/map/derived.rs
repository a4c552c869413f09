//! The map, derived from a log.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use crosscut_stage::{DisjointSets, wrap_angle_rad};
use nalgebra::Point2;

use super::log::{Link, Log, flown_sd_m};
use super::visit::{FLOWN_WAY_RAD, Visit};
use super::{Decided, Map, Node, NodeWay, Passage};
use crate::HereKind;

/// Between two visits of one node, a passage is longer than this.
const TURN_M: f64 = 8.0;

/// A vehicle that comes back to the node that it left, by a way no longer than this many looks, only turned.
const TURN_LOOKS: f64 = 1.5;

/// Ways of two visits whose directions differ by less may be one.
const SAME_WAY_RAD: f64 = 0.6;

/// The map that a log has, and how its visits stand on that map.
#[derive(Clone, Debug)]
pub(super) struct Derived {
    pub(super) map: Map,
    /// The node of each visit.
    pub(super) node_of: Vec<usize>,
    /// Of each node.
    pub(super) places: Vec<Place>,
    /// The node of the latest visit and the way by which the vehicle left.
    pub(super) left_by: Option<(usize, usize)>,
}

/// What recognises a node.
#[derive(Clone, Debug)]
pub(super) struct Place {
    /// Its visits, in order.
    pub(super) visits: Vec<usize>,
    /// The visit in whose frame the place is: its first one, or the first one to a junction. What looked like a dead
    /// end before was a part of that.
    pub(super) first: usize,
    /// Directions of its ways in that frame, anticlockwise.
    pub(super) ways_rad: Vec<f64>,
    /// The belief in each number of ways, summed over its visits.
    belief: BTreeMap<usize, f64>,
}

impl Place {
    /// The number of ways that is believed most, over all visits up to this one, holds: one may have missed a way. What
    /// was flown is certain: a visit that did not see all of that does not count.
    fn count_ways(&mut self, log: &Log, number: usize, node: &mut Node) {
        let visit = &log.visits[number];
        if visit.kind != node.kind {
            return;
        }
        *self.belief.entry(visit.ways.len()).or_default() += visit.belief;
        let most = self.belief.iter().max_by(|a, b| a.1.total_cmp(b.1)).map(|(ways, _)| *ways);
        if most != Some(visit.ways.len()) || visit.ways.len() == node.ways.len() {
            return;
        }
        let mut ways = ways_of(visit, log.turned_rad(self.first, number));
        for flown in node.ways.iter().filter(|way| way.taken) {
            let Some(same) = nearest_way(&ways, flown.bearing_rad) else { return };
            let same = &mut ways[same];
            if same.taken || wrap_angle_rad(same.bearing_rad - flown.bearing_rad).abs() >= SAME_WAY_RAD {
                return;
            }
            same.taken = true;
        }
        node.ways = ways;
    }
}

/// A leg between two ways.
struct Course {
    leg: usize,
    /// Numbers of a node and of one of its ways.
    ends: [(usize, usize); 2],
    length_m: f64,
}

/// The node of each visit, numbered by their first visits: visits of one stay and linked ones are to one.
fn nodes_of(log: &Log) -> Vec<usize> {
    let mut sets = DisjointSets::default();
    sets.reset(log.visits.len());
    let stays = (0..log.legs.len()).filter(|&leg| log.legs[leg].is_stay).map(|leg| [leg, leg + 1]);
    for [a, b] in log.links.iter().map(|link| link.visits).chain(stays) {
        sets.join(a, b);
    }
    sets.number_components().iter().map(|&node| node as usize).collect()
}

/// Whether the vehicle, back at the node that it left, was not beyond the look or flew no way in between that is worth
/// a passage.
fn only_turned(log: &Log, leg: usize) -> bool {
    let length_m = log.legs[leg].length_m.unwrap_or_default();
    log.legs[leg].beyond_m.is_none() || length_m < TURN_M.max(TURN_LOOKS * log.visits[leg + 1].look_m)
}

/// A node as the visit in whose frame the place is saw the ways. Bearings are in that frame.
fn first_seen(log: &Log, visits: Vec<usize>) -> (Place, Node) {
    let is_junction = |visit: &&usize| log.visits[**visit].kind == HereKind::Junction;
    let first = *visits.iter().find(is_junction).unwrap_or(&visits[0]);
    let node = Node {
        kind: log.visits[first].kind,
        position_m: Point2::from(log.graph.poses[first].translation.vector),
        ways: ways_of(&log.visits[first], 0.0),
        visits: visits.iter().map(|&visit| log.visits[visit].time_ns).collect(),
    };
    (Place { visits, first, ways_rad: Vec::new(), belief: BTreeMap::new() }, node)
}

impl Derived {
    pub(super) fn of(log: &Log) -> Self {
        let node_of = nodes_of(log);
        let mut visits = vec![Vec::new(); node_of.iter().max().map_or(0, |last| last + 1)];
        (0..node_of.len()).for_each(|visit| visits[node_of[visit]].push(visit));
        let (mut places, mut nodes): (Vec<Place>, Vec<Node>) = visits.into_iter().map(|of| first_seen(log, of)).unzip();
        let is_turn =
            |leg: usize| log.legs[leg].length_m.is_some() && node_of[leg] == node_of[leg + 1] && only_turned(log, leg);
        let leg_to = |visit: usize| visit.checked_sub(1).filter(|&leg| log.legs[leg].length_m.is_some());
        // Of each visit, the direction from which the vehicle came, and that in which it left.
        let came_rad = |visit: usize| {
            let has_come = leg_to(visit).map_or(log.visits[visit].has_come, |leg| !is_turn(leg));
            let seen = &log.visits[visit];
            let turned_rad = log.turned_rad(places[node_of[visit]].first, visit);
            has_come.then(|| seen.direction_rad(seen.came_from) + turned_rad)
        };
        let left_rad = |visit: usize| {
            let (seen, leg) = (&log.visits[visit], &log.legs[visit]);
            let direction_rad = || match leg.beyond_m {
                Some(beyond_m) => beyond_m.y.atan2(beyond_m.x),
                None => seen.direction_rad(seen.left_to),
            };
            leg.has_left.then(|| direction_rad() + log.turned_rad(places[node_of[visit]].first, visit))
        };
        let flown: Vec<[Option<f64>; 2]> = (0..node_of.len()).map(|visit| [came_rad(visit), left_rad(visit)]).collect();
        for (visit, &[came_rad, left_rad]) in flown.iter().enumerate() {
            let (place, node) = (&mut places[node_of[visit]], &mut nodes[node_of[visit]]);
            place.count_ways(log, visit, node);
            let width_m = |leg: Option<usize>| leg.and_then(|leg| log.legs[leg].width_m);
            if let Some(rad) = came_rad {
                add_missed(node, rad, width_m(leg_to(visit)));
                take(node, rad);
            }
            if let Some(rad) = left_rad {
                if log.legs[visit].beyond_m.is_some() {
                    add_missed(node, rad, width_m(Some(visit)));
                }
                if !is_turn(visit) {
                    take(node, rad);
                }
            }
        }
        for (place, node) in places.iter_mut().zip(&nodes) {
            place.ways_rad = node.ways.iter().map(|way| way.bearing_rad).collect();
        }
        let end = |visit: usize, rad: Option<f64>| {
            let node = node_of[visit];
            rad.and_then(|rad| nearest_way(&nodes[node].ways, rad)).map(|way| (node, way))
        };
        let mut left_by = None;
        let mut courses: Vec<Course> = Vec::new();
        for (visit, [came_rad, left_rad]) in flown.into_iter().enumerate() {
            let came_by = end(visit, came_rad);
            if let (Some(leg), Some(from), Some(to)) = (leg_to(visit), left_by, came_by) {
                add_course(&mut courses, log, &places, leg, [from, to]);
            }
            left_by = end(visit, left_rad);
        }
        let passages = courses.iter().enumerate().map(|(number, course)| {
            for (node, way) in course.ends {
                let way = &mut nodes[node].ways[way];
                way.taken = true;
                way.passage.get_or_insert(number);
            }
            course.passage(log, &nodes)
        });
        let passages = passages.collect();
        for (place, node) in places.iter().zip(&mut nodes) {
            let turned_rad = log.graph.poses[place.first].rotation.angle();
            node.ways.iter_mut().for_each(|way| way.bearing_rad = wrap_angle_rad(way.bearing_rad + turned_rad));
        }
        let of_link = |link: &Link| Decided { node: node_of[link.visits[0]], ..link.decided.clone() };
        let [merges, refusals] = [&log.links, &log.refusals].map(|links| links.iter().map(of_link).collect());
        // No leg leads on from a visit before a cut.
        let left_by = left_by.filter(|_| !log.is_cut);
        let map = Map { nodes, passages, merges, refusals, stretches_from_ns: log.stretches_from_ns.clone() };
        Self { map, places, left_by, node_of }
    }

    /// Whether a node was seen on one stay alone.
    pub(super) fn is_new(&self, node: usize) -> bool {
        self.map.merges.iter().all(|merge| merge.node != node)
    }

    /// The node and the passage by which the vehicle left the latest visit, if that passage is known.
    pub(super) fn left_through(&self) -> Option<(usize, &Passage)> {
        let (node, way) = self.left_by?;
        Some((node, &self.map.passages[self.map.nodes[node].ways[way].passage?]))
    }
}

/// What was flown is certain: if a junction has no way in a direction in which the vehicle flew, the visits have missed
/// that way.
fn add_missed(node: &mut Node, direction_rad: f64, width_m: Option<f64>) {
    let off_rad = |way: &NodeWay| wrap_angle_rad(way.bearing_rad - direction_rad).abs();
    if node.kind != HereKind::Junction || node.ways.iter().any(|way| off_rad(way) <= FLOWN_WAY_RAD) {
        return;
    }
    let behind_rad = |way: &usize| (direction_rad - node.ways[*way].bearing_rad).rem_euclid(TAU);
    let before = (0..node.ways.len()).min_by(|a, b| behind_rad(a).total_cmp(&behind_rad(b)));
    let narrowest_m = node.ways.iter().map(|way| way.width_m).min_by(f64::total_cmp).unwrap_or_default();
    let way = new_way(wrap_angle_rad(direction_rad), width_m.unwrap_or(narrowest_m));
    node.ways.insert(before.map_or(0, |before| before + 1), way);
}

/// Adds a leg between two ways as a passage. Of two passages through one way, one that passes by the end of the other is left out;
/// if neither does, the way branches further on, and both are passages.
fn add_course(courses: &mut Vec<Course>, log: &Log, places: &[Place], leg: usize, ends: [(usize, usize); 2]) {
    let [from, to] = ends;
    if from == to {
        return;
    }
    let apart_m = |a: usize, b: usize| {
        let [a, b] = [a, b].map(|visit| log.graph.poses[visit].translation.vector);
        (a - b).norm()
    };
    // A node lies where its first visit does, which need not be in the middle of the others.
    let [first, second] = ends.map(|(node, _)| places[node].first);
    let flown_m = log.legs[leg].length_m.unwrap_or_default().max(0.0);
    let length_m = (flown_m + apart_m(first, second) - apart_m(leg, leg + 1)).max(0.0);
    let course = Course { leg, ends, length_m };
    if !courses.iter().any(|known| course.covers(known, log, places)) {
        courses.retain(|known| known.length_m <= course.length_m || !known.covers(&course, log, places));
        courses.push(course);
    }
}

impl Course {
    /// Whether this passage has a way in common with another one and passes by the place at that one's other end.
    fn covers(&self, other: &Self, log: &Log, places: &[Place]) -> bool {
        let is_shared = |end: &(usize, usize)| self.ends.contains(end);
        let passes = |node: usize| {
            let first = places[node].first;
            let place_m = Point2::from(log.graph.poses[first].translation.vector);
            self.ends.iter().any(|end| end.0 == node)
                || self.via_m(log).any(|via_m| (via_m - place_m).norm() < log.visits[first].look_m)
        };
        other.ends.iter().any(is_shared) && other.ends.iter().all(|end| is_shared(end) || passes(end.0))
    }

    /// Places along it, in the frame of the map.
    fn via_m<'a>(&self, log: &'a Log) -> impl Iterator<Item = Point2<f64>> + 'a {
        let from = log.graph.poses[self.leg];
        log.legs[self.leg].via_m.iter().map(move |place_m| from * place_m)
    }

    fn passage(&self, log: &Log, nodes: &[Node]) -> Passage {
        let (leg, [before, visit]) = (&log.legs[self.leg], [self.leg, self.leg + 1].map(|visit| &log.visits[visit]));
        // Between two places that touch nothing was measured.
        let widths_m = self.ends.map(|(node, way)| nodes[node].ways[way].width_m);
        Passage {
            from: self.ends[0].0,
            to: self.ends[1].0,
            length_m: self.length_m,
            length_sd_m: flown_sd_m(before, visit),
            width_m: leg.width_m.unwrap_or(widths_m[0].min(widths_m[1])),
            stretch_ns: [before.time_ns[1], visit.time_ns[0]],
            via_m: self.via_m(log).collect(),
        }
    }
}

/// The way nearest to a direction.
fn nearest_way(ways: &[NodeWay], direction_rad: f64) -> Option<usize> {
    let off_rad = |way: &usize| wrap_angle_rad(ways[*way].bearing_rad - direction_rad).abs();
    (0..ways.len()).min_by(|a, b| off_rad(a).total_cmp(&off_rad(b)))
}

/// The vehicle flew in this direction.
fn take(node: &mut Node, direction_rad: f64) {
    if let Some(way) = nearest_way(&node.ways, direction_rad) {
        node.ways[way].taken = true;
    }
}

/// The ways of a visit that is turned by this much.
fn ways_of(visit: &Visit, turned_rad: f64) -> Vec<NodeWay> {
    let ways = visit.ways.iter().map(|way| new_way(wrap_angle_rad(way.bearing_rad + turned_rad), way.width_m));
    ways.collect()
}

fn new_way(bearing_rad: f64, width_m: f64) -> NodeWay {
    NodeWay { bearing_rad, width_m, taken: false, passage: None }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use nalgebra::{Isometry2, Vector2};

    use super::*;
    use crate::Way;
    use crate::map::outline::{Fit, Walls};

    /// A visit to a junction with ways along x, to the left and back: where it is, at which length of the flight, and
    /// how long.
    fn visit([x_m, y_m]: [f64; 2], at_m: f64, came_from_m: [f64; 2], left_to_m: [f64; 2]) -> Visit {
        let way = |bearing_rad| Way { bearing_rad, width_m: 4.0, opening: None };
        Visit {
            kind: HereKind::Junction,
            has_middle: false,
            time_ns: [2 * at_m as u64, 2 * at_m as u64 + 1],
            anchor: Isometry2::translation(x_m, y_m),
            ways: [0.0, 1.6, 3.1].map(way).to_vec(),
            look_m: 5.0,
            walls: Arc::new(Walls::new(&[])),
            reached_at_m: at_m,
            left_at_m: at_m,
            belief: 10.0,
            came_from: came_from_m.into(),
            left_to: left_to_m.into(),
            has_come: false,
            doubts: Default::default(),
        }
    }

    /// The log of these visits, each left beyond its look.
    fn log_of(visits: Vec<Visit>) -> Log {
        let mut log = Log::default();
        for visit in visits {
            let (reached_at_m, beyond_m) = (visit.reached_at_m, 2.0 * visit.left_to.coords);
            log.visit(visit, true);
            let number = log.visits.len() - 1;
            log.legs[number].beyond_m = Some(beyond_m);
            if let Some(before) = number.checked_sub(1) {
                let way_m = log.graph.poses[before].inv_mul(&log.graph.poses[number]).translation.vector;
                log.legs[before].length_m = Some(reached_at_m - log.visits[before].left_at_m);
                log.legs[before].via_m = (1..=20).map(|part| Point2::from(way_m * f64::from(part) / 20.0)).collect();
            }
        }
        log
    }

    fn link(log: &mut Log, visits: [usize; 2]) {
        let pose = log.visits[visits[0]].anchor.inv_mul(&log.visits[visits[1]].anchor);
        log.fit(visits, &Fit { pose, share: 1.0 });
        let decided = Decided { node: 0, at_ns: 0, score: 1.0, runner_up: None, why: String::new() };
        log.links.push(Link { visits, decided });
    }

    const AHEAD: [f64; 2] = [3.0, 0.0];
    const LEFT: [f64; 2] = [0.0, 3.0];
    const BACK: [f64; 2] = [-3.0, 0.0];

    fn ends(map: &Map) -> Vec<[usize; 2]> {
        map.passages.iter().map(|passage| [passage.from, passage.to]).collect()
    }

    #[test]
    fn a_way_is_not_taken_by_turning_at_once() {
        for (way_m, is_taken) in [(6.0, false), (40.0, true)] {
            let mut log = log_of(vec![visit([0.0; 2], 10.0, BACK, AHEAD), visit([0.0; 2], 10.0 + way_m, BACK, LEFT)]);
            log.legs[0].is_stay = true;
            assert_eq!(Derived::of(&log).map.nodes[0].ways[0].taken, is_taken, "after {way_m} m");
        }
    }

    #[test]
    fn a_place_before_the_end_of_a_known_passage_divides_it() {
        for (nearer_m, found) in [(20.0, [0, 2]), (34.0, [0, 2]), (36.0, [0, 1])] {
            let mut log = log_of(vec![
                visit([0.0; 2], 0.0, BACK, AHEAD),
                visit([40.0, 0.0], 40.0, BACK, BACK),
                visit([0.0; 2], 80.0, AHEAD, AHEAD),
                visit([nearer_m, 0.0], 80.0 + nearer_m, BACK, LEFT),
            ]);
            link(&mut log, [0, 2]);
            assert_eq!(ends(&Derived::of(&log).map), [found], "nearer than {nearer_m} m and the look");
        }
    }

    #[test]
    fn a_way_that_branches_further_on_leads_to_both_places() {
        let mut log = log_of(vec![
            visit([0.0; 2], 0.0, BACK, AHEAD),
            visit([40.0, 0.0], 40.0, BACK, BACK),
            visit([0.0; 2], 80.0, AHEAD, AHEAD),
            visit([20.0, 15.0], 110.0, BACK, LEFT),
        ]);
        link(&mut log, [0, 2]);
        assert_eq!(ends(&Derived::of(&log).map), [[0, 1], [0, 2]]);
    }

    #[test]
    fn a_turn_within_a_way_of_a_place_mapped_twice_is_no_passage() {
        // The second node is the first one, seen again after a turn in its first way; another passage leads to a third.
        let mut log = log_of(vec![
            visit([0.0; 2], 0.0, BACK, AHEAD),
            visit([0.0; 2], 20.0, AHEAD, LEFT),
            visit([0.0, 30.0], 50.0, BACK, AHEAD),
        ]);
        assert_eq!(ends(&Derived::of(&log).map), [[0, 1], [1, 2]]);
        link(&mut log, [0, 1]);
        let map = Derived::of(&log).map;
        assert_eq!(ends(&map), [[0, 1]], "{map:?}");
        let leads: Vec<Option<usize>> = map.nodes[0].ways.iter().map(|way| way.passage).collect();
        assert_eq!(leads, [None, Some(0), None]);
    }

    #[test]
    fn what_looked_like_a_dead_end_at_first_is_a_part_of_the_junction() {
        let mut end = visit([0.0; 2], 0.0, BACK, AHEAD);
        (end.kind, end.ways) = (HereKind::DeadEnd, vec![Way { bearing_rad: 3.1, width_m: 4.0, opening: None }]);
        let mut log = log_of(vec![end, visit([2.0, 0.0], 2.0, BACK, AHEAD)]);
        log.legs[0].is_stay = true;
        let Derived { map, places, .. } = Derived::of(&log);
        let node = &map.nodes[0];
        assert_eq!((map.nodes.len(), node.kind, node.ways.len(), places[0].first), (1, HereKind::Junction, 3, 1));
        assert_eq!(node.position_m.coords, Vector2::new(2.0, 0.0));
    }
}
