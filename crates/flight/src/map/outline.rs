//! Whether two outlines are of one place: point to line, from several starts.

use std::f64::consts::TAU;

use nalgebra::{Isometry2, Matrix3, Point2, Vector2};

use crate::evidence::{MatchEvidence, Matching, stepped};
use crate::line_points::LinePoint;
use crate::local_map::LocalMap;

/// At most this many line points are matched; more add time and no certainty.
const MOST_POINTS: usize = 160;

/// While a fit is looked for, every n-th of them is.
const SEARCHED_POINTS: usize = 2;

/// A line point lies on a wall that is no farther than this.
const ON_WALL_M: f64 = 0.12;

/// The kernel of the fit turns from a square to a constant about here.
const KERNEL_M: f64 = 0.3;

const ITERATIONS: usize = 15;

/// Where the anchors of two visits of one place lie to each other is known to within this, along each axis; starts are a step
/// apart.
pub(super) const APART_M: f64 = 5.0;
const START_STEP_M: f64 = 1.0;

/// The starts from which a fit is looked for: the best by [`Squares`].
const STARTS: usize = 3;

/// Walls as squares of this side, to find starts.
const SQUARE_M: f64 = 0.3;

/// What lies farther than this behind the nearest wall of its sector is hidden from the anchor.
const HIDDEN_M: f64 = 0.5;
const SECTORS: usize = 120;

/// How well one outline lies on another.
#[derive(Clone, Copy, Debug)]
pub struct Fit {
    /// The pose of the one in the frame of the other.
    pub pose: Isometry2<f64>,
    /// Share of its line points that lie on a wall of the other, and the other way round; the lesser of the two.
    pub share: f64,
}

/// The walls of a place, around its anchor.
#[derive(Clone, Debug)]
pub(crate) struct Walls {
    map: LocalMap,
    points: Vec<LinePoint>,
    squares: Squares,
    reach_m: f64,
    /// Of each sector around the anchor, the range of the nearest wall; infinite where there is none.
    sight_m: Vec<f64>,
}

impl Walls {
    pub(crate) fn new(outline: &[LinePoint]) -> Self {
        let mut map = LocalMap::default();
        outline.iter().for_each(|point| map.insert(*point));
        let every = outline.len().div_ceil(MOST_POINTS).max(1);
        let points: Vec<LinePoint> = outline.iter().step_by(every).copied().collect();
        let reach_m = points.iter().map(|point| point.position_m.coords.norm()).fold(0.0, f64::max);
        let squares = Squares::new(outline, reach_m);
        let mut sight_m = vec![f64::INFINITY; SECTORS];
        for point in outline {
            let sight_m = &mut sight_m[sector_of(&point.position_m)];
            *sight_m = sight_m.min(point.position_m.coords.norm());
        }
        Self { map, points, squares, reach_m, sight_m }
    }

    /// The best fit of `other` on these walls, about there.
    pub(crate) fn fit(&self, other: &Self, about: &Isometry2<f64>) -> Option<Fit> {
        self.fits(other, *about).max_by(|a, b| a.share.total_cmp(&b.share))
    }

    /// Fits of `other` on these walls: from there, and from the most promising starts within [`APART_M`] along each axis.
    pub(super) fn fits(&self, other: &Self, about: Isometry2<f64>) -> impl Iterator<Item = Fit> {
        let steps = (APART_M / START_STEP_M) as i32;
        let offsets = (-steps..=steps).flat_map(|x| (-steps..=steps).map(move |y| (x, y)));
        let starts = offsets.map(|(x, y)| {
            let offset_m = Vector2::new(f64::from(x), f64::from(y)) * START_STEP_M;
            Isometry2::new(about.translation.vector + offset_m, about.rotation.angle())
        });
        let mut starts: Vec<_> = starts.map(|start| (self.squares.hits(&other.points, &start), start)).collect();
        starts.sort_by_key(|(hits, _)| std::cmp::Reverse(*hits));
        let starts = starts.into_iter().take(STARTS).map(|(_, start)| start).chain([about]);
        let about_m = about.translation.vector;
        let fits = starts.map(move |start| {
            let pose = self.align(other, start);
            let shares = [self.share_on(other, &pose), other.share_on(self, &pose.inverse())];
            Fit { pose, share: shares[0].min(shares[1]) }
        });
        fits.filter(move |fit| (fit.pose.translation.vector - about_m).amax() <= APART_M + START_STEP_M)
    }

    /// Share of the line points of `other` at `pose` that lie on these walls, of those that are near enough to. Where these
    /// walls hide what is behind them, from the anchor at least, a point on none of them says nothing.
    fn share_on(&self, other: &Self, pose: &Isometry2<f64>) -> f64 {
        let (mut on, mut all) = (0, 0);
        for point in other.points.iter().map(|point| point.at(pose)) {
            if point.position_m.coords.norm() > 0.8 * self.reach_m {
                continue;
            }
            let is_on = |wall: &LinePoint| wall.normal.dot(&(point.position_m - wall.position_m)).abs() < ON_WALL_M;
            if self.map.nearest(&point).is_some_and(is_on) {
                on += 1;
                all += 1;
            } else if point.position_m.coords.norm() < self.sight_m[sector_of(&point.position_m)] + HIDDEN_M {
                all += 1;
            }
        }
        if all < 10 { 0.0 } else { f64::from(on as u32) / f64::from(all) }
    }

    /// The pose near `start` where the line points of `other` lie on these walls, point to line.
    fn align(&self, other: &Self, start: Isometry2<f64>) -> Isometry2<f64> {
        let mut pose = start;
        let mut matching = Matching::default();
        matching.begin(other.points.iter().step_by(SEARCHED_POINTS).copied());
        for _ in 0..ITERATIONS {
            let MatchEvidence { information, gradient, .. } = matching.at(&pose, &self.map, KERNEL_M);
            let Some(factor) = (information + Matrix3::identity() * 1e-3).cholesky() else { break };
            let step = factor.solve(&-gradient);
            pose = stepped(&pose, &step);
            if step.amax() < 1e-3 {
                break;
            }
        }
        pose
    }
}

/// Squares in which or beside which a wall lies: a rough and fast answer to how well line points lie on walls.
#[derive(Clone, Debug)]
struct Squares {
    is_wall: Vec<bool>,
    /// Squares from the middle to a side.
    half: i32,
}

impl Squares {
    fn new(outline: &[LinePoint], reach_m: f64) -> Self {
        let half = (reach_m.min(100.0) / SQUARE_M) as i32 + 2;
        let side = (2 * half + 1) as usize;
        let mut squares = Self { is_wall: vec![false; side * side], half };
        for point in outline {
            let [x, y] = square_of(&point.position_m);
            for (dx, dy) in (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| (dx, dy))) {
                if let Some(at) = squares.index([x + dx, y + dy]) {
                    squares.is_wall[at] = true;
                }
            }
        }
        squares
    }

    /// How many line points lie in or beside a square with a wall.
    fn hits(&self, points: &[LinePoint], pose: &Isometry2<f64>) -> usize {
        let is_hit =
            |point: &&LinePoint| self.index(square_of(&(pose * point.position_m))).is_some_and(|at| self.is_wall[at]);
        points.iter().filter(is_hit).count()
    }

    fn index(&self, [x, y]: [i32; 2]) -> Option<usize> {
        let is_inside = x.abs() <= self.half && y.abs() <= self.half;
        is_inside.then(|| ((y + self.half) * (2 * self.half + 1) + x + self.half) as usize)
    }
}

fn sector_of(position_m: &Point2<f64>) -> usize {
    let turns = position_m.y.atan2(position_m.x) / TAU + 0.5;
    ((turns * SECTORS as f64) as usize).min(SECTORS - 1)
}

fn square_of(position_m: &Point2<f64>) -> [i32; 2] {
    [position_m.x, position_m.y].map(|along_m| ((along_m / SQUARE_M).floor() as i32).clamp(-1_000_000, 1_000_000))
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Unit;

    /// Line points every 0.1 m from one place to another.
    fn wall(from_m: [f64; 2], to_m: [f64; 2]) -> Vec<LinePoint> {
        let (from_m, to_m) = (Point2::from(from_m), Point2::from(to_m));
        let along = (to_m - from_m).normalize();
        let steps = (10.0 * (to_m - from_m).norm()) as u32;
        let point = |step: u32| from_m + 0.1 * f64::from(step) * along;
        (0..=steps)
            .map(|step| LinePoint {
                position_m: point(step),
                normal: Unit::new_normalize(Vector2::new(-along.y, along.x)),
                tilt_rad2: 0.0,
            })
            .collect()
    }

    /// A room around the anchor, open towards +x.
    fn room() -> Vec<LinePoint> {
        let sides = [([8.0, 4.0], [-4.0, 4.0]), ([-4.0, 4.0], [-4.0, -4.0]), ([-4.0, -4.0], [8.0, -4.0])];
        sides.into_iter().flat_map(|(from_m, to_m)| wall(from_m, to_m)).collect()
    }

    fn share_with(more: Vec<LinePoint>) -> f64 {
        Walls::new(&room())
            .fit(&Walls::new(&[room(), more].concat()), &Isometry2::identity())
            .expect("both have walls")
            .share
    }

    #[test]
    fn a_wall_behind_the_walls_of_a_shorter_visit_says_nothing() {
        assert!(share_with(wall([-6.0, 5.0], [2.0, 5.0])) > 0.95);
    }

    #[test]
    fn a_wall_where_the_other_visit_looked_through_speaks_against_it() {
        assert!(share_with(wall([1.5, 2.0], [1.5, -2.0])) < 0.95);
    }
}
