//! One stay at a junction or a dead end.

use std::collections::BTreeMap;
use std::sync::Arc;

use crosscut_stage::{PoseDoubt, unit, wrap_angle_rad};
use nalgebra::{Isometry2, Point2};

use super::outline::Walls;
use crate::belief::{elapsed_s, independent, sure};
use crate::line_points::LinePoint;
use crate::{Here, HereKind, Way};

/// The outline of a visit is taken each time the vehicle has moved this far.
const OUTLINE_EVERY_M: f64 = 0.7;

/// Revolutions nearer to each other than this see the same.
const SAME_VIEW_M: f64 = 0.05;

/// Line points of an outline are no farther from the sensor than this many times the look.
const OUTLINE_LOOKS: f64 = 2.0;

/// A shorter stay is no visit: five revolutions at ten a second, less the jitter of their stamps.
const LEAST_STAY_S: f64 = 0.35;

/// From parts of a place some of its ways are hidden: of the numbers of ways that are believed at least this many times as much as
/// any other the largest holds.
const ALSO_SEEN: f64 = 0.5;

/// The vehicle has left the middle of a place this far on.
const LEFT_MIDDLE_M: f64 = 1.5;

/// A visit to a junction has ended once the vehicle has moved this far in a passage: the place may be in doubt in
/// between.
pub(super) const LEFT_M: f64 = 1.0;

/// A visit to a dead end has ended once the vehicle has moved this far in a passage: then the side by which it leaves
/// is certain.
const LEFT_DEAD_END_M: f64 = 5.0;

/// Beyond this, a place lies on the other side of the anchor than a way.
const BEHIND_M: f64 = 1.0;

/// A leg is assigned to the way nearest its direction, within this angle.
pub(super) const FLOWN_WAY_RAD: f64 = 1.0;

/// What was seen from one pose.
#[derive(Clone, Debug)]
struct Sample {
    pose: Isometry2<f64>,
    /// The way of the flight up to there.
    way_m: f64,
    /// In the frame of that pose.
    ways: Vec<Way>,
    look_m: f64,
    /// How much it counts.
    sure: f64,
    /// It was taken in the middle of the place.
    is_middle: bool,
}

/// When and where the vehicle was.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moment {
    pub(super) stamp_ns: u64,
    pub(super) pose: Isometry2<f64>,
    pub(super) doubt: PoseDoubt,
    /// The way of the flight up to there.
    pub(super) way_m: f64,
}

impl Moment {
    pub(super) fn place_m(&self) -> Point2<f64> {
        Point2::from(self.pose.translation.vector)
    }
}

/// A stay that has not ended. Poses are as they are tracked, with their drift.
#[derive(Clone, Debug)]
pub(crate) struct OpenVisit {
    began: Moment,
    /// When a revolution was added last.
    latest: Option<Moment>,
    /// From the first revolution that was added to the last; stamps that do not advance count as usual ones.
    stayed_s: f64,
    kind: HereKind,
    samples: Vec<Sample>,
    outline: Vec<LinePoint>,
    outlined_from: Option<Isometry2<f64>>,
    /// Where the vehicle was before.
    came_from: Option<Point2<f64>>,
    /// The way where the vehicle was in the middle of the place last.
    middle_at_m: Option<f64>,
    /// Where the stay before was, if no passage lies in between: what is seen within a look of it may be that place.
    follows: Option<Point2<f64>>,
}

/// A stay that has ended.
#[derive(Clone, Debug)]
pub(crate) struct Visit {
    pub(crate) kind: HereKind,
    /// The vehicle was in the middle of the place.
    pub(crate) has_middle: bool,
    pub(crate) time_ns: [u64; 2],
    /// The pose that its ways and its outline are seen from.
    pub(crate) anchor: Isometry2<f64>,
    /// In the frame of the anchor, by bearing.
    pub(crate) ways: Vec<Way>,
    /// Radius of the look at the anchor, metres.
    pub(crate) look_m: f64,
    /// In the frame of the anchor.
    pub(crate) walls: Arc<Walls>,
    /// The way of the flight where the vehicle reached the anchor, and where it left it.
    pub(crate) reached_at_m: f64,
    pub(crate) left_at_m: f64,
    /// The belief in this number of ways, summed over its revolutions.
    pub(crate) belief: f64,
    /// Where the vehicle was shortly before and after, in the frame of the anchor.
    pub(crate) came_from: Point2<f64>,
    pub(crate) left_to: Point2<f64>,
    /// Of a visit to which no leg leads: the vehicle came from elsewhere. A flight may begin within its first node.
    pub(crate) has_come: bool,
    /// Doubt of the pose when the visit began, and when it ended.
    pub(crate) doubts: [PoseDoubt; 2],
}

impl OpenVisit {
    /// That begins; `came_from`: a place shortly before, as it was tracked.
    pub(crate) fn new(
        kind: HereKind,
        began: Moment,
        came_from: Option<Point2<f64>>,
        follows: Option<Point2<f64>>,
    ) -> Self {
        let (samples, outline) = (Vec::new(), Vec::new());
        let (latest, outlined_from, middle_at_m) = (None, None, None);
        Self { began, latest, stayed_s: 0.0, kind, samples, outline, outlined_from, came_from, middle_at_m, follows }
    }

    /// Whether the doubt of a pose since this place was seen last is known.
    pub(super) fn is_known_at(&self, now: &Moment) -> bool {
        let since = now.doubt.since(&self.latest.unwrap_or(self.began).doubt);
        since.is_some_and(|since| since.sd_m(now.place_m()).is_some())
    }

    /// Whether the stay is over, where the vehicle now is in a node of this kind, or in none.
    pub(super) fn has_ended(&self, now: &Moment, node: Option<HereKind>) -> bool {
        let passed_m = now.way_m - self.latest.unwrap_or(self.began).way_m;
        match (node, self.kind) {
            (Some(node), kind) if kind != node => true,
            (Some(_), HereKind::Junction) => self.has_left_the_middle(now) || self.has_turned_back(now),
            (Some(_), _) => false,
            (None, _) if !self.is_known_at(now) => true,
            (None, HereKind::DeadEnd) => passed_m > LEFT_DEAD_END_M,
            (None, _) => passed_m > LEFT_M,
        }
    }

    /// Whether the vehicle was in the middle of the place and has left it: what it sees now may be the next place.
    fn has_left_the_middle(&self, now: &Moment) -> bool {
        self.middle_at_m.is_some_and(|middle_at_m| now.way_m - middle_at_m > LEFT_MIDDLE_M)
    }

    /// Whether the vehicle saw this place from its edge alone and is back within the look of the stay before.
    fn has_turned_back(&self, now: &Moment) -> bool {
        let look_m = self.samples.last().map(|sample| sample.look_m).filter(|_| self.middle_at_m.is_none());
        self.follows.zip(look_m).is_some_and(|(before_m, look_m)| (now.place_m() - before_m).norm() < look_m)
    }

    pub(crate) fn kind(&self) -> HereKind {
        self.kind
    }

    /// Adds a revolution at which this place holds: what it saw itself, and its line points.
    pub(super) fn add(&mut self, now: Moment, seen: &Here, line_points: impl FnOnce() -> Vec<LinePoint>) {
        let Moment { stamp_ns, pose, way_m, .. } = now;
        let moved_m = |from: Isometry2<f64>| (from.translation.vector - pose.translation.vector).norm();
        let before = self.latest.replace(now);
        let since_s = before.map(|before| elapsed_s(before.stamp_ns, stamp_ns));
        self.stayed_s += since_s.unwrap_or(0.0);
        let views = since_s.map_or(1.0, independent);
        let at_m = now.place_m();
        let is_here = seen.is_middle || self.follows.is_none_or(|before_m| (at_m - before_m).norm() > seen.look_m);
        if seen.node() == Some(self.kind) && is_here {
            let sure = views * sure(seen.confidence);
            let is_same =
                |sample: &&mut Sample| sample.ways.len() == seen.ways.len() && moved_m(sample.pose) < SAME_VIEW_M;
            match self.samples.iter_mut().rev().find(is_same) {
                Some(sample) => {
                    sample.sure += sure;
                    sample.is_middle |= seen.is_middle;
                }
                None => {
                    let (ways, look_m, is_middle) = (seen.ways.clone(), seen.look_m, seen.is_middle);
                    self.samples.push(Sample { pose, way_m, ways, look_m, sure, is_middle });
                }
            }
            if seen.is_middle {
                self.middle_at_m = Some(way_m);
            }
        }
        if self.outlined_from.is_none_or(|from| moved_m(from) > OUTLINE_EVERY_M) {
            self.outlined_from = Some(pose);
            let reach_m = OUTLINE_LOOKS * seen.look_m;
            let near = line_points().into_iter().filter(|point| point.position_m.coords.norm() < reach_m);
            self.outline.extend(near.map(|point| point.at(&pose)));
        }
    }

    /// Whether the stay counts as a visit: it was long enough, and a revolution by itself saw the place.
    pub(crate) fn is_believed(&self) -> bool {
        self.stayed_s >= LEAST_STAY_S && !self.samples.is_empty()
    }

    /// Whether what was seen of this place lies behind.
    pub(crate) fn is_behind(&self, pose: &Isometry2<f64>) -> bool {
        let off_m = |sample: &Sample| (sample.pose.translation.vector - pose.translation.vector).norm();
        self.samples.iter().all(|sample| off_m(sample) > sample.look_m)
    }

    /// The stay as a whole, if it is believed. Of the numbers of ways that were seen with at least half of the confidence of any other
    /// the largest holds. The ways are those of the revolution nearest to the middle of the place that saw this number. `left_to`:
    /// where the vehicle is now, if it has left.
    pub(crate) fn end(mut self, left_to: Option<Isometry2<f64>>) -> Option<Visit> {
        if !self.is_believed() {
            return None;
        }
        // From its middle a place is seen as it is; from its edge the next one may be seen with it.
        let has_middle = self.samples.iter().any(|sample| sample.is_middle);
        self.samples.retain(|sample| sample.is_middle || !has_middle);
        let mut belief: BTreeMap<usize, f64> = BTreeMap::new();
        for sample in &self.samples {
            *belief.entry(sample.ways.len()).or_default() += sample.sure;
        }
        let most = belief.values().copied().fold(0.0, f64::max);
        let (&ways, &belief) = belief.iter().rev().find(|(_, belief)| **belief >= ALSO_SEEN * most)?;
        let with = || self.samples.iter().filter(|sample| sample.ways.len() == ways);
        let count = with().count() as f64;
        let middle_m =
            with().fold(nalgebra::Vector2::zeros(), |sum, sample| sum + sample.pose.translation.vector) / count;
        let off_m = |sample: &Sample| (sample.pose.translation.vector - middle_m).norm();
        let best = with().min_by(|a, b| off_m(a).total_cmp(&off_m(b)))?;
        let to_anchor = best.pose.inverse();
        let place = |pose: &Isometry2<f64>| to_anchor * Point2::from(pose.translation.vector);
        let (first, last) = (self.samples.first()?, self.samples.last()?);
        let (began, ended) = (self.began, self.latest.unwrap_or(self.began));
        let outline: Vec<LinePoint> = self.outline.iter().map(|point| point.at(&to_anchor)).collect();
        Some(Visit {
            kind: self.kind,
            has_middle,
            time_ns: [began.stamp_ns, ended.stamp_ns],
            anchor: best.pose,
            ways: best.ways.clone(),
            look_m: best.look_m,
            walls: Arc::new(Walls::new(&outline)),
            belief,
            reached_at_m: first.way_m + place(&first.pose).coords.norm(),
            left_at_m: last.way_m - place(&last.pose).coords.norm(),
            came_from: self.came_from.map_or(place(&first.pose), |place_m| to_anchor * place_m),
            left_to: place(left_to.as_ref().unwrap_or(&last.pose)),
            has_come: false,
            doubts: [began.doubt, ended.doubt],
        })
    }
}

impl Visit {
    /// Of its ways, in the frame of the anchor.
    pub(crate) fn bearings_rad(&self) -> Vec<f64> {
        self.ways.iter().map(|way| way.bearing_rad).collect()
    }

    /// Where its ways begin, as they were tracked.
    pub(crate) fn mouths_m(&self) -> Vec<Point2<f64>> {
        let mouth_m = |way: &Way| self.anchor * Point2::from(unit(way.bearing_rad) * self.look_m);
        self.ways.iter().map(mouth_m).collect()
    }

    /// The direction of the way that leads to a place, in the frame of the anchor; that of the place itself, if no way
    /// was seen there.
    pub(crate) fn direction_rad(&self, place_m: Point2<f64>) -> f64 {
        let place_rad = place_m.y.atan2(place_m.x);
        let off_rad = |way: &Way| wrap_angle_rad(way.bearing_rad - place_rad).abs();
        let nearest = self.ways.iter().min_by(|a, b| off_rad(a).total_cmp(&off_rad(b)));
        nearest.filter(|way| off_rad(way) <= FLOWN_WAY_RAD).map_or(place_rad, |way| way.bearing_rad)
    }

    /// Whether the vehicle came or left on the side of a dead end that is closed: then it is none.
    pub(crate) fn passes_through_the_end(&self) -> bool {
        let is_behind = |way: &Way, place_m: Point2<f64>| place_m.coords.dot(&unit(way.bearing_rad)) < -BEHIND_M;
        let dead_end = self.ways.iter().filter(|_| self.kind == HereKind::DeadEnd);
        dead_end.into_iter().any(|way| is_behind(way, self.came_from) || is_behind(way, self.left_to))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_vehicle_that_stands_in_a_junction_takes_no_memory() {
        let at = |i: u64| {
            let pose = Isometry2::translation(0.01 * (i % 3) as f64, 0.0);
            Moment { stamp_ns: i * 100_000_000, pose, doubt: PoseDoubt::default(), way_m: 0.0 }
        };
        let mut open = OpenVisit::new(HereKind::Junction, at(0), None, None);
        let way = Way { bearing_rad: 0.0, width_m: 3.0, opening: None };
        for i in 0..1000 {
            let ways = vec![way; 3 + i % 2];
            let here = Here { kind: HereKind::Junction, look_m: 5.0, ways, is_middle: true, confidence: 0.9 };
            open.add(at(i as u64), &here, Vec::new);
        }
        assert_eq!(open.samples.len(), 2);
        let visit = open.end(None).expect("believed");
        assert!((visit.belief - 400.0).abs() < 1e-6, "each revolution counts: {}", visit.belief);
    }
}
