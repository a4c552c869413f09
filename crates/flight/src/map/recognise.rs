//! Whether a visit is to a place seen before.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::f64::consts::PI;
use std::sync::Arc;

use nalgebra::{Isometry2, Point2};

use crosscut_stage::wrap_angle_rad;

use super::mapper::Flown;
use super::outline::{APART_M, Fit, Walls};
use super::visit::Visit;
use super::{Mapper, Refusal};
use crate::HereKind;

/// Anchors of one place lie within this of each other, and within this many looks; within this many standard deviations of
/// the pose more. Those of all that was flown since the place add up, as a heading that is off is so for all that follows.
const ANCHORS_M: f64 = 2.5;
const ANCHORS_LOOKS: f64 = 0.75;
const DEVIATIONS: f64 = 3.0;

/// Headings are known to within this, and within [`DEVIATIONS`] of the pose more.
const HEADING_RAD: f64 = 0.15;

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

/// A place to which no known way leads is thought of from this share on.
const GUESSED_SHARE: f64 = 0.85;

/// This many other places have to agree, and this many more than on the stretch lying elsewhere: along a row of places that look
/// alike, shifted by one, all but one agree.
const AGREED_PLACES: usize = 2;
const AGREED_LEAD: usize = 2;

/// Where two visits take a stretch to lie agrees within this.
const AGREED_RAD: f64 = 0.15;

/// Where a stretch lies if a visit of it was to a node.
#[derive(Clone, Copy, Debug)]
pub(super) struct Guess {
    pub(super) node: usize,
    /// The number of the node's [group](Mapper::groups): how the places of two groups lie to each other is not known, so that
    /// they do not agree.
    group: usize,
    /// Brings tracked poses into the map's frame.
    stretch: Isometry2<f64>,
}

/// A visit to a place that was not recognised, as it is compared with places of other groups.
#[derive(Clone, Debug)]
pub(super) struct Stray {
    kind: HereKind,
    anchor: Isometry2<f64>,
    bearings_rad: Vec<f64>,
    walls: Arc<Walls>,
}

/// Places of other groups than that of a visit.
#[derive(Default)]
struct Elsewhere {
    /// Each with its group. Of groups that have enough places to show where a stretch lies.
    many: Vec<(usize, usize)>,
    /// Of groups of [`AGREED_PLACES`], which may but contradict: what one of these would have, the stretch has to have more of.
    pairs: Vec<(usize, usize)>,
}

/// A place that a visit may be to.
pub(super) struct Candidate {
    pub(super) node: usize,
    pub(super) fit: Fit,
}

impl Mapper {
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
        let flown = self.graph.poses.len().checked_sub(1).map_or_else(Vec::new, |last| self.flown_to(last));
        let mut is_known_from_all = true;
        for (node, place) in self.places.iter().enumerate() {
            let Flown { sd_m, heading_rad2, .. } = flown[place.first_visit];
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
        self.agreed(stray, &self.elsewhere(&flown, but)).map(|candidate| (candidate, None))
    }

    /// The places to which no known way leads.
    fn elsewhere(&self, flown: &[Flown], but: Option<usize>) -> Elsewhere {
        let groups = self.groups();
        let mut sizes: BTreeMap<usize, usize> = BTreeMap::new();
        for place in &self.places {
            *sizes.entry(groups[place.first_visit]).or_default() += 1;
        }
        let mut elsewhere = Elsewhere::default();
        for (node, place) in self.places.iter().enumerate() {
            if Some(node) == but || flown[place.first_visit].sd_m.is_some() {
                continue;
            }
            let group = groups[place.first_visit];
            match sizes[&group] {
                more if more > AGREED_PLACES => elsewhere.many.push((node, group)),
                AGREED_PLACES => elsewhere.pairs.push((node, group)),
                _ => {}
            }
        }
        elsewhere
    }

    /// For each visit the number of its group: within a group it is measured how visits lie to each other.
    fn groups(&self) -> Vec<usize> {
        let mut groups: Vec<usize> = (0..self.graph.poses.len()).collect();
        for (edge, _) in self.graph.edges.iter().zip(&self.flown).filter(|(_, flown)| flown.is_measured) {
            let first = |mut visit: usize| {
                while groups[visit] != visit {
                    visit = groups[visit];
                }
                visit
            };
            let [from, to] = [edge.from, edge.to].map(first);
            groups[from.max(to)] = from.min(to);
        }
        for visit in 0..groups.len() {
            groups[visit] = groups[groups[visit]];
        }
        groups
    }

    /// The best known way from each visit to one of them, over edges of the graph; infinite where there is none that is known.
    pub(super) fn flown_to(&self, visit: usize) -> Vec<Flown> {
        let unknown = Flown { is_measured: false, sd_m: None, heading_rad2: 0.0 };
        let mut flown = vec![unknown; self.graph.poses.len()];
        let mut joined: Vec<Vec<(usize, f64, f64)>> = vec![Vec::new(); flown.len()];
        for (edge, of) in self.graph.edges.iter().zip(&self.flown) {
            if let Some(sd_m) = of.sd_m {
                joined[edge.from].push((edge.to, sd_m, of.heading_rad2));
                joined[edge.to].push((edge.from, sd_m, of.heading_rad2));
            }
        }
        flown[visit] = Flown { is_measured: true, sd_m: Some(0.0), heading_rad2: 0.0 };
        // Bellman and Ford's queue: few visits have more than two edges.
        let mut changed = VecDeque::from([visit]);
        while let Some(at) = changed.pop_front() {
            let Flown { sd_m: Some(sd_m), heading_rad2, .. } = flown[at] else { continue };
            for &(to, more_m, more_rad2) in &joined[at] {
                if flown[to].sd_m.is_none_or(|known_m| sd_m + more_m < known_m) {
                    let heading_rad2 = heading_rad2 + more_rad2;
                    flown[to] = Flown { is_measured: true, sd_m: Some(sd_m + more_m), heading_rad2 };
                    changed.push_back(to);
                }
            }
        }
        flown
    }

    /// Of places that a visit may be to although no known way leads there: the one that agrees with what other visits since
    /// may have been to. Three places in their right relation are no chance, unless places stand in a row; one may look like many.
    fn agreed(&mut self, visit: Stray, elsewhere: &Elsewhere) -> Option<Candidate> {
        let place_m = Point2::from(visit.anchor.translation.vector);
        let (candidates, made): (Vec<Candidate>, Vec<Guess>) =
            self.resembling(&visit, &elsewhere.many).into_iter().unzip();
        let agrees = |of: &&Guess| self.agreeing(of, &place_m) >= AGREED_PLACES;
        let found = match made.iter().enumerate().filter(|(_, of)| agrees(of)).collect::<Vec<_>>()[..] {
            [(at, of)] => {
                let strays = std::mem::take(&mut self.strays);
                let rivals = strays.iter().flat_map(|stray| self.resembling(stray, &elsewhere.pairs));
                let rivals: Vec<Guess> = rivals.map(|(_, guess)| guess).collect();
                self.guesses.extend(rivals);
                self.leads(of, &place_m).then_some(at)
            }
            _ => None,
        };
        if let Some(at) = found {
            self.guesses.clear();
            self.strays.clear();
            return candidates.into_iter().nth(at);
        }
        self.guesses.extend(made);
        self.strays.push(visit);
        None
    }

    /// Of places to which no known way leads, those that a visit may be to, each with where its stretch then lies.
    fn resembling(&self, visit: &Stray, places: &[(usize, usize)]) -> Vec<(Candidate, Guess)> {
        let of_kind = places.iter().filter(|(node, _)| self.map.nodes[*node].kind == visit.kind);
        let resembling = of_kind.flat_map(|&(node, group)| {
            let place = &self.places[node];
            let fits = turns_rad(&visit.bearings_rad, &place.ways_rad)
                .filter_map(|rad| place.walls.fit(&visit.walls, &Isometry2::rotation(rad)));
            fits.filter(|fit| fit.share >= GUESSED_SHARE).map(move |fit| {
                let stretch = self.graph.poses[place.first_visit] * fit.pose * visit.anchor.inverse();
                (Candidate { node, fit }, Guess { node, group, stretch })
            })
        });
        resembling.collect()
    }

    /// How many other places other visits may be to if the stretch lies where a guess has it.
    fn agreeing(&self, of: &Guess, place_m: &Point2<f64>) -> usize {
        let others = self.guesses.iter().filter(|other| other.node != of.node && of.is_one(other, place_m));
        others.map(|other| other.node).collect::<BTreeSet<_>>().len()
    }

    /// Whether more places agree on a guess than on any other.
    fn leads(&self, of: &Guess, place_m: &Point2<f64>) -> bool {
        let agreeing = self.agreeing(of, place_m);
        let mut rivals = self.guesses.iter().filter(|other| !of.is_one(other, place_m));
        rivals.all(|rival| agreeing >= self.agreeing(rival, place_m) + AGREED_LEAD)
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
        self.map.refusals.push(Refusal { node, at_ns: visit.time_ns[1], score, runner_up, why });
    }
}

impl Guess {
    /// Whether both have the stretch lie at the same place, by where they have this place of it.
    fn is_one(&self, other: &Self, place_m: &Point2<f64>) -> bool {
        let off_rad = self.stretch.rotation.angle_to(&other.stretch.rotation).abs();
        let off_m = (self.stretch * place_m - other.stretch * place_m).norm();
        self.group == other.group && off_rad < AGREED_RAD && off_m < ANCHORS_M
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

/// The turns that bring the ways of a visit onto those of a node.
fn turns_rad<'w>(bearings_rad: &'w [f64], ways_rad: &'w [f64]) -> impl Iterator<Item = f64> + 'w {
    (0..bearings_rad.len()).filter_map(|shift| turn_rad(bearings_rad, ways_rad, shift))
}

/// The turn that brings the ways of a visit onto those of a node, way i onto way i + `shift`; `None` if they do not
/// agree.
fn turn_rad(bearings_rad: &[f64], ways_rad: &[f64], shift: usize) -> Option<f64> {
    let ways = bearings_rad.len();
    if ways != ways_rad.len() {
        return None;
    }
    let off_rad = |i: usize| ways_rad[(i + shift) % ways] - bearings_rad[i];
    let first_rad = off_rad(0);
    let mean_rad = first_rad + (0..ways).map(|i| wrap_angle_rad(off_rad(i) - first_rad)).sum::<f64>() / ways as f64;
    let agree = (0..ways).all(|i| wrap_angle_rad(off_rad(i) - mean_rad).abs() <= WAYS_APART_RAD);
    agree.then(|| wrap_angle_rad(mean_rad))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;
    use std::sync::Arc;

    use nalgebra::{Unit, Vector2};

    use super::*;
    use crate::Way;
    use crate::line_points::LinePoint;
    use crate::map::mapper::Place;
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
            let mut mapper = Mapper::default();
            mapper.graph.poses = vec![Isometry2::identity()];
            let way = NodeWay { bearing_rad: way_rad(-1.0), width_m: 5.0, taken: true, passage: None };
            mapper.map.nodes = vec![Node {
                kind: HereKind::DeadEnd,
                position_m: Point2::origin(),
                ways: vec![way],
                visits: vec![[0, 1]],
            }];
            let (walls, ways_rad) = (Arc::new(Walls::new(&dead_end(-1.0))), vec![way_rad(-1.0)]);
            mapper.places = vec![Place { walls, ways_rad, first_visit: 0, belief: BTreeMap::new() }];
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
            let alike = mapper.places[0].walls.fit(&walls, &Isometry2::identity()).expect("both have walls").share;
            assert!(alike > LEAST_SHARE, "the walls beside them are alike: {alike}");
            let found = mapper.recognise(&visit, &walls, &Isometry2::identity(), None);
            assert_eq!(found.is_some(), is_same, "open towards {side} x");
        }
    }
}
