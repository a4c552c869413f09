//! Poses by matching each revolution to the walls seen before it, point to line.
//!
//! The pose minimises, over the returns i that lie on a line and have a line point (qᵢ, nᵢ) of the local map beside them,
//!
//! ```text
//! Σ ρ(nᵢ · (R pᵢ + t - qᵢ)) / σ²  +  (x - x̂)ᵀ P⁻¹ (x - x̂)
//! ```
//!
//! with ρ of Geman and McClure and x̂, P the predicted pose and its covariance. The second term decides where the walls
//! do not: along a straight smooth tunnel. There the first would hold the vehicle back, as noise of the normals looks like
//! walls across: what the noise makes by itself is taken off the curvature in the direction in which the walls hold the
//! position least (compare the degeneracy of Zhang, Kaess and Singh 2016). Where little is left, the direction is not held
//! ([`Held`]), and odometry holds the pose there as tightly as it is known to. Where the walls hold, odometry may be wrong,
//! as after a wheel slipped: P is then at least that of a vehicle that moves on steadily. A match that ends more than three
//! standard deviations off the odometry is weighed against it: where the walls lie better by less than the odometry's own
//! covariance makes of it, the pose is where odometry has it, and walls only correct it as far as that covariance lets them.

mod by_scans;

use nalgebra::{Isometry2, Matrix2, Matrix3, Point2, Unit, Vector2, Vector3};

use crosscut_stage::{NoteCode, Point, Revolution};

use crate::evidence::{MatchEvidence, Matching, stepped};
use crate::line_points::{LinePoint, least_axis, line_points};
use crate::local_map::LocalMap;
use crate::motion::{Earned, MOST_OF_ODOMETRY, Motion, difference, loosest, matching_covariance, steadily, turned};
use crate::own_returns::OwnReturns;
use crate::unaided::Unaided;

/// A typical distance of a return from the line that it belongs to: noise of the range and roughness of walls.
const DEVIATION_M: f64 = 0.05;

/// ρ turns from a square to a constant about here, so that returns of what moves or was not seen before weigh little.
const KERNEL_M: f64 = 0.15;

/// The iteration ends at a step shorter than this, metres and radians.
const CONVERGED: f64 = 1e-3;

/// The iteration stops when the iterate is this close to a minimum already found, metres and radians.
const FOUND: f64 = 0.01;

/// The iteration ends after this many steps.
const MAX_ITERATIONS: usize = 25;

/// Line points farther than this from the vehicle are forgotten.
const MAP_RADIUS_M: f64 = 40.0;

/// A revolution adds its line points to the map once the vehicle has moved this far since the last revolution that did.
const KEYFRAME_M: f64 = 0.5;

/// A revolution adds its line points to the map once the vehicle has turned this far since the last revolution that did.
const KEYFRAME_RAD: f64 = 0.15;

/// Below this share of matched line points the pose is not believed.
const LEAST_MATCHED: f64 = 0.3;

/// The oddness of a match grows by 1 for each multiple of this by which its share lies below the usual share.
const UNUSUAL_SHARE: f64 = 0.05;

/// The oddness of a match grows by 1 for each multiple of this many standard deviations between its motion and the predicted
/// motion.
const UNUSUAL_DEVIATIONS: f64 = 2.0;

/// Without odometry, the scan of a match odder than this is no neighbour of the scan before: other walls may fit by chance.
const UNUSUAL: f64 = 5.5;

/// The usual share is moved by this part of each difference from it.
const FOLLOWED: f64 = 0.1;

/// The usual share is known after this many revolutions.
const USUAL_AFTER: u32 = 5;

/// At most this many line points are matched, evenly chosen; more add time and no certainty.
const MOST_POINTS: usize = 200;

/// A start at which fewer of them than this share match is not followed, nor one that does not lead to [`LEAST_MATCHED`] within
/// [`FIRST_STEPS`]: where the walls are those seen before, the first steps bring most of them together.
const LEAST_AT_START: f64 = 0.15;
const FIRST_STEPS: usize = 2;

/// What noise of the normals makes of the curvature is taken off this many times.
const NOISE_TIMES: f64 = 2.0;

/// The walls hold a direction if by what is left they alone show the position along it to within this (standard deviation),
/// beside odometry and without it.
const HELD_M: [f64; 2] = [0.15, 0.3];

/// A motion that is not the predicted one is taken if the sum is lower by this much with it.
const OTHER_LEAD: f64 = 4.0;

/// A match that lies this many standard deviations off the motion that odometry shows contradicts it: then both are weighed.
const CONTRADICTS: f64 = 3.0;

/// Returns that follow each other err alike: this many of them count as one where walls are weighed against odometry.
const ALIKE: f64 = 4.0;

/// A match that contradicts odometry has a share of line points no lower than the usual one less this.
const LESS_THAN_USUAL: f64 = 0.2;

/// Revolutions that odometry takes to be farther apart than this are no neighbours: walls that match elsewhere are others.
pub(crate) const NEIGHBOURS_M: f64 = 1.0;

/// Walls lie worse than usual if their sum, a line point, is more than the usual one times this, and more by this.
const POOR_TIMES: f64 = 1.5;
const POOR: f64 = 0.3;

/// A steady motion that ends this near to where odometry does is not tried, metres and radians.
const NEAR: f64 = 0.03;

/// Where a revolution was taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Matched {
    /// The pose in the frame of the first revolution.
    pub pose: Isometry2<f64>,
    /// Covariance of the pose on the walls seen before, x, y (m²) and yaw (rad²) in the map's axes; without odometry of the motion
    /// since the revolution before. It takes the returns as independent of each other, so that it is rather too small.
    pub covariance: Matrix3<f64>,
    /// Share of the line points of the revolution that have one of the map beside them.
    pub matched: f64,
    /// How far the motion lies from the predicted one, in standard deviations of the two together, where the walls hold it.
    /// Far above 3 after a wheel slipped, or when scans are missing.
    pub surprise: f64,
    /// Covariance of the motion where odometry has it against the walls, in the map's axes; else zero.
    pub by_odometry: Matrix3<f64>,
    /// Too few were matched: the pose is the predicted one, and nothing of the revolution is remembered.
    pub lost: bool,
    /// Where the walls hold the position.
    pub held: Held,
    /// What was guessed since the walls last held the pose is known to within this (standard deviation), metres.
    pub guess_known_m: Option<f64>,
}

/// In which directions the walls hold a position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Held {
    /// In all.
    Everywhere,
    /// In all but along this one, in the map's axes: the prediction alone shows how far the vehicle moved along it.
    ButAlong(Unit<Vector2<f64>>),
    /// In none: there are no walls.
    Nowhere,
}

/// Matches revolutions, in order, against the walls seen shortly before.
#[derive(Clone, Debug, Default)]
pub struct ScanMatcher {
    map: LocalMap,
    line_points: Vec<LinePoint>,
    matching: Matching,
    pose: Isometry2<f64>,
    keyframe: Isometry2<f64>,
    last_step: Isometry2<f64>,
    /// Covariance of the pose on the map, in its axes.
    carried: Matrix3<f64>,
    /// Of [`HELD_M`] that which counts for this revolution.
    held_m: f64,
    earned: Earned,
    /// The walls contradicted the odometry, and more spoke for the odometry: what the scan saw is not remembered.
    is_overruled: bool,
    usual: UsualShare,
    /// Of the last match, the walls' sum a line point.
    walls_of_point: f64,
    /// The returns that are not the vehicle's.
    points_m: Vec<Point>,
    own_returns: OwnReturns,
    /// Until it is taken.
    own_returns_note: Option<(NoteCode, String)>,
    unaided: Unaided,
}

/// The share of line points that usually match.
#[derive(Clone, Copy, Debug, Default)]
struct UsualShare {
    matched: f64,
    /// The sum of the walls, a line point.
    walls: f64,
    revolutions: u32,
}

/// A pose that is expected, and how strongly.
struct Prediction {
    pose: Isometry2<f64>,
    /// Of the motion alone, and of the pose.
    of_motion: Matrix3<f64>,
    covariance: Matrix3<f64>,
    /// Where the walls hold the pose, and where they do not.
    information: [Matrix3<f64>; 2],
}

/// A minimum of the sum.
struct Aligned {
    /// The walls' part of the sum.
    walls: f64,
    matched: Matched,
}

impl Aligned {
    /// What speaks against it: the walls, and what odometry predicted.
    fn weighed(&self, by: &Prediction, is_motion_known: bool) -> f64 {
        let surprise = if is_motion_known { by.surprise(&difference(&self.matched.pose, &by.pose)) } else { 0.0 };
        self.walls / ALIKE + (surprise * surprise).min(MOST_OF_ODOMETRY)
    }
}

/// The walls' part of the sum at a pose, less what noise makes.
struct MatchedWalls {
    evidence: MatchEvidence,
    held: Held,
}

impl ScanMatcher {
    /// The pose of the next revolution. Without a `predicted` motion the vehicle is taken to move on steadily.
    pub fn add(&mut self, revolution: &Revolution, predicted: Option<Motion>) -> Matched {
        let mut points_m = std::mem::take(&mut self.points_m);
        points_m.clear();
        self.leave_out_vehicle(revolution, predicted.is_some(), &mut points_m);
        let every = points_m.len().div_ceil(MOST_POINTS).max(1);
        line_points(&points_m, every, &mut self.line_points);
        let steady = self.steady_motion();
        let carried = if predicted.is_some() { self.carried } else { Matrix3::zeros() };
        let predicted = predicted.map(|motion| Motion { covariance: self.earned.scaled(&motion.covariance), ..motion });
        let prediction = self.prediction(&predicted.unwrap_or(steady), &carried);
        self.is_overruled = false;
        self.held_m = HELD_M[usize::from(predicted.is_none())];
        // A revolution without walls, such as one of a covered lidar, is not lost: the next may match again.
        let matched = if self.map.is_empty() || self.line_points.is_empty() {
            let held = if self.map.is_empty() { Held::Everywhere } else { Held::Nowhere };
            Matched { matched: 1.0, lost: false, held, ..prediction.lost() }
        } else {
            self.match_walls(&points_m, &prediction, steady, predicted.is_some())
        };
        if !matched.lost {
            self.usual.add(&matched, self.walls_of_point);
            let step = self.unaided.next_step.take();
            self.last_step = step.unwrap_or_else(|| self.pose.inv_mul(&matched.pose));
            self.pose = matched.pose;
            self.carried = matched.covariance;
            if !self.is_overruled {
                let is_remembered = self.remember(&points_m);
                self.unaided.is_adrift |= is_remembered && matched.held != Held::Everywhere;
            }
        }
        self.points_m = points_m;
        matched
    }

    /// All returns but the vehicle's own.
    fn leave_out_vehicle(&mut self, revolution: &Revolution, has_odometry: bool, others_m: &mut Vec<Point>) {
        let was_found = self.own_returns.found_in().is_some();
        let note = revolution.sweep.as_ref().and_then(|sweep| self.own_returns.add(sweep));
        self.own_returns_note = note.or(self.own_returns_note.take());
        let found_in = self.own_returns.found_in();
        match revolution.sweep.as_ref().filter(|_| found_in.is_some()) {
            Some(sweep) => self.own_returns.others(sweep, &revolution.points_m, others_m),
            None => others_m.extend(&revolution.points_m),
        }
        if let Some(scans) = found_in.filter(|_| !has_odometry && !was_found) {
            self.unaided.was_held(scans);
        }
    }

    /// Takes the note of the revolution that surely shows the vehicle in its own scans.
    pub(crate) fn own_returns_note(&mut self) -> Option<(NoteCode, String)> {
        self.own_returns_note.take()
    }

    fn match_walls(
        &mut self,
        points_m: &[Point],
        prediction: &Prediction,
        steady: Motion,
        has_odometry: bool,
    ) -> Matched {
        self.matching.begin(self.line_points.iter().copied());
        let first = self.align(prediction, None);
        if has_odometry {
            self.beside_odometry(prediction, steady, first)
        } else {
            self.by_scans(points_m, prediction, first)
        }
    }

    fn beside_odometry(&mut self, prediction: &Prediction, steady: Motion, first: Aligned) -> Matched {
        // Walls off by more than the kernel do not pull: after a slip the minimum lies near the steady motion. What ends where
        // the first did is no better, unless the prediction pulls at that by more than the other's lead.
        let off = difference(&first.matched.pose, &prediction.pose);
        let pull = off.dot(&(prediction.prior(first.matched.held) * off));
        let found = (!first.matched.lost && pull <= OTHER_LEAD).then_some(first.matched.pose);
        let standing = Motion { step: Isometry2::identity(), ..steady };
        let others = [(steady, NEAR), (standing, KERNEL_M)]
            .map(|(motion, near)| (self.prediction(&motion, &Matrix3::zeros()), near));
        let is_far = |(other, near): &&(Prediction, f64)| {
            let off = difference(&other.pose, &prediction.pose);
            off.amax() > *near && off.xy().norm() < NEIGHBOURS_M
        };
        let others = others.iter().filter(is_far).map(|(other, _)| self.align(other, found.as_ref()));
        // Along a smooth tunnel any motion fits, and standing fits best: the beams meet the walls where they did before.
        let is_shown = |other: &Aligned| other.matched.held == Held::Everywhere;
        let sum = |of: &Aligned| of.weighed(prediction, true);
        let best =
            others.filter(is_shown).fold(first, |best, other| if sum(&other) < sum(&best) { other } else { best });
        let off = difference(&best.matched.pose, &prediction.pose);
        let surprise = prediction.surprise(&off);
        self.walls_of_point = best.walls / self.matching.len() as f64;
        self.unaided.follow(true);
        if best.matched.held == Held::Everywhere {
            self.earned.add(&off, &prediction.covariance);
        }
        let matched =
            if best.matched.lost || surprise > CONTRADICTS { self.weigh(prediction, best) } else { best.matched };
        Matched { surprise, ..matched }
    }

    /// Where a match contradicts the odometry: the one of the two that all of the evidence speaks for.
    fn weigh(&mut self, prediction: &Prediction, by_walls: Aligned) -> Matched {
        let [_, tight] = prediction.information;
        let mut pose = prediction.pose;
        let mut walls = self.walls_at(&pose);
        for _ in 0..MAX_ITERATIONS {
            let off = difference(&pose, &prediction.pose);
            let Some(factor) = (walls.evidence.information / ALIKE + tight).cholesky() else { break };
            let step = factor.solve(&-(walls.evidence.gradient / ALIKE + tight * off));
            pose = stepped(&pose, &step);
            walls = self.walls_at(&pose);
            if step.amax() < CONVERGED {
                break;
            }
        }
        let off = difference(&pose, &prediction.pose);
        let by_odometry = self.walls(&walls.evidence) / ALIKE + off.dot(&(tight * off));
        // Among walls that were not seen before, a false match lies as well on some as the true pose does.
        let is_usual = by_walls.matched.matched > self.usual.matched - LESS_THAN_USUAL;
        if is_usual && by_walls.weighed(prediction, true) < by_odometry {
            return by_walls.matched;
        }
        self.is_overruled = !by_walls.matched.lost;
        let matched = walls.evidence.matched as f64 / self.matching.len() as f64;
        let covariance = (walls.evidence.information / ALIKE + tight).try_inverse().unwrap_or(prediction.covariance);
        Matched { pose, covariance, by_odometry: prediction.of_motion, matched, lost: false, ..prediction.lost() }
    }

    /// The walls' part of the sum, with the line points that have none beside them.
    fn walls(&self, evidence: &MatchEvidence) -> f64 {
        let unmatched = (self.matching.len() - evidence.matched) as f64;
        evidence.cost + unmatched * (KERNEL_M / DEVIATION_M).powi(2)
    }

    /// Whether any walls are remembered.
    pub fn has_walls(&self) -> bool {
        !self.map.is_empty()
    }

    /// Forgets the walls: the revolution that follows does not go with those before.
    pub fn forget(&mut self) {
        self.map.clear();
        self.carried = Matrix3::zeros();
        self.last_step = Isometry2::identity();
        self.usual = UsualShare::default();
        self.unaided.follow(false);
    }

    fn steady_motion(&self) -> Motion {
        Motion { step: self.last_step, covariance: steadily(&self.last_step) }
    }

    /// A motion from a pose that is known with a covariance `carried`, in the axes of the map.
    fn prediction(&self, motion: &Motion, carried: &Matrix3<f64>) -> Prediction {
        let yaw_rad = self.pose.rotation.angle();
        let moved_m = self.pose.rotation * motion.step.translation.vector;
        let carry = Matrix3::new(1.0, 0.0, -moved_m.y, 0.0, 1.0, moved_m.x, 0.0, 0.0, 1.0);
        let carried = carry * carried * carry.transpose();
        let steady = steadily(&motion.step).diagonal().inf(&Vector3::repeat(KERNEL_M * KERNEL_M));
        let loose = turned(&loosest(&motion.covariance, &Matrix3::from_diagonal(&steady)), yaw_rad) + carried;
        let of_motion = turned(&motion.covariance, yaw_rad);
        let covariance = of_motion + carried;
        // The deviations of a motion are above 0.
        let information = [loose, covariance].map(|of| of.try_inverse().unwrap_or_else(Matrix3::identity));
        Prediction { pose: self.pose * motion.step, of_motion, covariance, information }
    }

    /// The minimum of the sum near a prediction; infinite if the pose is lost, or leads to one that was `found`.
    fn align(&mut self, prediction: &Prediction, found: Option<&Isometry2<f64>>) -> Aligned {
        let lost = |matched| Aligned { walls: f64::INFINITY, matched: Matched { matched, ..prediction.lost() } };
        let all = self.matching.len() as f64;
        let mut pose = prediction.pose;
        let mut walls = self.walls_at(&pose);
        for steps in 0..MAX_ITERATIONS {
            let matched = walls.evidence.matched as f64 / all;
            if (steps == 0 && matched < LEAST_AT_START) || (steps == FIRST_STEPS && matched < LEAST_MATCHED) {
                return lost(matched);
            }
            let off = difference(&pose, &prediction.pose);
            let prior = prediction.prior(walls.held);
            let Some(factor) = (walls.evidence.information + prior).cholesky() else { return lost(matched) };
            let step = factor.solve(&-(walls.evidence.gradient + prior * off));
            pose = stepped(&pose, &step);
            if found.is_some_and(|found| difference(&pose, found).amax() < FOUND) {
                return lost(matched);
            }
            walls = self.walls_at(&pose);
            if step.amax() < CONVERGED {
                break;
            }
        }
        let MatchedWalls { evidence, held } = walls;
        let matched = evidence.matched as f64 / all;
        let prior = prediction.prior(held);
        let walls = self.walls(&evidence);
        match (evidence.information + prior).try_inverse() {
            Some(covariance) if matched >= LEAST_MATCHED => {
                let matched = Matched { pose, covariance, matched, lost: false, held, ..prediction.lost() };
                Aligned { walls, matched }
            }
            _ => lost(matched),
        }
    }

    fn walls_at(&mut self, pose: &Isometry2<f64>) -> MatchedWalls {
        const WEIGHT: f64 = 1.0 / (DEVIATION_M * DEVIATION_M);
        let mut evidence = self.matching.at(pose, &self.map, KERNEL_M);
        let held = take_noise_off(&mut evidence, self.held_m);
        evidence.cost *= WEIGHT;
        evidence.information *= WEIGHT;
        evidence.gradient *= WEIGHT;
        MatchedWalls { evidence, held }
    }

    /// Adds the revolution to the map if the vehicle has moved or turned enough since the last one that was added.
    fn remember(&mut self, points_m: &[Point]) -> bool {
        let since = self.keyframe.inv_mul(&self.pose);
        let is_far = since.translation.vector.norm() > KEYFRAME_M || since.rotation.angle().abs() > KEYFRAME_RAD;
        if !is_far && !self.map.is_empty() && !std::mem::take(&mut self.unaided.must_remember) {
            return false;
        }
        self.keyframe = self.pose;
        self.map.keep_around(&Point2::from(self.pose.translation.vector), MAP_RADIUS_M);
        line_points(points_m, 1, &mut self.line_points);
        for point in &self.line_points {
            self.map.insert(point.at(&self.pose));
        }
        true
    }
}

impl UsualShare {
    /// Whether a match is not one of neighbours.
    fn is_unusual(&self, matched: f64, surprise: f64) -> bool {
        let below = (self.matched - matched).max(0.0) / UNUSUAL_SHARE;
        self.revolutions >= USUAL_AFTER && below.hypot(surprise / UNUSUAL_DEVIATIONS) > UNUSUAL
    }

    /// Whether walls lie worse than usual.
    fn are_worse(&self, walls: f64) -> bool {
        self.revolutions > 1 && walls > POOR_TIMES * self.walls + POOR
    }

    fn add(&mut self, matched: &Matched, walls: f64) {
        let share = if self.revolutions == 0 { 1.0 } else { FOLLOWED };
        self.matched += share * (matched.matched - self.matched);
        // The first revolution has no walls to lie on.
        self.walls += if self.revolutions <= 1 { walls - self.walls } else { FOLLOWED * (walls - self.walls) };
        self.revolutions = self.revolutions.saturating_add(1);
    }
}

impl Prediction {
    /// The information of the prediction, by where the walls hold the pose.
    fn prior(&self, held: Held) -> Matrix3<f64> {
        let [loose, tight] = self.information;
        match held {
            Held::Everywhere => loose,
            Held::Nowhere => tight,
            Held::ButAlong(along) => {
                let along = Vector3::new(along.x, along.y, 0.0);
                let more = along.dot(&((tight - loose) * along)).max(0.0);
                loose + along * along.transpose() * more
            }
        }
    }

    /// How far a pose is off in standard deviations of the prediction and of matching together.
    fn surprise(&self, off: &Vector3<f64>) -> f64 {
        let apart = (self.covariance + matching_covariance()).try_inverse().unwrap_or(self.information[1]);
        off.dot(&(apart * off)).max(0.0).sqrt()
    }

    /// The result where the walls show nothing.
    fn lost(&self) -> Matched {
        Matched {
            pose: self.pose,
            covariance: self.covariance,
            matched: 0.0,
            surprise: 0.0,
            by_odometry: Matrix3::zeros(),
            lost: true,
            held: Held::Nowhere,
            guess_known_m: None,
        }
    }
}

/// Takes what noise of the normals makes off the curvature and the gradient in the direction in which the walls hold the
/// position least.
fn take_noise_off(evidence: &mut MatchEvidence, held_m: f64) -> Held {
    let all = &evidence.information;
    if evidence.matched == 0 || all[(2, 2)] <= 0.0 {
        return Held::Nowhere;
    }
    let by_yaw = all.fixed_view::<2, 1>(0, 2).into_owned();
    // Of the position alone, whatever the yaw.
    let position: Matrix2<f64> = all.fixed_view::<2, 2>(0, 0) - by_yaw * by_yaw.transpose() / all[(2, 2)];
    let (least, along) = least_axis(&position);
    let noise = along.dot(&(evidence.noise * *along));
    let share = if least > 0.0 { (1.0 - NOISE_TIMES * noise / least).clamp(0.0, 1.0) } else { 0.0 };
    let along_3 = Vector3::new(along.x, along.y, 0.0);
    let scale = Matrix3::identity() + along_3 * along_3.transpose() * (share.sqrt() - 1.0);
    evidence.information = scale * evidence.information * scale;
    evidence.gradient += along_3 * ((share - 1.0) * along_3.dot(&evidence.gradient));
    let left = share * least / (DEVIATION_M * DEVIATION_M);
    if left > 1.0 / (held_m * held_m) { Held::Everywhere } else { Held::ButAlong(along) }
}
