//! The place that the vehicle is in, and which of the openings in view belong to it.
//!
//! From a passage the next junction is often in view: its openings are no ways of the passage. The place here is the free
//! space within the look, a circle of 1.5 local widths (`look_widths`) around the sensor:
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
//! - Three mouths and more are a junction, two a passage, one a dead end; none, or up to two of a place that is more than
//!   twice as wide as they are, a chamber.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use crosscut_stage::{
    Beam, Here, HereKind, Junction, Number, Opening, ParamSpec, Params, Revolution, Sweep, Way, wrap_angle_rad,
};

const LOOK_WIDTHS: Number = Number::new("look_widths", "widths", 1.5)
    .from(0.6)
    .to(10.0)
    .doc("the place is what lies this many local widths around; a shorter look misses mouths, a longer one sees the next junction");

const LEAST_LOOK_M: Number = Number::new("least_look_m", "m", 1.5)
    .above(0.0)
    .to(100.0)
    .follows("vehicle.width_m", 2.5)
    .doc("the look is never shorter, so that it reaches past the vehicle in narrow places");

const FARTHEST_LOOK_M: Number = Number::new("farthest_look_m", "m", 12.0)
    .above(0.0)
    .to(1000.0)
    .doc("the look is never longer, so that in a hall it stays where walls have enough returns");

/// Parameters of the place.
pub(crate) const PLACE_PARAMS: [ParamSpec; 3] = [LOOK_WIDTHS.spec, LEAST_LOOK_M.spec, FARTHEST_LOOK_M.spec];

/// The place is judged in three looks; where they differ it is in doubt.
const LOOKS: [f64; 3] = [1.0, 0.85, 1.15];

/// A mouth is at least this wide, in local widths.
const LEAST_MOUTH_WIDTHS: f64 = 0.25;

/// Behind a mouth without an opening some beam reaches this many times the radius of the circle.
const LEAST_REACH: f64 = 1.05;

/// Returns of one wall that are a wider angle apart are not joined.
const MAX_JOINED_RAD: f64 = 2.6;

/// Rock between two mouths that is narrower than this on the circle does not part them.
const LEAST_ROCK_M: f64 = 0.3;

/// A place this many times wider than its ways is a chamber.
const CHAMBER_WIDTHS: f64 = 2.0;

/// Finds the place that the vehicle is in.
#[derive(Clone, Debug)]
pub struct Places {
    look_widths: f64,
    least_look_m: f64,
    farthest_look_m: f64,
    vehicle_width_m: f64,
}

impl Places {
    /// From checked values of [`PARAMS`](crate::PARAMS), for a vehicle of this width.
    pub fn new(params: &Params, vehicle_width_m: f64) -> Self {
        Self {
            look_widths: params.get(LOOK_WIDTHS),
            least_look_m: params.get(LEAST_LOOK_M),
            farthest_look_m: params.get(FARTHEST_LOOK_M),
            vehicle_width_m,
        }
    }

    /// The place of a revolution with its report; `None` for a cloud, a limited view, and where no wall is in view.
    pub fn here(&self, revolution: &Revolution, junction: &Junction) -> Option<Here> {
        let outline = Outline::of(revolution, revolution.as_sweep()?, junction)?;
        let width_m = outline.local_width_m();
        let look_m = (self.look_widths * width_m).max(self.least_look_m).min(self.farthest_look_m);
        let places =
            LOOKS.map(|times| outline.place(times * look_m, width_m, self.vehicle_width_m, &junction.openings));
        let alike = places.iter().filter(|(kind, ways)| (*kind, ways.len()) == (places[0].0, places[0].1.len()));
        let confidence = junction.confidence * alike.count() as f64 / places.len() as f64;
        let [(kind, ways), ..] = places;
        Some(Here { kind, look_m, ways, confidence })
    }
}

/// How far each direction is free.
struct Outline {
    /// Bearing, anticlockwise from the first, and free range, metres; ascending by bearing over less than a turn.
    free: Vec<[f64; 2]>,
}

impl Outline {
    /// The returns of walls alone: islands and dust hide nothing that matters here.
    fn of(revolution: &Revolution, sweep: &Sweep, junction: &Junction) -> Option<Self> {
        let view = sweep.view();
        let at_first = if view.clockwise { sweep.bearings_rad.last() } else { sweep.bearings_rad.first() };
        let (&first_rad, step_rad) = (at_first.filter(|_| view.full_turn)?, sweep.step_rad);
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
        let dark_m = |beam: &Beam| (*beam == Beam::NoReturn).then_some(sweep.range_max_m);
        let mut free_m: Vec<Option<f64>> = beams.iter().map(dark_m).collect();
        for (&(at, wall, from_m), &(next, next_wall, to_m)) in returns.iter().zip(returns.iter().cycle().skip(1)) {
            free_m[at] = Some(from_m);
            let apart = if next > at { next - at } else { next + beams.len() - at };
            let apart_rad = apart as f64 * step_rad;
            if wall != next_wall || apart_rad > MAX_JOINED_RAD {
                continue;
            }
            for beam in 1..apart {
                let turn_rad = beam as f64 * step_rad;
                // Where the beam meets the line from the one return to the other.
                let across_m = from_m * turn_rad.sin() + to_m * (apart_rad - turn_rad).sin();
                free_m[(at + beam) % beams.len()] = Some(from_m * to_m * apart_rad.sin() / across_m);
            }
        }
        let bearing_rad = |at: usize| first_rad + at as f64 * step_rad;
        let known = free_m.into_iter().enumerate().filter_map(|(at, free_m)| Some([bearing_rad(at), free_m?]));
        (!returns.is_empty()).then(|| Self { free: known.collect() })
    }

    /// The free range of the sample that is nearest to a bearing.
    fn at(&self, bearing_rad: f64) -> usize {
        let turned_rad = self.free[0][0] + (bearing_rad - self.free[0][0]).rem_euclid(TAU);
        let after = self.free.partition_point(|sample| sample[0] < turned_rad);
        let (before, after) = (after.saturating_sub(1), after % self.free.len());
        let apart_rad = |at: usize| {
            let apart_rad = (self.free[at][0] - turned_rad).rem_euclid(TAU);
            apart_rad.min(TAU - apart_rad)
        };
        if apart_rad(before) <= apart_rad(after) { before } else { after }
    }

    /// The shortest free line through the sensor.
    fn local_width_m(&self) -> f64 {
        let across_m = self.free.iter().map(|&[bearing_rad, free_m]| free_m + self.free[self.at(bearing_rad + PI)][1]);
        across_m.fold(f64::INFINITY, f64::min)
    }

    /// The kind of place within a circle, and its ways by bearing.
    fn place(&self, look_m: f64, width_m: f64, vehicle_width_m: f64, openings: &[Opening]) -> (HereKind, Vec<Way>) {
        let runs = self.runs(look_m, vehicle_width_m.max(LEAST_MOUTH_WIDTHS * width_m));
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
        let is_deep = |run: &Run| run.reach_m >= LEAST_REACH * look_m;
        let behind = runs.iter().zip(&nearest).filter(|(run, opening)| opening.is_some() || is_deep(run));
        let way = |run: &Run, opening: &Option<(f64, usize)>| {
            let arc_m = self.arc_m(run.first - 1, run.first + run.len, look_m);
            let from_rad = self.bearing_rad(run.first - 1);
            Way {
                bearing_rad: wrap_angle_rad(from_rad + arc_m / look_m / 2.0),
                width_m: 2.0 * look_m * (arc_m / look_m / 2.0).min(FRAC_PI_2).sin(),
                opening: opening.map(|(_, index)| index),
            }
        };
        let mut ways: Vec<Way> = behind.map(|(run, opening)| way(run, opening)).collect();
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
        (kind, ways)
    }

    /// Runs of samples that leave the circle, at least this wide.
    fn runs(&self, look_m: f64, least_m: f64) -> Vec<Run> {
        let n = self.free.len();
        let is_out = |at: usize| self.free[at % n][1] > look_m;
        let Some(start) = (0..n).find(|&at| !is_out(at)) else {
            return vec![Run { first: n, len: n - 1, of: n, reach_m: f64::INFINITY }];
        };
        let mut runs: Vec<Run> = Vec::new();
        for at in (start..start + n).filter(|&at| is_out(at)) {
            let reach_m = self.free[at % n][1];
            let is_same = |run: &&mut Run| {
                let last = run.first + run.len - 1;
                at == last + 1 || self.arc_m(last, at, look_m) < LEAST_ROCK_M
            };
            match runs.last_mut().filter(is_same) {
                Some(run) => (run.len, run.reach_m) = (at + 1 - run.first, run.reach_m.max(reach_m)),
                None => runs.push(Run { first: at, len: 1, of: n, reach_m }),
            }
        }
        // From the blocked sample before a run to the one after it.
        runs.retain(|run| self.arc_m(run.first - 1, run.first + run.len, look_m) >= least_m);
        runs
    }

    /// The length of the circle's arc from one sample to another, both counted beyond a turn.
    fn arc_m(&self, from: usize, to: usize, look_m: f64) -> f64 {
        look_m * (self.bearing_rad(to) - self.bearing_rad(from))
    }

    /// The bearing of a sample counted beyond a turn.
    fn bearing_rad(&self, at: usize) -> f64 {
        self.free[at % self.free.len()][0] + (at / self.free.len()) as f64 * TAU
    }
}

/// A run of samples that leave the circle.
struct Run {
    /// Its first sample, counted beyond the turn.
    first: usize,
    len: usize,
    /// Number of samples in the turn.
    of: usize,
    /// The farthest of them.
    reach_m: f64,
}

impl Run {
    fn contains(&self, at: usize) -> bool {
        (at + self.of - self.first % self.of) % self.of < self.len
    }
}
