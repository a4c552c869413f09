//! Nodes of the map: added, seen again, and two that turn out to be one.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::sync::Arc;

use crosscut_stage::wrap_angle_rad;
use nalgebra::Point2;

use super::candidate::Candidate;
use super::draft::{Draft, NodeMemory, nearest_way};
use super::legs::{Leg, flown_to};
use super::outline::{Fit, Walls};
use super::recognise::{LEAST_LEAD, LEAST_SHARE};
use super::visit::{FLOWN_WAY_RAD, Visit};
use super::{Decided, Node, NodeWay};
use crate::pose_graph::information;
use crate::{Constraint, HereKind, Way};

/// Once the drift is corrected, two nodes nearer than this may be one.
const RECONSIDERED_M: f64 = 4.0;

/// Ways of two visits whose directions differ by less may be one.
const SAME_WAY_RAD: f64 = 0.6;

impl Draft {
    pub(super) fn add_node(&mut self, visit: &Visit, walls: Arc<Walls>, number: usize) -> usize {
        let way = |way: &Way| new_way(way.bearing_rad, way.width_m);
        self.map.nodes.push(Node {
            kind: visit.kind,
            position_m: Point2::origin(),
            ways: visit.ways.iter().map(way).collect(),
            visits: Vec::new(),
        });
        self.places.push(NodeMemory {
            walls,
            ways_rad: visit.ways.iter().map(|way| way.bearing_rad).collect(),
            first_visit: number,
            belief: BTreeMap::new(),
        });
        self.place_nodes();
        self.map.nodes.len() - 1
    }

    /// Takes a visit to be to a known node, and corrects all poses by it.
    pub(super) fn merge(
        &mut self,
        visit: &Visit,
        candidate: &Candidate,
        runner_up: Option<f64>,
        number: usize,
    ) -> usize {
        let Candidate { node, fit } = candidate;
        let before = self.graph.poses[number];
        self.correct(self.places[*node].first_visit, number, fit);
        let off_m = (before.translation.vector - self.graph.poses[number].translation.vector).norm();
        let second = runner_up.map_or_else(String::new, |share| format!(", on the next likely place by {share:.2}"));
        let share = fit.share;
        let why = format!("its walls lie on those of node {node} by {share:.2}{second}; the drift was {off_m:.1} m");
        self.map.merges.push(Decided { node: *node, at_ns: visit.time_ns[1], score: share, runner_up, why });
        *node
    }

    /// Corrects all poses: visit `to` was where `fit` says, as seen from visit `from`.
    fn correct(&mut self, from: usize, to: usize, fit: &Fit) {
        self.graph.edges.push(Constraint { from, to, measured: fit.pose, information: information(0.1, 0.02) });
        self.flown.push(Leg { is_measured: true, sd_m: Some(0.0), heading_rad2: 0.0 });
        // Every pose is joined to the one before, so that the edges determine all of them.
        self.graph.solve().ok();
        self.place_nodes();
    }

    /// Nodes lie where their first visit does, and their ways as they were seen then.
    fn place_nodes(&mut self) {
        for (node, place) in self.map.nodes.iter_mut().zip(&self.places) {
            let pose = self.graph.poses[place.first_visit];
            node.position_m = Point2::from(pose.translation.vector);
            for (way, &bearing_rad) in node.ways.iter_mut().zip(&place.ways_rad) {
                way.bearing_rad = wrap_angle_rad(bearing_rad + pose.rotation.angle());
            }
        }
    }

    /// The number of ways that is believed most, over all visits of a node, holds: one may have missed a way.
    pub(super) fn count_ways(&mut self, node: usize, visit: &Visit, turned_rad: f64) {
        let place = &mut self.places[node];
        *place.belief.entry(visit.ways.len()).or_default() += visit.belief;
        let most = place.belief.iter().max_by(|a, b| a.1.total_cmp(b.1)).map(|(ways, _)| *ways);
        if most != Some(visit.ways.len()) || visit.ways.len() == place.ways_rad.len() {
            return;
        }
        let ways_rad: Vec<f64> = visit.ways.iter().map(|way| wrap_angle_rad(way.bearing_rad + turned_rad)).collect();
        let mut ways: Vec<NodeWay> = visit.ways.iter().map(|way| new_way(way.bearing_rad, way.width_m)).collect();
        let mut moved = BTreeMap::new();
        for (at, way) in self.map.nodes[node].ways.iter().enumerate() {
            let direction_rad = place.ways_rad[at];
            let same = nearest_way(&ways_rad, direction_rad);
            let same = same.filter(|&same| wrap_angle_rad(ways_rad[same] - direction_rad).abs() < SAME_WAY_RAD);
            match same.filter(|same| !moved.values().any(|other| other == same)) {
                Some(same) => {
                    (ways[same].taken, ways[same].passage) = (way.taken, way.passage);
                    moved.insert(at, same);
                }
                None if way.taken => return, // what was flown is certain
                None => {}
            }
        }
        if let Some(last) = self.last.as_mut().filter(|last| last.node == node) {
            let Some(&way) = moved.get(&last.way) else { return };
            last.way = way;
        }
        place.ways_rad = ways_rad;
        self.map.nodes[node].ways = ways;
        self.place_nodes();
    }

    /// The way of a node in a direction in which the vehicle flew, in the frame of its first visit. What was flown is certain: if a
    /// junction has no way there, the visits have missed it.
    pub(super) fn flown_way(&mut self, node: usize, direction_rad: f64) -> usize {
        let place = &mut self.places[node];
        let off_rad = |way: &usize| wrap_angle_rad(place.ways_rad[*way] - direction_rad).abs();
        let nearest = nearest_way(&place.ways_rad, direction_rad);
        let is_known = nearest.is_some_and(|way| off_rad(&way) <= FLOWN_WAY_RAD);
        if let Some(way) = nearest.filter(|_| is_known || self.map.nodes[node].kind != HereKind::Junction) {
            return way;
        }
        let behind_rad = |way: &usize| (direction_rad - place.ways_rad[*way]).rem_euclid(TAU);
        let before = (0..place.ways_rad.len()).min_by(|a, b| behind_rad(a).total_cmp(&behind_rad(b)));
        let at = before.map_or(0, |before| before + 1);
        place.ways_rad.insert(at, wrap_angle_rad(direction_rad));
        let ways = &mut self.map.nodes[node].ways;
        let narrowest_m = ways.iter().map(|way| way.width_m).min_by(f64::total_cmp).unwrap_or_default();
        ways.insert(at, new_way(direction_rad, self.way.width_m().unwrap_or(narrowest_m)));
        if let Some(last) = self.last.as_mut().filter(|last| last.node == node && last.way >= at) {
            last.way += 1;
        }
        self.place_nodes();
        at
    }

    /// Whether a node was seen on one stay alone.
    pub(super) fn is_new(&self, node: usize) -> bool {
        self.map.merges.iter().all(|merge| merge.node != node)
    }

    /// After a correction, nodes that turn out to be one: those that lie on each other. `node` is followed to its number.
    pub(super) fn reconsider(&mut self, mut node: usize) -> usize {
        while let Some((from, candidate, runner_up)) = self.one_of_two() {
            let into = candidate.node;
            let share = candidate.fit.share;
            self.correct(self.places[into].first_visit, self.places[from].first_visit, &candidate.fit);
            let at_ns = self.map.nodes[from].visits.last().map_or(0, |visit| visit[1]);
            let why =
                format!("after the correction the walls of node {from} lie on its own by {share:.2}: they are one");
            self.map.merges.push(Decided { node: into, at_ns, score: share, runner_up, why });
            let kept = self.absorb_turned(from, into, candidate.fit.pose.rotation.angle());
            node = match node {
                same if same == from => kept,
                later if later > from => later - 1,
                earlier => earlier,
            };
        }
        node
    }

    /// A node that lies on an earlier one by its walls, better than on any other.
    fn one_of_two(&self) -> Option<(usize, Candidate, Option<f64>)> {
        (1..self.places.len()).rev().find_map(|from| {
            let of = &self.places[from];
            let mut near = (0..from).filter(|&into| self.may_be_one(from, into)).collect::<Vec<_>>();
            if !near.is_empty() {
                // Where no way that is known leads, places lie near to each other by nothing but a guess.
                let flown = flown_to(&self.graph, &self.flown, of.first_visit);
                near.retain(|&into| flown[self.places[into].first_visit].sd_m.is_some());
            }
            let fits = near.into_iter().filter_map(|node| {
                let place = &self.places[node];
                let apart = self.graph.poses[place.first_visit].inv_mul(&self.graph.poses[of.first_visit]);
                place.walls.fit(&of.walls, &apart).map(|fit| Candidate { node, fit })
            });
            let mut candidates: Vec<Candidate> = fits.collect();
            candidates.sort_by(|a, b| b.fit.share.total_cmp(&a.fit.share));
            let mut candidates = candidates.into_iter();
            let best = candidates.next().filter(|best| best.fit.share >= LEAST_SHARE)?;
            let runner_up = candidates.next().map(|other| other.fit.share);
            let has_clear_lead = runner_up.is_none_or(|share| best.fit.share - share >= LEAST_LEAD);
            has_clear_lead.then_some((from, best, runner_up))
        })
    }

    /// Whether two nodes lie so near to each other that they may be one, and no passage leads from one to the other.
    fn may_be_one(&self, a: usize, b: usize) -> bool {
        let (node, other) = (&self.map.nodes[a], &self.map.nodes[b]);
        let ends = |passage: &super::Passage| [passage.from, passage.to];
        node.kind == other.kind
            && (node.position_m - other.position_m).norm() < RECONSIDERED_M
            && !self.map.passages.iter().any(|passage| ends(passage) == [a, b] || ends(passage) == [b, a])
    }

    /// Makes node `from` a part of node `into`, and returns the number of that.
    pub(super) fn absorb(&mut self, from: usize, into: usize) -> usize {
        let [first, other] = [into, from].map(|node| self.graph.poses[self.places[node].first_visit]);
        self.absorb_turned(from, into, first.inv_mul(&other).rotation.angle())
    }

    /// Makes node `from` a part of node `into`, whose frame `turned_rad` brings directions of `from` into.
    fn absorb_turned(&mut self, from: usize, into: usize, turned_rad: f64) -> usize {
        let (gone, place) = (self.map.nodes.remove(from), self.places.remove(from));
        let into = if into > from { into - 1 } else { into };
        let moved = |node: usize| match node {
            same if same == from => into,
            later if later > from => later - 1,
            earlier => earlier,
        };
        let ways_rad = &self.places[into].ways_rad;
        let way_into: Vec<usize> =
            place.ways_rad.iter().map(|rad| nearest_way(ways_rad, rad + turned_rad).unwrap_or(0)).collect();
        for passage in &mut self.map.passages {
            (passage.from, passage.to) = (moved(passage.from), moved(passage.to));
        }
        for (at, way) in gone.ways.iter().enumerate() {
            if let Some(kept) = self.map.nodes[into].ways.get_mut(way_into[at]) {
                kept.taken |= way.taken;
                kept.passage = kept.passage.or(way.passage);
            }
        }
        for decided in self.map.merges.iter_mut().chain(&mut self.map.refusals) {
            decided.node = moved(decided.node);
        }
        for guessed in self.guesses.iter_mut().map(|guess| &mut guess.node) {
            *guessed = moved(*guessed);
        }
        if let Some(last) = &mut self.last {
            if last.node == from {
                last.way = way_into.get(last.way).copied().unwrap_or(0);
            }
            last.node = moved(last.node);
        }
        if gone.kind == self.map.nodes[into].kind {
            place.belief.into_iter().for_each(|(ways, of)| *self.places[into].belief.entry(ways).or_default() += of);
        }
        self.map.nodes[into].visits.extend(gone.visits);
        self.map.nodes[into].visits.sort_unstable();
        self.drop_passages_twice();
        into
    }
}

fn new_way(bearing_rad: f64, width_m: f64) -> NodeWay {
    NodeWay { bearing_rad, width_m, taken: false, passage: None }
}
