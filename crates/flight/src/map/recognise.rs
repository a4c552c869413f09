//! Whether a visit is to a place seen before.

use std::collections::VecDeque;
use std::f64::consts::PI;

use nalgebra::Isometry2;

use crosscut_stage::wrap_angle_rad;

use super::outline::{Fit, Walls};
use super::visit::Visit;
use super::{Mapper, Refusal};

/// Poses are known to within this, and a share of the way from the place: the shortest one over all that was flown, as what
/// is seen again ties poses together.
const DRIFT_M: f64 = 2.5;
const DRIFT_SHARE: f64 = 0.06;

/// Headings are known to within this, and by this much less for each metre of the way since.
const DRIFT_RAD: f64 = 0.15;
const DRIFT_RAD_PER_M: f64 = 0.003;

/// The directions of the ways of one place agree to within this.
const WAYS_APART_RAD: f64 = 0.6;

/// Outlines of one place lie on each other by this share of their line points, and by this much better than on any other place.
pub(super) const LEAST_SHARE: f64 = 0.72;
pub(super) const LEAST_LEAD: f64 = 0.08;

/// For the place that a known passage leads to, less is enough: by its length, within these, the vehicle is at its end.
const EXPECTED_SHARE: f64 = 0.55;
const EXPECTED_BEHIND: f64 = 0.08;
const LENGTH_OFF_M: f64 = 2.0;
const LENGTH_OFF_SHARE: f64 = 0.15;

/// Below this share an outline is no reason to think of a place.
const WORTH_NOTING: f64 = 0.55;

/// Two fits on one node that differ by less are the same.
const SAME_M: f64 = 1.5;
const SAME_RAD: f64 = 0.4;

/// A place that a visit may be to.
pub(super) struct Candidate {
    pub(super) node: usize,
    pub(super) fit: Fit,
}

impl Mapper {
    /// The node that a visit is to, and the share of the runner-up; `None` if it is to none, or if two are alike.
    pub(super) fn recognise(
        &mut self,
        visit: &Visit,
        walls: &Walls,
        predicted: &Isometry2<f64>,
    ) -> Option<(Candidate, Option<f64>)> {
        let mut candidates: Vec<Candidate> = Vec::new();
        let ways_m = self.ways_to_last_m();
        for (node, place) in self.places.iter().enumerate() {
            if self.map.nodes[node].kind != visit.kind {
                continue;
            }
            let since_m = ways_m[place.first_visit];
            let apart = self.graph.poses[place.first_visit].inv_mul(predicted);
            if apart.translation.vector.norm() > DRIFT_M + DRIFT_SHARE * since_m {
                continue;
            }
            let yaw_off_rad = (DRIFT_RAD + DRIFT_RAD_PER_M * since_m).min(PI);
            // A way may have been missed on one of the visits: then the walls alone tell.
            let predicted_rad = apart.rotation.angle();
            let is_likely = |yaw_rad: &f64| wrap_angle_rad(yaw_rad - predicted_rad).abs() <= yaw_off_rad;
            let turns = (0..visit.ways.len()).filter_map(|shift| turn_rad(visit, &place.ways_rad, shift));
            for yaw_rad in turns.filter(is_likely).chain([predicted_rad]) {
                candidates.extend(place.walls.fit(walls, yaw_rad).map(|fit| Candidate { node, fit }));
            }
        }
        self.decide(visit, candidates)
    }

    /// The shortest way from each visit to the last one, over edges of the graph. One that is not joined is infinitely far.
    fn ways_to_last_m(&self) -> Vec<f64> {
        let mut ways_m = vec![f64::INFINITY; self.graph.poses.len()];
        let mut joined: Vec<Vec<(usize, f64)>> = vec![Vec::new(); ways_m.len()];
        for (edge, &way_m) in self.graph.edges.iter().zip(&self.edge_ways_m) {
            joined[edge.from].push((edge.to, way_m));
            joined[edge.to].push((edge.from, way_m));
        }
        let Some(last) = ways_m.len().checked_sub(1) else { return ways_m };
        ways_m[last] = 0.0;
        // Bellman and Ford's queue: few visits have more than two edges.
        let mut changed = VecDeque::from([last]);
        while let Some(at) = changed.pop_front() {
            for &(to, way_m) in &joined[at] {
                if ways_m[at] + way_m < ways_m[to] {
                    ways_m[to] = ways_m[at] + way_m;
                    changed.push_back(to);
                }
            }
        }
        ways_m
    }

    fn decide(&mut self, visit: &Visit, mut candidates: Vec<Candidate>) -> Option<(Candidate, Option<f64>)> {
        candidates.sort_by(|a, b| b.fit.share.total_cmp(&a.fit.share));
        let most = candidates.first()?.fit.share;
        let expected = self.expected(visit);
        let is_expected = |candidate: &Candidate| {
            let Fit { share, .. } = candidate.fit;
            Some(candidate.node) == expected && share >= EXPECTED_SHARE && most - share <= EXPECTED_BEHIND
        };
        let at = candidates.iter().position(is_expected);
        let best = candidates.remove(at.unwrap_or(0));
        let runner_up = candidates.iter().find(|other| other.is_elsewhere(&best)).map(|other| other.fit.share);
        let leads = runner_up.is_none_or(|share| best.fit.share - share >= LEAST_LEAD);
        if at.is_none() && (best.fit.share < LEAST_SHARE || !leads) {
            self.refuse(visit, &best, runner_up);
            return None;
        }
        Some((best, runner_up))
    }

    /// The node that a known passage leads to, if the vehicle came by one and has flown its length.
    fn expected(&self, visit: &Visit) -> Option<usize> {
        let last = self.last?;
        let passage = &self.map.passages[self.map.nodes[last.node].ways[last.way].passage?];
        let off_m = (visit.reached_at_m - last.at_m - passage.length_m).abs();
        let is_at_its_end = off_m < LENGTH_OFF_M + LENGTH_OFF_SHARE * passage.length_m;
        is_at_its_end.then_some(if passage.from == last.node { passage.to } else { passage.from })
    }

    fn refuse(&mut self, visit: &Visit, best: &Candidate, runner_up: Option<f64>) {
        let (node, score) = (best.node, best.fit.share);
        if score < WORTH_NOTING {
            return;
        }
        let but = match runner_up {
            Some(second) if score >= LEAST_SHARE => format!("and on the next likely place by {second:.2}"),
            _ => format!("too little of {LEAST_SHARE}"),
        };
        let why = format!("a new node: its walls lie on those of node {node} by {score:.2}, {but}");
        self.map.refusals.push(Refusal { node, at_ns: visit.time_ns[1], score, runner_up, why });
    }
}

impl Candidate {
    /// It is another place than `other`, or the same one turned.
    pub(super) fn is_elsewhere(&self, other: &Self) -> bool {
        let apart = self.fit.pose.inv_mul(&other.fit.pose);
        let is_same = apart.rotation.angle().abs() < SAME_RAD && apart.translation.vector.norm() < SAME_M;
        self.node != other.node || !is_same
    }
}

/// The turn that brings the ways of a visit onto those of a node, way i onto way i + `shift`; `None` if they do not
/// agree.
fn turn_rad(visit: &Visit, ways_rad: &[f64], shift: usize) -> Option<f64> {
    let ways = visit.ways.len();
    if ways != ways_rad.len() {
        return None;
    }
    let off_rad = |i: usize| ways_rad[(i + shift) % ways] - visit.ways[i].bearing_rad;
    let first_rad = off_rad(0);
    let mean_rad = first_rad + (0..ways).map(|i| wrap_angle_rad(off_rad(i) - first_rad)).sum::<f64>() / ways as f64;
    let agree = (0..ways).all(|i| wrap_angle_rad(off_rad(i) - mean_rad).abs() <= WAYS_APART_RAD);
    agree.then(|| wrap_angle_rad(mean_rad))
}
