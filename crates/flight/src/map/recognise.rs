//! Whether a visit is to a place seen before.

use std::f64::consts::PI;

use nalgebra::Isometry2;

use crosscut_stage::wrap_angle_rad;

use super::Decided;
use super::candidate::{ANCHORS_M, Best, Candidate, WAYS_APART_RAD, best, turns_rad};
use super::derived::Derived;
use super::legs::flown_to;
use super::log::{Known, Link, Log, flown_sd_m};
use super::outline::{APART_M, Fit};
use super::stretch::Guesses;
use crate::HereKind;

/// Two anchors of one place are at most this many looks apart, or [`ANCHORS_M`] if that is more, and [`DEVIATIONS`]
/// more.
const ANCHORS_LOOKS: f64 = 0.75;

/// Poses are off by at most this many standard deviations. Those of all legs since a place add up: a heading error
/// moves everything after it.
const DEVIATIONS: f64 = 3.0;

/// Headings are known to within this, and within [`DEVIATIONS`] of the pose more.
const HEADING_RAD: f64 = 0.15;

/// The way flown along a known passage differs from its length by less than this, and [`LENGTH_OFF_SHARE`] of the
/// length more.
const LENGTH_OFF_M: f64 = 2.0;

/// The way flown along a known passage differs from its length by less than this share of it, and [`LENGTH_OFF_M`]
/// more.
const LENGTH_OFF_SHARE: f64 = 0.15;

/// Below this share an outline is no reason to think of a place.
const WORTH_NOTING: f64 = 0.55;

impl Guesses {
    /// Links the latest visit, which is not yet on `map`, to the node that it is to, other than `but`. The result is that node;
    /// `None` if the visit is to none that is known, or if two are alike.
    pub(super) fn recognise(&mut self, log: &mut Log, map: &Derived, but: Option<usize>) -> Option<usize> {
        let number = log.visits.len() - 1;
        let (visit, predicted) = (&log.visits[number], log.graph.poses[number]);
        let (mut candidates, expected): (Vec<Candidate>, _) = (Vec::new(), expected(log, map));
        let bearings_rad = visit.bearings_rad();
        let flown = flown_to(log, number);
        let mut is_known_from_all = true;
        for (node, place) in map.places.iter().enumerate() {
            let Known { sd_m, heading_rad2, .. } = flown[place.first];
            let Some(sd_m) = sd_m else {
                is_known_from_all = false;
                continue;
            };
            if map.map.nodes[node].kind != visit.kind || Some(node) == but {
                continue;
            }
            let apart = log.graph.poses[place.first].inv_mul(&predicted);
            let anchors_m = ANCHORS_M.max(ANCHORS_LOOKS * visit.look_m);
            if apart.translation.vector.norm() > anchors_m + DEVIATIONS * sd_m {
                continue;
            }
            // A fit reaches no farther than `APART_M`: all of `anchors_m` on the side where the pose takes the anchor
            // to be.
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
                let about = Isometry2::new(about_m, yaw_rad);
                let fits = log.visits[place.first].walls.fits(&visit.walls, about);
                let fits = fits.filter(|fit| is_likely(&fit.pose.rotation.angle()));
                candidates.extend(fits.map(|fit| Candidate::new(node, fit, &apart, sd_m, Some(node) == expected)));
            }
        }
        let mut found = decide(log, map, candidates);
        if found.is_none() && !is_known_from_all {
            found = self.place_stretch(log, map, &flown, but).map(|candidate| (candidate, None));
        }
        let (Candidate { node, fit, .. }, runner_up) = found?;
        let (visits, score) = ([map.places[node].first, number], fit.share);
        log.fit(visits, &fit);
        let off_m = (predicted.translation.vector - log.graph.poses[number].translation.vector).norm();
        let second = runner_up.map_or_else(String::new, |share| format!(", on the next likely place by {share:.2}"));
        let why = format!("its walls lie on those of node {node} by {score:.2}{second}; the drift was {off_m:.1} m");
        let decided = Decided { node, at_ns: log.visits[number].time_ns[1], score, runner_up, why };
        log.links.push(Link { visits, decided });
        Some(node)
    }
}

/// The place that the latest visit is to, of these. Refuses one that the visit merely looks like.
fn decide(log: &mut Log, map: &Derived, candidates: Vec<Candidate>) -> Option<Best> {
    let (found, is_clear) = best(candidates)?;
    let (Candidate { node, fit: Fit { share: score, .. }, .. }, runner_up) = found;
    if is_clear {
        return Some(found);
    }
    if score >= WORTH_NOTING {
        let but = match runner_up {
            Some(second) => format!("and on the next likely place by {second:.2}"),
            None => "too little for where the poses have it".to_owned(),
        };
        let why = format!("a new node: its walls lie on those of node {node} by {score:.2}, {but}");
        let visit = log.visits.len() - 1;
        let decided = Decided { node, at_ns: log.visits[visit].time_ns[1], score, runner_up, why };
        log.refusals.push(Link { visits: [map.places[node].first, visit], decided });
    }
    None
}

/// The node that a known passage leads to, if the vehicle came to the latest visit by one and has flown its length.
fn expected(log: &Log, map: &Derived) -> Option<usize> {
    let (from, passage) = map.left_through()?;
    let [.., last, visit] = &log.visits[..] else { return None };
    flown_sd_m(last, visit)?;
    let off_m = (visit.reached_at_m - last.left_at_m - passage.length_m).abs();
    let is_at_its_end = off_m < LENGTH_OFF_M + LENGTH_OFF_SHARE * passage.length_m;
    is_at_its_end.then_some(if passage.from == from { passage.to } else { passage.from })
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use nalgebra::{Point2, Unit, Vector2};

    use super::*;
    use crate::Way;
    use crate::line_points::LinePoint;
    use crate::map::outline::Walls;
    use crate::map::visit::Visit;

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
            let visit = |side: f64, at_m: f64| Visit {
                kind: HereKind::DeadEnd,
                has_middle: true,
                time_ns: [at_m as u64, at_m as u64 + 1],
                anchor: Isometry2::identity(),
                ways: vec![Way { bearing_rad: way_rad(side), width_m: 5.0, opening: None }],
                look_m: 7.5,
                walls: Arc::new(Walls::new(&dead_end(side))),
                reached_at_m: at_m,
                left_at_m: at_m,
                belief: 8.0,
                came_from: Point2::origin(),
                left_to: Point2::origin(),
                has_come: false,
                doubts: Default::default(),
            };
            let mut log = Log::default();
            log.visit(visit(-1.0, 0.0), true);
            let map = Derived::of(&log);
            log.visit(visit(side, 300.0), true);
            let [walls, again] = [0, 1].map(|visit| &log.visits[visit].walls);
            let alike = walls.fit(again, &Isometry2::identity()).expect("both have walls").share;
            assert!(alike > 0.9, "the walls beside them are alike: {alike}");
            let found = Guesses::default().recognise(&mut log, &map, None);
            assert_eq!(found.is_some(), is_same, "open towards {side} x");
        }
    }
}
