//! Where a scan may lie that lies farther from where it is expected than the kernel of the match is wide: starts for the match.
//!
//! [`Search::around`] counts, at each of a grid of poses, the line points that have one of the walls beside them that faces
//! their way. [`along`] shifts a scan along one direction, by the line points alone that show how far: along a smooth tunnel
//! the others fit everywhere, and noise makes them fit best where the beams meet the walls where they did before.

use nalgebra::{Isometry2, Point2, Unit, Vector2};

use crate::line_points::LinePoint;
use crate::local_map::LocalMap;

/// Side of a cell of the grid of [`Search`], metres.
const CELL_M: f64 = 0.25;

/// The grid has this many cells along each axis; the walls farther off count for nothing.
const CELLS: i32 = 256;

/// Poses on the grid: up to this far to each side, in steps, cells; and up to this far to each side in yaw, in steps.
const SIDE: i32 = 6;
const SIDE_STEP: i32 = 2;
const TURNS: i32 = 14;
const TURN_RAD: f64 = 0.06;

/// At most this many line points are counted at each pose.
const COUNTED: usize = 48;

/// Directions of walls are told apart by sectors of the full turn.
const SECTORS: usize = 16;

/// A pose as far off as the grid reaches, to the side or in yaw, counts for less by this share of all line points.
const FARTHEST: f64 = 0.1;

/// This many starts are given, at least so far apart in cells or in steps of yaw.
pub(crate) const STARTS: usize = 3;
const APART: i32 = 3;

/// A line point shows how far a scan lies along a direction if the sine of its wall to it is above this, and above this many
/// standard deviations of the direction of its normal.
const SHOWS: f64 = 0.25;
const SHOWS_DEVIATIONS: f64 = 3.0;

/// Shifts are this far apart, metres.
const SHIFT_M: f64 = 0.1;

/// At most this many line points are asked at each shift.
const ASKED: usize = 60;

/// Shifts nearer to each other than this are the same answer, metres.
pub(crate) const SAME_M: f64 = 0.3;

/// Steps to the minimum nearest to the best shift.
const STEPS: usize = 5;

/// The walls around a pose, as a grid of the directions that they face.
#[derive(Clone, Debug, Default)]
pub(crate) struct Search {
    /// Of each cell a bit for each sector.
    faces: Vec<u16>,
    counted: Vec<(LinePoint, u32)>,
    turned: Vec<(i32, u16, u32)>,
    scores: Vec<(f64, [i32; 3])>,
}

/// A shift along a direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Shift {
    pub(crate) by_m: f64,
    /// Of the shift, m².
    pub(crate) variance_m2: f64,
    /// What the next best shift is worse by, in squares of standard deviations.
    pub(crate) lead: f64,
}

fn sector(normal: &Unit<Vector2<f64>>) -> usize {
    let turns = normal.y.atan2(normal.x) / std::f64::consts::TAU;
    (turns * SECTORS as f64).rem_euclid(SECTORS as f64) as usize % SECTORS
}

impl Search {
    /// Poses around an expected one at which most line points have walls beside them, the best first.
    pub(crate) fn around(
        &mut self,
        points: &[LinePoint],
        walls: &LocalMap,
        expected: &Isometry2<f64>,
    ) -> Vec<Isometry2<f64>> {
        let corner_m = expected.translation.vector - Vector2::repeat(0.5 * f64::from(CELLS) * CELL_M);
        let cell = |at_m: &Point2<f64>| {
            let at = (at_m - corner_m).coords / CELL_M;
            let margin = f64::from(SIDE + 2)..f64::from(CELLS - SIDE - 2);
            (margin.contains(&at.x) && margin.contains(&at.y)).then(|| at.y as i32 * CELLS + at.x as i32)
        };
        self.draw(walls, cell);
        self.choose(points);
        self.scores.clear();
        let all = self.counted.iter().map(|(_, weight)| f64::from(*weight)).sum::<f64>();
        for turn in -TURNS..=TURNS {
            let pose =
                Isometry2::new(expected.translation.vector, expected.rotation.angle() + f64::from(turn) * TURN_RAD);
            self.turned.clear();
            self.turned.extend(self.counted.iter().filter_map(|(point, weight)| {
                let point = point.at(&pose);
                Some((cell(&point.position_m)?, 1 << sector(&point.normal), *weight))
            }));
            for y in (-SIDE..=SIDE).step_by(SIDE_STEP as usize) {
                for x in (-SIDE..=SIDE).step_by(SIDE_STEP as usize) {
                    let score = self.score(x, y) - self.far(all, [x, y, turn]);
                    self.scores.push((score, [x, y, turn]));
                }
            }
        }
        self.scores.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let mut best: Vec<[i32; 3]> = Vec::with_capacity(STARTS);
        for (_, at) in &self.scores {
            let is_apart = |of: &[i32; 3]| (0..3).any(|axis| (of[axis] - at[axis]).abs() >= APART);
            if best.iter().all(is_apart) {
                best.push(*at);
            }
            if best.len() == STARTS {
                break;
            }
        }
        let pose = |[x, y, turn]: [i32; 3]| {
            let off_m = Vector2::new(f64::from(x), f64::from(y)) * CELL_M;
            Isometry2::new(expected.translation.vector + off_m, expected.rotation.angle() + f64::from(turn) * TURN_RAD)
        };
        best.into_iter().map(pose).collect()
    }

    fn score(&self, x: i32, y: i32) -> f64 {
        let shift = y * CELLS + x;
        let count = |(cell, face, weight): &(i32, u16, u32)| match self.faces[(cell + shift) as usize] & face {
            0 => 0,
            _ => *weight,
        };
        f64::from(self.turned.iter().map(count).sum::<u32>())
    }

    fn far(&self, all: f64, at: [i32; 3]) -> f64 {
        let [x, y, turn] = at.map(f64::from);
        let (side, turns) = (f64::from(SIDE), f64::from(TURNS));
        FARTHEST * all * ((x * x + y * y) / (side * side) + turn * turn / (turns * turns))
    }

    fn draw(&mut self, walls: &LocalMap, cell: impl Fn(&Point2<f64>) -> Option<i32>) {
        self.faces.clear();
        self.faces.resize((CELLS * CELLS) as usize, 0);
        for wall in walls.points() {
            let Some(at) = cell(&wall.position_m) else { continue };
            let face = sector(&wall.normal);
            let faces = [SECTORS - 1, 0, 1].iter().fold(0, |bits, by| bits | 1 << ((face + by) % SECTORS));
            for [x, y] in [-1, 0, 1].into_iter().flat_map(|y| [-1, 0, 1].map(|x| [x, y])) {
                self.faces[(at + y * CELLS + x) as usize] |= faces;
            }
        }
    }

    /// Chooses line points evenly; those of a direction that few have weigh more.
    fn choose(&mut self, points: &[LinePoint]) {
        let mut counts = [0u32; SECTORS];
        self.counted.clear();
        let every = points.len().div_ceil(COUNTED).max(1);
        self.counted.extend(points.iter().step_by(every).map(|point| (*point, 0)));
        for (point, _) in &self.counted {
            counts[sector(&point.normal)] += 1;
        }
        for (point, weight) in &mut self.counted {
            *weight = (256.0 / f64::from(counts[sector(&point.normal)]).sqrt()) as u32;
        }
    }
}

/// Whether a line point shows how far a scan lies along a direction.
pub(crate) fn shows(point: &LinePoint, along: &Unit<Vector2<f64>>) -> bool {
    let sine = point.normal.dot(along);
    sine * sine > (SHOWS * SHOWS).max(SHOWS_DEVIATIONS * SHOWS_DEVIATIONS * point.tilt_rad2)
}

/// The shift along a direction, of at most `reach_m` to either side, by which line points lie best on walls: those of `shown`
/// that [`shows`] names, in the axes of the map. A shift by s costs (s - expected)² / variance, at most `most`, where it is
/// `expected`. `None` where no line point shows it.
pub(crate) fn along(
    shown: &[LinePoint],
    along: &Unit<Vector2<f64>>,
    reach_m: f64,
    walls: [&LocalMap; 2],
    cost: impl Fn(f64) -> f64,
    kernel: Kernel,
) -> Option<Shift> {
    let every = shown.len().div_ceil(ASKED).max(1);
    let at = |shift_m: f64| {
        let mut sum = (cost(shift_m), 0.0, 0.0);
        for point in shown.iter().step_by(every) {
            let shifted = LinePoint { position_m: point.position_m + along.into_inner() * shift_m, ..*point };
            let of = walls.map(|walls| kernel.at(&shifted, walls, along));
            let best = if of[1].0 < of[0].0 { of[1] } else { of[0] };
            sum = (sum.0 + best.0, sum.1 + best.1, sum.2 + best.2);
        }
        sum
    };
    if shown.is_empty() {
        return None;
    }
    let shifts = (reach_m / SHIFT_M).ceil() as i32;
    let costs: Vec<f64> = (-shifts..=shifts).map(|shift| at(f64::from(shift) * SHIFT_M).0).collect();
    let least = (0..costs.len()).min_by(|a, b| costs[*a].total_cmp(&costs[*b]))?;
    let shift_m = |at: usize| f64::from(at as i32 - shifts) * SHIFT_M;
    let mut by_m = shift_m(least);
    for _ in 0..STEPS {
        let (_, gradient, information) = at(by_m);
        if information > 0.0 {
            by_m = (by_m - gradient / information).clamp(shift_m(least) - SAME_M, shift_m(least) + SAME_M);
        }
    }
    let (cost, _, information) = at(by_m);
    let others = (0..costs.len()).filter(|of| (shift_m(*of) - by_m).abs() > SAME_M).map(|of| costs[of]);
    let lead = others.fold(f64::INFINITY, f64::min) - cost;
    (information > 0.0).then(|| Shift { by_m, variance_m2: 1.0 / information, lead })
}

/// What a distance of a line point from a wall costs: the kernel of Geman and McClure, in squares of standard deviations.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Kernel {
    pub(crate) width_m: f64,
    pub(crate) deviation_m: f64,
    /// This many line points count as one.
    pub(crate) alike: f64,
}

impl Kernel {
    /// Cost, gradient and curvature by a shift of a line point along a direction.
    fn at(&self, point: &LinePoint, walls: &LocalMap, along: &Unit<Vector2<f64>>) -> (f64, f64, f64) {
        let width_m2 = self.width_m * self.width_m;
        let weight = 1.0 / (self.deviation_m * self.deviation_m * self.alike);
        let Some(wall) = walls.nearest(point) else { return (width_m2 * weight, 0.0, 0.0) };
        let off_m = wall.normal.dot(&(point.position_m - wall.position_m));
        let by_shift = wall.normal.dot(along);
        let kernel = width_m2 / (width_m2 + off_m * off_m);
        let weighted = kernel * kernel * weight * by_shift;
        (kernel * off_m * off_m * weight, weighted * off_m, weighted * by_shift)
    }
}
