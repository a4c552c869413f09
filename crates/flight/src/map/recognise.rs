//! Whether a visit is to a place seen before.

use std::f64::consts::PI;
use std::sync::Arc;

use nalgebra::Isometry2;

use crosscut_stage::wrap_angle_rad;

use super::Decided;
use super::candidate::{ANCHORS_M, Candidate, WAYS_APART_RAD, turns_rad};
use super::draft::{Draft, Stray};
use super::legs::{Leg, flown_to};
use super::outline::{APART_M, Fit, Walls};
use super::visit::Visit;
use crate::HereKind;

/// Two anchors of one place are at most this many looks apart, or [`ANCHORS_M`] if that is more, and [`DEVIATIONS`] more.
const ANCHORS_LOOKS: f64 = 0.75;

/// Poses are off by at most this many standard deviations. Those of all legs since a place add up: a heading error moves
/// everything after it.
const DEVIATIONS: f64 = 3.0;

/// Headings are known to within this, and within [`DEVIATIONS`] of the pose more.
const HEADING_RAD: f64 = 0.15;

/// Outlines of one place lie on each other by at least this share of their line points.
pub(super) const LEAST_SHARE: f64 = 0.72;

/// The outline of a visit lies on that of its place by this much more of its line points than on any other place.
pub(super) const LEAST_LEAD: f64 = 0.08;

/// This share is enough for the place at the end of a known passage whose length the vehicle has flown.
const EXPECTED_SHARE: f64 = 0.55;

/// The share of the place at the end of a known passage is at most this much less than that of any other place.
const EXPECTED_BEHIND: f64 = 0.08;

/// The way flown along a known passage differs from its length by less than this, and [`LENGTH_OFF_SHARE`] of the length more.
const LENGTH_OFF_M: f64 = 2.0;

/// The way flown along a known passage differs from its length by less than this share of it, and [`LENGTH_OFF_M`] more.
const LENGTH_OFF_SHARE: f64 = 0.15;

/// Below this share an outline is no reason to think of a place.
const WORTH_NOTING: f64 = 0.55;

impl Draft {
    /// The node that a visit is to, other than `but`, and the share of the runner-up; `None` if it is to none, or if two are alike.
    pub(super) fn recognise(
        &mut self,
        visit: &Visit,
        walls: &Arc<Walls>,
        predicted: &Isometry2<f64>,
        but: Option<usize>,
    ) -> Option<(Candidate, Option<f64>)> {
        let mut candidates: Vec<Candidate> = Vec::new();
        let bearings_rad: Vec<f64> = visit.ways.iter().map(|way| way.bearing_rad).collect();
        let flown = self
            .graph
            .poses
            .len()
            .checked_sub(1)
            .map_or_else(Vec::new, |last| flown_to(&self.graph, &self.flown, last));
        let mut is_known_from_all = true;
        for (node, place) in self.places.iter().enumerate() {
            let Leg { sd_m, heading_rad2, .. } = flown[place.first_visit];
            let Some(sd_m) = sd_m else {
                is_known_from_all = false;
                continue;
            };
            if self.map.nodes[node].kind != visit.kind || Some(node) == but {
                continue;
            }
            let apart = self.graph.poses[place.first_visit].inv_mul(predicted);
            let anchors_m = ANCHORS_M.max(ANCHORS_LOOKS * visit.look_m);
            if apart.translation.vector.norm() > anchors_m + DEVIATIONS * sd_m {
                continue;
            }
            // A fit reaches no farther than `APART_M`: all of `anchors_m` on the side where the pose takes the anchor to be.
            let about_m = apart.translation.vector.cap_magnitude((anchors_m - APART_M).max(0.0));
            let yaw_off_rad = (HEADING_RAD + DEVIATIONS * heading_rad2.sqrt()).min(PI);
            // A way may have been missed on one of the visits: then the walls alone tell. A dead end has but one.
            let predicted_rad = apart.rotation.angle();
            let off_rad = |yaw_rad: f64| wrap_angle_rad(yaw_rad - predicted_rad).abs();
            let is_likely = |yaw_rad: &f64| off_rad(*yaw_rad) <= yaw_off_rad;
            let turns = || turns_rad(&bearings_rad, &place.ways_rad);
            let is_turned = |turn_rad: f64| off_rad(turn_rad) > yaw_off_rad + WAYS_APART_RAD;
            if visit.kind == HereKind::DeadEnd && turns().all(is_turned) {
                continue;
            }
            for yaw_rad in turns().filter(is_likely).chain([predicted_rad]) {
                let fit = place.walls.fit(walls, &Isometry2::new(about_m, yaw_rad));
                let fit = fit.filter(|fit| is_likely(&fit.pose.rotation.angle()));
                candidates.extend(fit.map(|fit| Candidate { node, fit }));
            }
        }
        let decided = self.decide(visit, candidates);
        if decided.is_some() || is_known_from_all {
            return decided;
        }
        let stray = Stray { kind: visit.kind, anchor: visit.anchor, bearings_rad, walls: Arc::clone(walls) };
        self.place_stretch(stray, &self.elsewhere(&flown, but)).map(|candidate| (candidate, None))
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
        let has_clear_lead = runner_up.is_none_or(|share| best.fit.share - share >= LEAST_LEAD);
        if at.is_none() && (best.fit.share < LEAST_SHARE || !has_clear_lead) {
            self.refuse(visit, &best, runner_up);
            return None;
        }
        Some((best, runner_up))
    }

    /// The node that a known passage leads to, if the vehicle came by one and has flown its length.
    fn expected(&self, visit: &Visit) -> Option<usize> {
        let last = self.last.as_ref()?;
        self.flown_sd_m(last, visit)?;
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
        self.map.refusals.push(Decided { node, at_ns: visit.time_ns[1], score, runner_up, why });
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;
    use std::sync::Arc;

    use nalgebra::{Point2, Unit, Vector2};

    use super::*;
    use crate::Way;
    use crate::line_points::LinePoint;
    use crate::map::draft::NodeMemory;
    use crate::map::{Node, NodeWay};

    /// Line points of a dead end that is 5 m wide, open towards -x or +x (`side`: -1 or 1), every 0.1 m.
    fn dead_end(side: f64) -> Vec<LinePoint> {
        let point = |x_m: f64, y_m: f64, normal: Vector2<f64>| LinePoint {
            position_m: Point2::new(x_m, y_m),
            normal: Unit::new_normalize(normal),
            tilt_rad2: 0.0,
        };
        let along = (-40..90).map(|at| 0.1 * f64::from(at) * side);
        let sides = along.flat_map(|x_m| [-2.5, 2.5].map(|y_m| point(x_m, y_m, Vector2::y())));
        let face = (-25..25).map(|at| point(-4.0 * side, 0.1 * f64::from(at), Vector2::x()));
        sides.chain(face).collect()
    }

    fn way_rad(side: f64) -> f64 {
        if side > 0.0 { 0.0 } else { PI }
    }

    #[test]
    fn a_dead_end_that_opens_the_other_way_is_another_one() {
        for (side, is_same) in [(-1.0, true), (1.0, false)] {
            let mut draft = Draft::default();
            draft.graph.poses = vec![Isometry2::identity()];
            let way = NodeWay { bearing_rad: way_rad(-1.0), width_m: 5.0, taken: true, passage: None };
            draft.map.nodes = vec![Node {
                kind: HereKind::DeadEnd,
                position_m: Point2::origin(),
                ways: vec![way],
                visits: vec![[0, 1]],
            }];
            let (walls, ways_rad) = (Arc::new(Walls::new(&dead_end(-1.0))), vec![way_rad(-1.0)]);
            draft.places = vec![NodeMemory { walls, ways_rad, first_visit: 0, belief: BTreeMap::new() }];
            let outline = dead_end(side);
            let walls = Arc::new(Walls::new(&outline));
            let visit = Visit {
                kind: HereKind::DeadEnd,
                has_middle: true,
                time_ns: [2, 3],
                anchor: Isometry2::identity(),
                ways: vec![Way { bearing_rad: way_rad(side), width_m: 5.0, opening: None }],
                look_m: 7.5,
                outline,
                reached_at_m: 300.0,
                left_at_m: 300.0,
                belief: 8.0,
                came_from: Point2::origin(),
                left_to: Point2::origin(),
            };
            let alike = draft.places[0].walls.fit(&walls, &Isometry2::identity()).expect("both have walls").share;
            assert!(alike > LEAST_SHARE, "the walls beside them are alike: {alike}");
            let found = draft.recognise(&visit, &walls, &Isometry2::identity(), None);
            assert_eq!(found.is_some(), is_same, "open towards {side} x");
        }
    }
}
