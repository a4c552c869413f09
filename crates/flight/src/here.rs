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
//!   width. Some beam reaches 5 % farther, or an opening lies behind it. A passage that is seen to end has a mouth, too.
//! - **Ways** are the openings behind mouths, one for each mouth: the one with the nearest edge.
//! - Where a limited view does not look, what earlier scans saw there counts ([`Surroundings`]). What was never seen and is
//!   wider than a mouth is a way, with half the confidence, if the walls on both sides of it run on side by side, and the
//!   place is no passage then; else it is not known.
//! - A mouth of half a turn or more leads out of no place: one wall is beside the sensor, and the place is not known.
//! - Three ways and more are a junction, two a passage, one a dead end; none, or up to two of a place that is more than
//!   1.5 times as wide as they are, a chamber.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use crosscut_stage::{
    Beam, Junction, Number, Opening, ParamSpec, Params, Revolution, Sweep, View, unit, widest_run, wrap_angle_rad,
};
use nalgebra::Vector2;

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

use crate::Tracked;
use crate::surroundings::{REACH_M, Ray, RayEnd, Surroundings};

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
const LEAST_REACH: f64 = 1.05;

/// Returns of one wall that are a wider angle apart are not joined.
const MAX_JOINED_RAD: f64 = 2.6;

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
#[derive(Clone, Debug)]
pub struct Places {
    look_widths: f64,
    vehicle_width_m: f64,
    surroundings: Surroundings,
}

impl Places {
    /// From checked values of [`PARAMS`](crate::PARAMS), for a vehicle of this width.
    pub fn new(params: &Params, vehicle_width_m: f64) -> Self {
        Self { look_widths: params.get(LOOK_WIDTHS), vehicle_width_m, surroundings: Surroundings::default() }
    }

    /// What earlier scans saw is forgotten: the poses that follow do not go with those before.
    pub fn forget(&mut self) {
        self.surroundings.clear();
    }

    /// The place of the next revolution with its report and its pose; `None` for a cloud, where no wall is in view, and
    /// beside one wall alone; and for a limited view that has not seen enough around it yet, or has no pose.
    pub fn here(&mut self, revolution: &Revolution, junction: &Junction, tracked: Option<&Tracked>) -> Option<Here> {
        let sweep = revolution.beams()?;
        let view = sweep.view();
        let mut outline = Outline::of(revolution, sweep, junction, view)?;
        // A mouth shows where beams leave the look.
        let mut farthest_look_m = FARTHEST_LOOK_M.min(sweep.range_max_m / FARTHEST_REACH);
        if !view.full_turn {
            let tracked = tracked?;
            farthest_look_m = farthest_look_m.min(REACH_M / FARTHEST_REACH);
            self.surroundings.add(tracked, &outline.rays);
            let reach_m = farthest_look_m * FARTHEST_REACH;
            outline.look_back(sweep.step_rad, |bearing_rad| self.surroundings.ray(&tracked.pose, bearing_rad, reach_m));
        }
        let width_m = outline.local_width_m();
        // In a wide place the ways are as wide as its openings: a look of its own width would see a short one end.
        let opening_m = junction.openings.iter().map(|opening| opening.width_m).max_by(f64::total_cmp);
        let passage_m = opening_m.map_or(width_m, |opening_m| opening_m.min(width_m));
        let wanted_m =
            (0.5 * width_m + (self.look_widths - 0.5) * passage_m).max(LEAST_LOOK_WIDTHS * self.vehicle_width_m);
        let look_m = wanted_m.min(farthest_look_m);
        let [place, shorter, longer] =
            LOOKS.map(|times| outline.place(times * look_m, width_m, self.vehicle_width_m, &junction.openings));
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
        let middle = outline.place(middle_m, width_m, self.vehicle_width_m, &junction.openings);
        let is_middle = view.full_turn && middle.is_some_and(|middle| middle.ways.len() == ways.len());
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

/// How far each direction is free.
struct Outline {
    /// Ascending by bearing, anticlockwise from the first, over less than a turn.
    rays: Vec<Ray>,
}

impl Outline {
    /// The returns of walls alone: islands and dust hide nothing that matters here.
    fn of(revolution: &Revolution, sweep: &Sweep, junction: &Junction, view: View) -> Option<Self> {
        let last = (view.first + view.len).checked_sub(1)? % (sweep.len() + sweep.missing).max(1);
        let &first_rad = sweep.bearings_rad.get(if view.clockwise { last } else { view.first })?;
        let step_rad = sweep.step_rad;
        let is_island = |id: u32| junction.walls.iter().any(|wall| wall.id == id && wall.island);
        let wall_of = |number: u32| junction.wall_of_return.get(number as usize).copied().flatten();
        let beams: Vec<Beam> = sweep.anticlockwise(view).collect();
        let of_wall = |(at, beam): (usize, &Beam)| match *beam {
            Beam::Return(number) => {
                let wall = wall_of(number).filter(|&id| !is_island(id))?;
                Some((at, wall, revolution.range_m(number as usize)))
            }
            Beam::NoReturn | Beam::Unknown => None,
        };
        let returns: Vec<(usize, u32, f64)> = beams.iter().enumerate().filter_map(of_wall).collect();
        let dark_m = |beam: &Beam| (*beam == Beam::NoReturn).then_some((sweep.range_max_m, RayEnd::Range));
        let mut free: Vec<Option<(f64, RayEnd)>> = beams.iter().map(dark_m).collect();
        for (&(at, wall, from_m), &(next, next_wall, to_m)) in returns.iter().zip(returns.iter().cycle().skip(1)) {
            free[at] = Some((from_m, RayEnd::Wall(wall)));
            let apart = if next > at { next - at } else { next + beams.len() - at };
            let apart_rad = apart as f64 * step_rad;
            let is_past_the_view = next <= at && !view.full_turn;
            if wall != next_wall || apart_rad > MAX_JOINED_RAD || is_past_the_view {
                continue;
            }
            for beam in 1..apart {
                let turn_rad = beam as f64 * step_rad;
                // Where the beam meets the line from the one return to the other.
                let across_m = from_m * turn_rad.sin() + to_m * (apart_rad - turn_rad).sin();
                let joined_m = from_m * to_m * apart_rad.sin() / across_m;
                free[(at + beam) % beams.len()] = Some((joined_m, RayEnd::Wall(wall)));
            }
        }
        let known = free.into_iter().enumerate().filter_map(|(at, free)| {
            let (free_m, end) = free?;
            Some(Ray { bearing_rad: first_rad + at as f64 * step_rad, free_m, end })
        });
        (!returns.is_empty()).then(|| Self { rays: known.collect() })
    }

    /// Adds the directions that are outside the view.
    fn look_back(&mut self, step_rad: f64, ray: impl Fn(f64) -> Ray) {
        let (Some(first), Some(last)) = (self.rays.first(), self.rays.last()) else { return };
        let (from_rad, to_rad) = (last.bearing_rad + step_rad, first.bearing_rad + TAU - 0.5 * step_rad);
        let unseen =
            (0..).map(|at| from_rad + f64::from(at) * step_rad).take_while(|&bearing_rad| bearing_rad < to_rad);
        self.rays.extend(unseen.map(ray));
    }

    /// The ray that is nearest to a bearing.
    fn at(&self, bearing_rad: f64) -> usize {
        let turned_rad = self.after_first_rad(bearing_rad);
        self.beside(turned_rad, self.rays.partition_point(|ray| ray.bearing_rad < turned_rad))
    }

    /// A bearing, counted from that of the first ray on over a turn.
    fn after_first_rad(&self, bearing_rad: f64) -> f64 {
        let first_rad = self.rays[0].bearing_rad;
        first_rad + (bearing_rad - first_rad).rem_euclid(TAU)
    }

    /// The ray that is nearest to a bearing, of the one `after` it and the one before that.
    fn beside(&self, turned_rad: f64, after: usize) -> usize {
        let (before, after) = (after.saturating_sub(1), after % self.rays.len());
        let apart_rad = |at: usize| {
            let apart_rad = (self.rays[at].bearing_rad - turned_rad).rem_euclid(TAU);
            apart_rad.min(TAU - apart_rad)
        };
        if apart_rad(before) <= apart_rad(after) { before } else { after }
    }

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

    /// The place within a circle; `None` if too much of the circle was never seen.
    fn place(&self, look_m: f64, width_m: f64, vehicle_width_m: f64, openings: &[Opening]) -> Option<LookResult> {
        // In a narrow view no line through the sensor may be known: the width is then at least that of the circle.
        let least_m = vehicle_width_m.max(LEAST_MOUTH_WIDTHS * width_m.min(2.0 * look_m));
        let is_unseen = |ray: &Ray| ray.end == RayEnd::Unknown && ray.free_m <= look_m;
        let unseen = self.runs(look_m, least_m, is_unseen);
        let unseen: Vec<Way> = unseen.iter().map(|run| self.unseen_way(run, look_m, least_m)).collect::<Option<_>>()?;
        let is_seen = unseen.is_empty();
        let runs = self.runs(look_m, least_m, |ray| ray.free_m > look_m);
        if runs.iter().any(|run| run.has_rock() && self.arc_m(run.first - 1, run.first + run.len, 1.0) >= PI) {
            return None;
        }
        let mut nearest: Vec<Option<(f64, usize)>> = vec![None; runs.len()];
        for (index, opening) in openings.iter().enumerate() {
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
            is_wall.then(|| unit(ray.bearing_rad) * ray.free_m)
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
            let reach_m = ray(at).free_m;
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

    /// The length of the circle's arc from one ray to another, both counted beyond a turn.
    fn arc_m(&self, from: usize, to: usize, look_m: f64) -> f64 {
        look_m * (self.bearing_rad(to) - self.bearing_rad(from))
    }

    /// The bearing of a ray counted beyond a turn.
    fn bearing_rad(&self, at: usize) -> f64 {
        self.rays[at % self.rays.len()].bearing_rad + (at / self.rays.len()) as f64 * TAU
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
