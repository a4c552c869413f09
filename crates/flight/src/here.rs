//! The place that the vehicle is in, and which of the openings in view belong to it.
//!
//! From a passage the next junction is often in view: its openings are no ways of the passage. The place here is the free
//! space within the look, a circle around the sensor of half a local width and one width of the passages (`look_widths`: 1.5
//! in all), the widest opening in view:
//!
//! ```text
//!      ______|    |______         o  sensor
//!   ..(.                .)..      .  the circle; where it crosses free space is a mouth
//!   __(_      o         _)__      |  rock
//!      .________________.
//! ```
//!
//! - The **local width** w is the shortest free line through the sensor. Beams without a return between two returns of
//!   one wall end at the straight line from the one to the other: wet rock is no mouth.
//! - A **mouth** is a run of beams that leave the circle, there at least as wide as the vehicle and a quarter of the local
//!   width. Some beam reaches 10 % farther, or an opening lies behind it that earlier scans did not see closed
//!   ([`beyond`](crate::beyond)). A passage that is seen to end has a mouth, too.
//! - **Ways** are the openings behind mouths, one for each mouth: the one with the nearest edge.
//! - Where a limited view does not look, what earlier scans saw there counts ([`Surroundings`]). What was never seen and is
//!   wider than a mouth is a way, with half the confidence, if the walls on both sides of it run on side by side, and the
//!   place is no passage then; else it is not known.
//! - A mouth of half a turn or more leads out of no place: one wall is beside the sensor, and the place is not known.
//! - Three ways and more are a junction, two a passage, one a dead end; none, or up to two of a place that is more than
//!   1.5 times as wide as they are, a chamber.

use std::f64::consts::{FRAC_PI_2, PI};

use crosscut_stage::{Junction, Number, Opening, ParamSpec, Params, Sweep, widest_run, wrap_angle_rad};
use nalgebra::{Isometry2, Vector2};

use crate::{Here, HereKind, Way};

const LOOK_WIDTHS: Number = Number::new("look_widths", "widths", 1.5)
    .from(0.6)
    .to(10.0)
    .doc("the place is what lies this many widths around: half the local width, the rest of the widest opening if that is narrower; a shorter look misses mouths, a longer one sees the next junction");

/// The look is never shorter than this many times the width of the vehicle, so that it reaches past the vehicle in narrow
/// places.
const LEAST_LOOK_WIDTHS: f64 = 2.5;

/// The look is never longer, so that in a hall it stays where walls have enough returns.
const FARTHEST_LOOK_M: f64 = 12.0;

use crate::beyond::KnownOpening;
use crate::rays::{Ray, RayEnd, Rays};
use crate::surroundings::{REACH_M, Surroundings};

/// Parameters of the place.
pub(crate) const PLACE_PARAMS: [ParamSpec; 1] = [LOOK_WIDTHS.spec];

/// The place is judged in three looks; where they differ it is in doubt.
const LOOKS: [f64; 3] = [1.0, 0.85, 1.15];

/// What matters of a ray lies within this many times the look.
const FARTHEST_REACH: f64 = LOOKS[2] * LEAST_REACH;

/// In the middle of a place, a look of `look_widths` local widths that is shorter by this sees its mouths, too.
const MIDDLE_LOOKS: f64 = 0.6;

/// A mouth is at least this wide, in local widths.
const LEAST_MOUTH_WIDTHS: f64 = 0.25;

/// Behind a mouth without an opening some beam reaches this many times the radius of the circle.
const LEAST_REACH: f64 = 1.1;

/// Rock between two mouths that is narrower than this on the circle does not part them.
const LEAST_ROCK_M: f64 = 0.3;

/// Walls beside what was never seen run on side by side if their directions differ by less.
const SIDE_BY_SIDE_RAD: f64 = 0.6;

/// The direction of a wall is that of its last part of this length, if that much is known.
const WALL_END_M: f64 = 0.6;
const LEAST_WALL_END_M: f64 = 0.2;

/// Ends of neighbouring rays that are farther apart than this are of two walls.
const ONE_WALL_M: f64 = 0.6;

/// What was never seen but is taken to be a way halves the confidence.
const UNSEEN_CONFIDENCE: f64 = 0.5;

/// A place this many times wider than its ways is a chamber.
const CHAMBER_WIDTHS: f64 = 1.5;

/// Finds the place that the vehicle is in.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Places {
    look_widths: f64,
    vehicle_width_m: f64,
}

impl Places {
    /// From checked values of [`PARAMS`](crate::PARAMS), for a vehicle of this width.
    pub(crate) fn new(params: &Params, vehicle_width_m: f64) -> Self {
        Self { look_widths: params.get(LOOK_WIDTHS), vehicle_width_m }
    }

    /// The place of the next revolution with its rays, its report, its openings by all that was seen, and what was seen around its
    /// pose; `None` beside one wall alone, and for a limited view that has not seen enough around it yet, or has no pose.
    pub(crate) fn here(
        &self,
        sweep: &Sweep,
        junction: &Junction,
        known: &[KnownOpening],
        mut rays: Rays,
        seen: Option<(&Surroundings, &Isometry2<f64>)>,
    ) -> Option<Here> {
        let view = sweep.view();
        // A mouth shows where beams leave the look.
        let mut farthest_look_m = FARTHEST_LOOK_M.min(sweep.range_max_m / FARTHEST_REACH);
        if !view.full_turn {
            let (surroundings, pose) = seen?;
            farthest_look_m = farthest_look_m.min(REACH_M / FARTHEST_REACH);
            let reach_m = farthest_look_m * FARTHEST_REACH;
            rays.look_back(sweep.step_rad, |bearing_rad| surroundings.ray(pose, bearing_rad, reach_m));
        }
        let width_m = rays.local_width_m();
        // In a wide place the ways are as wide as its openings: a look of its own width would see a short one end.
        let opening_m = junction.openings.iter().map(|opening| opening.width_m).max_by(f64::total_cmp);
        let passage_m = opening_m.map_or(width_m, |opening_m| opening_m.min(width_m));
        let wanted_m =
            (0.5 * width_m + (self.look_widths - 0.5) * passage_m).max(LEAST_LOOK_WIDTHS * self.vehicle_width_m);
        let look_m = wanted_m.min(farthest_look_m);
        let within = |look_m: f64| rays.place(look_m, width_m, self.vehicle_width_m, &junction.openings, known);
        let [place, shorter, longer] = LOOKS.map(|times| within(times * look_m));
        let LookResult { kind, ways, is_seen } = place?;
        let is_alike = |other: &Option<LookResult>| {
            other.as_ref().is_some_and(|other| (other.kind, other.ways.len()) == (kind, ways.len()))
        };
        let alike = 1 + [shorter, longer].iter().filter(|other| is_alike(other)).count();
        let seen = if is_seen { 1.0 } else { UNSEEN_CONFIDENCE };
        let confidence = junction.confidence.unwrap_or(0.0) * seen * alike as f64 / LOOKS.len() as f64;
        // In a hall that is wider than the look any part is its middle; a limited view shows none, as what it sees behind is not
        // as sure as what lies ahead.
        let middle_m = (MIDDLE_LOOKS * self.look_widths * width_m).min(look_m);
        let is_middle = view.full_turn && within(middle_m).is_some_and(|middle| middle.ways.len() == ways.len());
        Some(Here { kind, look_m, ways, is_middle, confidence })
    }
}

/// The place within a circle.
struct LookResult {
    kind: HereKind,
    /// By bearing.
    ways: Vec<Way>,
    /// Each way was seen.
    is_seen: bool,
}

impl Rays {
    /// The shortest free line through the sensor.
    fn local_width_m(&self) -> f64 {
        let mut after = 0;
        let across_m = self.rays.iter().filter_map(|ray| {
            // What lies behind the rays turns as they do: the search begins where the last one ended, and once at the first.
            let back_rad = self.after_first_rad(ray.bearing_rad + PI);
            let is_before = |at: usize| self.rays.get(at).is_some_and(|other| other.bearing_rad < back_rad);
            after = if after > 0 && !is_before(after - 1) { 0 } else { after };
            while is_before(after) {
                after += 1;
            }
            let back = &self.rays[self.beside(back_rad, after)];
            let is_known = [ray, back].iter().all(|ray| ray.end != RayEnd::Unknown);
            is_known.then_some(ray.free_m + back.free_m)
        });
        across_m.fold(f64::INFINITY, f64::min)
    }

    /// The place within a circle, by the openings of the scan that are still known to be some; `None` if too much of the circle was
    /// never seen.
    fn place(
        &self,
        look_m: f64,
        width_m: f64,
        vehicle_width_m: f64,
        openings: &[Opening],
        known: &[KnownOpening],
    ) -> Option<LookResult> {
        // In a narrow view no line through the sensor may be known: the width is then at least that of the circle.
        let least_m = vehicle_width_m.max(LEAST_MOUTH_WIDTHS * width_m.min(2.0 * look_m));
        let is_unseen = |ray: &Ray| ray.end == RayEnd::Unknown && ray.free_m <= look_m;
        let unseen = self.runs(look_m, least_m, is_unseen);
        let unseen: Vec<Way> = unseen.iter().map(|run| self.unseen_way(run, look_m, least_m)).collect::<Option<_>>()?;
        let is_seen = unseen.is_empty();
        // What was never seen and is narrower than a mouth parts none.
        let runs = self.runs(look_m, least_m, |ray| ray.free_m > look_m || is_seen && is_unseen(ray));
        if runs.iter().any(|run| run.has_rock() && self.arc_m(run.first - 1, run.first + run.len, 1.0) >= PI) {
            return None;
        }
        let mut nearest: Vec<Option<(f64, usize)>> = vec![None; runs.len()];
        for index in known.iter().filter_map(|opening| opening.index) {
            let opening = &openings[index];
            let ends_m = opening.edge_m.map(|end_m| end_m.coords.xy());
            let near_m = ends_m[0].norm().min(ends_m[1].norm());
            let far = ends_m.iter().filter(|end_m| end_m.norm() > look_m).map(|end_m| self.at(end_m.y.atan2(end_m.x)));
            let middle = self.at(opening.bearing_rad);
            let run = far.chain([middle]).find_map(|at| runs.iter().position(|run| run.contains(at)));
            if let Some(run) = run
                && nearest[run].is_none_or(|(other_m, _)| near_m < other_m)
            {
                nearest[run] = Some((near_m, index));
            }
        }
        let is_deep = |run: &BeamRun| run.reach_m >= LEAST_REACH * look_m;
        let behind = runs.iter().zip(&nearest).filter(|(run, opening)| opening.is_some() || is_deep(run));
        let way = |run: &BeamRun, opening: &Option<(f64, usize)>| {
            let arc_m = self.arc_m(run.first - 1, run.first + run.len, look_m);
            let from_rad = self.bearing_rad(run.first - 1);
            Way {
                bearing_rad: wrap_angle_rad(from_rad + arc_m / look_m / 2.0),
                width_m: 2.0 * look_m * (arc_m / look_m / 2.0).min(FRAC_PI_2).sin(),
                opening: opening.map(|(_, index)| index),
            }
        };
        let mut ways: Vec<Way> = behind.map(|(run, opening)| way(run, opening)).chain(unseen).collect();
        ways.sort_by(|a, b| a.bearing_rad.total_cmp(&b.bearing_rad));
        let opening_m = |way: &Way| way.opening.map(|index| openings[index].width_m);
        let widest_m = ways.iter().filter_map(opening_m).fold(0.0, f64::max);
        let is_wide = widest_m > 0.0 && width_m > CHAMBER_WIDTHS * widest_m;
        let kind = match ways.len() {
            0 => HereKind::Chamber,
            1 | 2 if is_wide => HereKind::Chamber,
            1 => HereKind::DeadEnd,
            2 => HereKind::Passage,
            _ => HereKind::Junction,
        };
        // A flight that begins at the face of a dead end sees the same walls behind it as one that begins in a passage.
        (is_seen || ways.len() != 2).then_some(LookResult { kind, ways, is_seen })
    }

    /// The way that a run of rays which end at what was never seen is taken to be: between two walls that run on side by
    /// side.
    fn unseen_way(&self, run: &BeamRun, look_m: f64, least_m: f64) -> Option<Way> {
        let n = self.rays.len() as isize;
        let before = self.wall_end((run.first as isize - 1).rem_euclid(n), -1, look_m)?;
        let after = self.wall_end((run.first + run.len) as isize % n, 1, look_m)?;
        let [(from_m, along), (to_m, other)] = [before, after];
        if along.angle(&other) > SIDE_BY_SIDE_RAD {
            return None;
        }
        let (chord_m, middle_m) = (to_m - from_m, 0.5 * (from_m + to_m));
        let width_m = chord_m.perp(&(along + other).normalize()).abs();
        let bearing_rad = middle_m.y.atan2(middle_m.x);
        (width_m >= least_m).then_some(Way { bearing_rad, width_m, opening: None })
    }

    /// Where the wall at a ray ends, and the direction in which it does; the ray after it (`step`: -1 or 1, by bearing) sees
    /// more of it. `None` if the ray ends at no wall, or too little of it is known.
    fn wall_end(&self, at: isize, step: isize, look_m: f64) -> Option<(Vector2<f64>, Vector2<f64>)> {
        let n = self.rays.len() as isize;
        let end_m = |at: isize| {
            let ray = &self.rays[at.rem_euclid(n) as usize];
            let is_wall = matches!(ray.end, RayEnd::Wall(_) | RayEnd::WallBefore);
            is_wall.then(|| ray.end_m())
        };
        let first_m = end_m(at).filter(|end_m| end_m.norm() <= look_m)?;
        let mut last_m = first_m;
        for further in 1..n / 2 {
            let Some(next_m) = end_m(at + step * further).filter(|next_m| (next_m - last_m).norm() < ONE_WALL_M) else {
                break;
            };
            last_m = next_m;
            if (last_m - first_m).norm() > WALL_END_M {
                break;
            }
        }
        let along_m = first_m - last_m;
        (along_m.norm() >= LEAST_WALL_END_M).then(|| (first_m, along_m.normalize()))
    }

    /// Runs of rays that `holds` is true for, at least this wide on the circle.
    fn runs(&self, look_m: f64, least_m: f64, holds: impl Fn(&Ray) -> bool) -> Vec<BeamRun> {
        let n = self.rays.len();
        let ray = |at: usize| &self.rays[if at < n { at } else { at - n }];
        let is_in = |at: usize| holds(ray(at));
        // The widest rock parts the first mouth from the last.
        let (start, rock) = widest_run(n, |at| !is_in(at));
        if rock == 0 {
            return vec![BeamRun { first: n, len: n - 1, of: n, reach_m: f64::INFINITY }];
        }
        let mut runs: Vec<BeamRun> = Vec::new();
        for at in (start..start + n).filter(|&at| is_in(at)) {
            // What was never seen is not known to end.
            let reach_m = if ray(at).end == RayEnd::Unknown { f64::INFINITY } else { ray(at).free_m };
            let is_same = |run: &&mut BeamRun| {
                let last = run.first + run.len - 1;
                at == last + 1 || self.arc_m(last, at, look_m) < LEAST_ROCK_M
            };
            match runs.last_mut().filter(is_same) {
                Some(run) => (run.len, run.reach_m) = (at + 1 - run.first, run.reach_m.max(reach_m)),
                None => runs.push(BeamRun { first: at, len: 1, of: n, reach_m }),
            }
        }
        // From the ray before a run to the one after it.
        runs.retain(|run| self.arc_m(run.first - 1, run.first + run.len, look_m) >= least_m);
        runs
    }
}

/// A run of rays.
struct BeamRun {
    /// Its first ray, counted beyond the turn.
    first: usize,
    len: usize,
    /// Number of rays in the turn.
    of: usize,
    /// The farthest of them.
    reach_m: f64,
}

impl BeamRun {
    /// The circle crosses rock somewhere.
    fn has_rock(&self) -> bool {
        self.reach_m.is_finite()
    }

    fn contains(&self, at: usize) -> bool {
        (at + self.of - self.first % self.of) % self.of < self.len
    }
}
