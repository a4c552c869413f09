//! How far it is free in each direction of a view.

use std::f64::consts::TAU;

use crosscut_stage::{Beam, Junction, Revolution, unit};
use nalgebra::Vector2;

/// Returns of one wall that are a wider angle apart are not joined.
const MAX_JOINED_RAD: f64 = 2.6;

/// One direction of a view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ray {
    pub(crate) bearing_rad: f64,
    /// A unit vector.
    pub(crate) towards: Vector2<f64>,
    /// Nothing stands nearer than this.
    pub(crate) free_m: f64,
    pub(crate) end: RayEnd,
}

impl Ray {
    pub(crate) fn new(bearing_rad: f64, free_m: f64, end: RayEnd) -> Self {
        Self { bearing_rad, towards: unit(bearing_rad), free_m, end }
    }

    /// Where its free part ends, metres.
    pub(crate) fn end_m(&self) -> Vector2<f64> {
        self.towards * self.free_m
    }
}

/// What is at the end of the free part of a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RayEnd {
    /// A wall, with its number in the scan.
    Wall(u32),
    /// A wall that an earlier scan saw.
    WallBefore,
    /// The range of the sensor.
    Range,
    /// What was not seen.
    Unknown,
}

/// How far each direction is free.
pub(crate) struct Rays {
    /// Ascending by bearing, anticlockwise from the first, over less than a turn.
    pub(crate) rays: Vec<Ray>,
    /// They are all around.
    pub(crate) full_turn: bool,
    /// The returns of walls, anticlockwise, metres; and whether the wall goes on to the next one.
    returns: Vec<(Vector2<f64>, bool)>,
}

impl Rays {
    /// The returns of walls alone: islands and dust hide nothing that matters here.
    pub(crate) fn of(revolution: &Revolution, junction: &Junction) -> Option<Self> {
        let sweep = revolution.beams()?;
        let view = sweep.view();
        let last = (view.first + view.len).checked_sub(1)? % (sweep.len() + sweep.missing).max(1);
        let &first_rad = sweep.bearings_rad.get(if view.clockwise { last } else { view.first })?;
        let step_rad = sweep.step_rad;
        let is_island = |id: u32| junction.walls.iter().any(|wall| wall.id == id && wall.island);
        let wall_of = |number: u32| junction.wall_of_return.get(number as usize).copied().flatten();
        let beams: Vec<Beam> = sweep.anticlockwise(view).collect();
        let of_wall = |(at, beam): (usize, &Beam)| match *beam {
            Beam::Return(number) => {
                let wall = wall_of(number).filter(|&id| !is_island(id))?;
                Some((at, wall, number))
            }
            Beam::NoReturn | Beam::Unknown => None,
        };
        let returns: Vec<(usize, u32, u32)> = beams.iter().enumerate().filter_map(of_wall).collect();
        let dark_m = |beam: &Beam| (*beam == Beam::NoReturn).then_some((sweep.range_max_m, RayEnd::Range));
        let mut free: Vec<Option<(f64, RayEnd)>> = beams.iter().map(dark_m).collect();
        let mut places = Vec::with_capacity(returns.len());
        for (&(at, wall, number), &(next, next_wall, next_number)) in returns.iter().zip(returns.iter().cycle().skip(1))
        {
            let [from_m, to_m] = [number, next_number].map(|number| revolution.range_m(number as usize));
            free[at] = Some((from_m, RayEnd::Wall(wall)));
            let apart = if next > at { next - at } else { next + beams.len() - at };
            let apart_rad = apart as f64 * step_rad;
            let is_past_the_view = next <= at && !view.full_turn;
            let goes_on = wall == next_wall && apart_rad <= MAX_JOINED_RAD && !is_past_the_view;
            places.push((revolution.points_m[number as usize].coords.xy(), goes_on));
            if !goes_on {
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
            Some(Ray::new(first_rad + at as f64 * step_rad, free_m, end))
        });
        (!returns.is_empty()).then(|| Self { rays: known.collect(), full_turn: view.full_turn, returns: places })
    }

    /// Rays of a limited view, or of a full turn, which end at one wall.
    #[cfg(test)]
    pub(crate) fn of_one_wall(rays: Vec<Ray>, full_turn: bool) -> Self {
        let returns = rays.iter().map(|ray| (ray.end_m(), true)).collect();
        Self { rays, full_turn, returns }
    }

    /// The ends of each gap between two returns of one wall, clockwise first.
    pub(crate) fn joined(&self) -> impl Iterator<Item = [Vector2<f64>; 2]> {
        let next = self.returns.iter().cycle().skip(1);
        self.returns
            .iter()
            .zip(next)
            .filter(|((_, goes_on), _)| *goes_on)
            .map(|((from_m, _), (to_m, _))| [*from_m, *to_m])
    }

    /// Each ray of the view, and the next one.
    pub(crate) fn pairs(&self) -> impl Iterator<Item = (&Ray, &Ray)> {
        let next = self.rays.iter().cycle().skip(1);
        self.rays.iter().zip(next).take(self.rays.len() - usize::from(!self.full_turn))
    }

    /// Whether a place lies nearer than the line between the ends of the two rays beside it.
    pub(crate) fn sees(&self, place_m: &Vector2<f64>) -> bool {
        let turned_rad = self.after_first_rad(place_m.y.atan2(place_m.x));
        let after = self.rays.partition_point(|ray| ray.bearing_rad <= turned_rad);
        if after == self.rays.len() && !self.full_turn {
            return false;
        }
        let [from, to] = [&self.rays[after - 1], &self.rays[after % self.rays.len()]];
        let apart_rad = (to.bearing_rad - from.bearing_rad).rem_euclid(TAU);
        let [from_m, to_m] = [from, to].map(Ray::end_m);
        apart_rad <= MAX_JOINED_RAD && (to_m - from_m).perp(&(place_m - from_m)) > 0.0
    }

    /// Adds the directions that are outside the view.
    pub(crate) fn look_back(&mut self, step_rad: f64, ray: impl Fn(f64) -> Ray) {
        let (Some(first), Some(last)) = (self.rays.first(), self.rays.last()) else { return };
        let (from_rad, to_rad) = (last.bearing_rad + step_rad, first.bearing_rad + TAU - 0.5 * step_rad);
        let unseen =
            (0..).map(|at| from_rad + f64::from(at) * step_rad).take_while(|&bearing_rad| bearing_rad < to_rad);
        self.rays.extend(unseen.map(ray));
    }

    /// The ray that is nearest to a bearing.
    pub(crate) fn at(&self, bearing_rad: f64) -> usize {
        let turned_rad = self.after_first_rad(bearing_rad);
        self.beside(turned_rad, self.rays.partition_point(|ray| ray.bearing_rad < turned_rad))
    }

    /// A bearing, counted from that of the first ray on over a turn.
    pub(crate) fn after_first_rad(&self, bearing_rad: f64) -> f64 {
        let first_rad = self.rays[0].bearing_rad;
        first_rad + (bearing_rad - first_rad).rem_euclid(TAU)
    }

    /// The ray that is nearest to a bearing, of the one `after` it and the one before that.
    pub(crate) fn beside(&self, turned_rad: f64, after: usize) -> usize {
        let (before, after) = (after.saturating_sub(1), after % self.rays.len());
        let apart_rad = |at: usize| {
            let apart_rad = (self.rays[at].bearing_rad - turned_rad).rem_euclid(TAU);
            apart_rad.min(TAU - apart_rad)
        };
        if apart_rad(before) <= apart_rad(after) { before } else { after }
    }

    /// The length of the circle's arc from one ray to another, both counted beyond a turn.
    pub(crate) fn arc_m(&self, from: usize, to: usize, look_m: f64) -> f64 {
        look_m * (self.bearing_rad(to) - self.bearing_rad(from))
    }

    /// The bearing of a ray counted beyond a turn.
    pub(crate) fn bearing_rad(&self, at: usize) -> f64 {
        self.rays[at % self.rays.len()].bearing_rad + (at / self.rays.len()) as f64 * TAU
    }
}
