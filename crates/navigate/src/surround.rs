//! What is free around the vehicle: a grid that moves with it, of the returns of the last scans.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};

use nalgebra::{Isometry2, Point2};

use crosscut_stage::{Revolution, unit};

/// Side of a cell, m.
const CELL_M: f64 = 0.2;

/// Cells along a side: the grid reaches 6 m in each direction.
const CELLS: i32 = 60;

/// How much a return in a cell counts, and a beam that passes it: dust in a place that was seen to be free is no rock.
const HIT: i16 = 6;
const PASS: i16 = -1;

/// Bounds of the sum, so that a cell changes within a few scans.
const FREEST: i16 = -14;
const FULLEST: i16 = 30;

/// From this sum on a cell is rock.
const ROCK: i16 = 5;

/// A beam shows nothing of the last piece before its return, m: a cell of a wall is met at a grazing angle.
const BEFORE_RETURN_M: f64 = 0.25;

/// Cells that were never seen are entered at this many times the cost.
const UNSEEN_COST: f64 = 8.0;

/// A place is free if the vehicle's disc has this much room beside it, m.
const ROOM_M: f64 = 0.04;

/// The vehicle may stand too near to a wall: it leaves from there over cells within this distance, m.
const ESCAPE_M: f64 = 0.6;

/// Nothing is looked for beyond this, m: the edge of the grid is not far behind.
const FARTHEST_M: f64 = 5.5;

type CellIndex = [i32; 2];

/// The cells around the vehicle, in the axes of the tracked poses.
#[derive(Clone, Debug)]
pub(crate) struct Surround {
    radius_m: f64,
    centre: CellIndex,
    /// Of each cell modulo the side: which cell it is, and its sum.
    cells: Vec<(CellIndex, i16)>,
    /// The returns of the last scan.
    returns_m: Vec<Point2<f64>>,
}

impl Surround {
    /// For a vehicle of this radius.
    pub(crate) fn new(radius_m: f64) -> Self {
        Self {
            radius_m,
            centre: [0, 0],
            cells: vec![([i32::MAX; 2], 0); (CELLS * CELLS) as usize],
            returns_m: Vec::new(),
        }
    }

    /// Adds the returns of a scan taken at `pose`.
    pub(crate) fn add(&mut self, revolution: &Revolution, pose: &Isometry2<f64>) {
        let from_m = Point2::from(pose.translation.vector);
        self.centre = cell_of(from_m);
        let reach_m = 0.5 * f64::from(CELLS) * CELL_M;
        self.returns_m.clear();
        for point_m in &revolution.points_m {
            let end_m = pose * Point2::new(point_m.x, point_m.y);
            self.returns_m.push(end_m);
            let beam = end_m - from_m;
            let range_m = beam.norm();
            if range_m < 1e-6 {
                continue;
            }
            let direction = beam / range_m;
            let passed_m = (range_m - BEFORE_RETURN_M).min(reach_m);
            let (mut last, mut along_m) = ([i32::MAX; 2], 0.5 * CELL_M);
            while along_m < passed_m {
                let cell = cell_of(from_m + direction * along_m);
                if cell != last {
                    self.count(cell, PASS);
                    last = cell;
                }
                along_m += 0.7 * CELL_M;
            }
            self.count(cell_of(end_m), HIT);
        }
    }

    /// The ways over free cells from a place near the vehicle.
    pub(crate) fn field(&self, from_m: Point2<f64>) -> Field {
        let low = [self.centre[0] - CELLS / 2, self.centre[1] - CELLS / 2];
        let clearance_m = self.clearance_m(low);
        let mut field = Field {
            low,
            cost_m: vec![f64::INFINITY; clearance_m.len()],
            before: vec![u32::MAX; clearance_m.len()],
            clearance_m,
            start: from_m,
            rock_m: self.returns_m.iter().copied().filter(|return_m| self.is_rock(cell_of(*return_m))).collect(),
        };
        let Some(start) = field.index(cell_of(from_m)) else { return field };
        let mut heap = BinaryHeap::new();
        field.cost_m[start] = 0.0;
        heap.push(Reverse((0_u64, start)));
        while let Some(Reverse((cost, at))) = heap.pop() {
            if cost > quantised(field.cost_m[at]) {
                continue;
            }
            let cell = field.cell(at);
            for (step, length) in STEPS {
                let next = [cell[0] + step[0], cell[1] + step[1]];
                let Some(to) = field.index(next) else { continue };
                let Some(factor) = self.factor(next, field.clearance_m[to], from_m) else { continue };
                let cost_m = field.cost_m[at] + length * CELL_M * factor;
                if cost_m + 1e-9 < field.cost_m[to] {
                    (field.cost_m[to], field.before[to]) = (cost_m, at as u32);
                    heap.push(Reverse((quantised(cost_m), to)));
                }
            }
        }
        field
    }

    /// How much dearer a cell is than one with room all around; `None` if the vehicle does not fit.
    fn factor(&self, cell: CellIndex, clearance_m: f64, start_m: Point2<f64>) -> Option<f64> {
        let spare_m = clearance_m - self.radius_m - ROOM_M;
        let unseen = if self.sum(cell).is_some() { 1.0 } else { UNSEEN_COST };
        if spare_m >= 0.0 {
            let near = (1.2 - spare_m).max(0.0) / 1.2;
            return Some(unseen * (1.0 + 6.0 * near * near * near));
        }
        let is_escape = (middle_m(cell) - start_m).norm() < ESCAPE_M && clearance_m > 0.5 * CELL_M;
        is_escape.then_some(unseen * 40.0)
    }

    /// Distance of each cell from the nearest rock.
    fn clearance_m(&self, low: CellIndex) -> Vec<f64> {
        let all = (CELLS * CELLS) as usize;
        let mut nearest: Vec<(i32, CellIndex)> = vec![(i32::MAX, [0, 0]); all];
        let mut queue = VecDeque::new();
        for (at, slot) in nearest.iter_mut().enumerate() {
            let cell = [low[0] + at as i32 % CELLS, low[1] + at as i32 / CELLS];
            if self.is_rock(cell) {
                *slot = (0, cell);
                queue.push_back(at);
            }
        }
        while let Some(at) = queue.pop_front() {
            let (column, row) = (at as i32 % CELLS, at as i32 / CELLS);
            let rock = nearest[at].1;
            for (step, _) in STEPS {
                let (column, row) = (column + step[0], row + step[1]);
                if !(0..CELLS).contains(&column) || !(0..CELLS).contains(&row) {
                    continue;
                }
                let (x, y) = (low[0] + column - rock[0], low[1] + row - rock[1]);
                let (squared, to) = (x * x + y * y, (row * CELLS + column) as usize);
                if squared < nearest[to].0 {
                    nearest[to] = (squared, rock);
                    queue.push_back(to);
                }
            }
        }
        let distance_m = |squared: i32| if squared == i32::MAX { 99.0 } else { f64::from(squared).sqrt() * CELL_M };
        nearest.into_iter().map(|(squared, _)| distance_m(squared)).collect()
    }

    fn count(&mut self, cell: CellIndex, by: i16) {
        let slot = &mut self.cells[slot_of(cell)];
        let before = if slot.0 == cell { slot.1 } else { 0 };
        *slot = (cell, (before + by).clamp(FREEST, FULLEST));
    }

    fn is_rock(&self, cell: CellIndex) -> bool {
        self.sum(cell).is_some_and(|sum| sum >= ROCK)
    }

    /// The sum of a cell; `None` if it was never seen, or too long ago.
    fn sum(&self, cell: CellIndex) -> Option<i16> {
        let slot = self.cells[slot_of(cell)];
        (slot.0 == cell).then_some(slot.1)
    }
}

/// The eight neighbours of a cell, with their distances in cells.
const STEPS: [(CellIndex, f64); 8] = [
    ([1, 0], 1.0),
    ([0, 1], 1.0),
    ([-1, 0], 1.0),
    ([0, -1], 1.0),
    ([1, 1], std::f64::consts::SQRT_2),
    ([-1, 1], std::f64::consts::SQRT_2),
    ([-1, -1], std::f64::consts::SQRT_2),
    ([1, -1], std::f64::consts::SQRT_2),
];

fn quantised(cost_m: f64) -> u64 {
    (cost_m * 1e6) as u64
}

fn cell_of(place_m: Point2<f64>) -> CellIndex {
    [(place_m.x / CELL_M).floor() as i32, (place_m.y / CELL_M).floor() as i32]
}

fn middle_m(cell: CellIndex) -> Point2<f64> {
    Point2::new((f64::from(cell[0]) + 0.5) * CELL_M, (f64::from(cell[1]) + 0.5) * CELL_M)
}

fn slot_of(cell: CellIndex) -> usize {
    (cell[1].rem_euclid(CELLS) * CELLS + cell[0].rem_euclid(CELLS)) as usize
}

/// The ways over free cells from where the vehicle is.
#[derive(Clone, Debug)]
pub(crate) struct Field {
    low: CellIndex,
    /// Length of the way to each cell, made longer near walls; infinite if there is none.
    cost_m: Vec<f64>,
    before: Vec<u32>,
    clearance_m: Vec<f64>,
    start: Point2<f64>,
    /// Returns of the last scan that lie in cells of rock.
    rock_m: Vec<Point2<f64>>,
}

/// A place that can be reached.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reached {
    pub(crate) place_m: Point2<f64>,
    pub(crate) cost_m: f64,
    pub(crate) clearance_m: f64,
}

impl Field {
    /// The reachable place with the least score; `None` where no score is given.
    pub(crate) fn best(&self, score: impl Fn(&Reached) -> Option<f64>) -> Option<Reached> {
        let mut best: Option<(f64, Reached)> = None;
        for at in 0..self.cost_m.len() {
            if self.cost_m[at].is_finite() {
                let place_m = middle_m(self.cell(at));
                let reached = Reached { place_m, cost_m: self.cost_m[at], clearance_m: self.clearance_m[at] };
                if let Some(score) = score(&reached)
                    && best.as_ref().is_none_or(|(least, _)| score < *least)
                {
                    best = Some((score, reached));
                }
            }
        }
        best.map(|(_, reached)| reached)
    }

    /// The way to a place, from the start on.
    pub(crate) fn way_to(&self, place_m: Point2<f64>) -> Vec<Point2<f64>> {
        let mut way = Vec::new();
        let mut at = self.index(cell_of(place_m));
        while let Some(index) = at {
            way.push(middle_m(self.cell(index)));
            at = (self.before[index] != u32::MAX).then(|| self.before[index] as usize);
        }
        way.reverse();
        if let Some(first) = way.first_mut() {
            *first = self.start;
        }
        way
    }

    /// Distance from the nearest rock; 0 outside the grid.
    pub(crate) fn clearance_at_m(&self, place_m: Point2<f64>) -> f64 {
        self.index(cell_of(place_m)).map_or(0.0, |index| self.clearance_m[index])
    }

    /// The way over free cells to a place, made longer near walls; `None` if there is none within the grid.
    pub(crate) fn cost_at_m(&self, place_m: Point2<f64>) -> Option<f64> {
        self.index(cell_of(place_m)).map(|index| self.cost_m[index]).filter(|cost_m| cost_m.is_finite())
    }

    /// How far it is free in a direction, for a disc of a radius, up to the edge of the grid.
    pub(crate) fn free_m(&self, direction_rad: f64, radius_m: f64) -> f64 {
        let direction = unit(direction_rad);
        let mut along_m = 0.0;
        while along_m < FARTHEST_M && self.clearance_at_m(self.start + direction * along_m) >= radius_m {
            along_m += 0.5 * CELL_M;
        }
        along_m
    }

    /// How far a disc of a radius can move in a direction before it touches a return of rock. It is exact, where
    /// [`free_m`](Self::free_m) is off by up to a cell, and knows the last scan alone.
    pub(crate) fn ahead_m(&self, direction_rad: f64, radius_m: f64) -> f64 {
        let direction = unit(direction_rad);
        let touches_at_m = |rock_m: &Point2<f64>| {
            let from = rock_m - self.start;
            let (along_m, beside_m) = (from.dot(&direction), from.perp(&direction));
            let is_in_the_way = along_m > 0.0 && beside_m.abs() < radius_m;
            is_in_the_way.then(|| along_m - (radius_m * radius_m - beside_m * beside_m).sqrt())
        };
        self.rock_m.iter().filter_map(touches_at_m).fold(FARTHEST_M, f64::min).max(0.0)
    }

    fn index(&self, cell: CellIndex) -> Option<usize> {
        let (column, row) = (cell[0] - self.low[0], cell[1] - self.low[1]);
        let is_inside = (0..CELLS).contains(&column) && (0..CELLS).contains(&row);
        is_inside.then_some((row * CELLS + column) as usize)
    }

    fn cell(&self, index: usize) -> CellIndex {
        [self.low[0] + index as i32 % CELLS, self.low[1] + index as i32 / CELLS]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crosscut_stage::Point;

    /// A tunnel along x, 3 m wide and 16 m long, seen from its middle.
    fn tunnel() -> Revolution {
        let sides =
            [-1.5, 1.5].into_iter().flat_map(|y| (-80..=80).map(move |i| Point::new(0.1 * f64::from(i), y, 0.0)));
        let faces =
            [-8.0, 8.0].into_iter().flat_map(|x| (-30..=30).map(move |i| Point::new(x, 0.05 * f64::from(i), 0.0)));
        Revolution { points_m: sides.chain(faces).collect(), ..Revolution::default() }
    }

    #[test]
    fn the_way_along_a_tunnel_keeps_to_its_middle() {
        let mut surround = Surround::new(0.3);
        (0..3).for_each(|_| surround.add(&tunnel(), &Isometry2::identity()));
        let field = surround.field(Point2::new(0.0, 0.5));
        let goal = field.best(|reached| Some((reached.place_m - Point2::new(5.0, 0.0)).norm())).expect("a goal");
        let way = field.way_to(goal.place_m);
        assert!((goal.place_m - Point2::new(5.0, 0.0)).norm() < 0.2);
        assert!(way.iter().skip(15).all(|place_m| place_m.y.abs() < 0.4), "{way:?}");
    }

    #[test]
    fn a_return_amid_free_space_is_no_rock_and_a_pillar_is() {
        let mut surround = Surround::new(0.3);
        (0..6).for_each(|_| surround.add(&tunnel(), &Isometry2::identity()));
        let mut dusty = tunnel();
        dusty.points_m.push(Point::new(2.0, 0.0, 0.0));
        surround.add(&dusty, &Isometry2::identity());
        assert!(surround.field(Point2::origin()).free_m(0.0, 0.3) > 4.5, "dust");
        for _ in 0..8 {
            dusty.points_m.extend((0..10).map(|i| Point::new(2.0, 0.05 * f64::from(i) - 0.25, 0.0)));
            surround.add(&dusty, &Isometry2::identity());
        }
        assert!(surround.field(Point2::origin()).free_m(0.0, 0.3) < 2.0, "a pillar");
    }

    #[test]
    fn how_far_the_disc_can_move_is_exact() {
        let mut surround = Surround::new(0.3);
        let mut blocked = tunnel();
        blocked.points_m.extend((-10..=10).map(|i| Point::new(2.03, 0.05 * f64::from(i), 0.0)));
        (0..6).for_each(|_| surround.add(&blocked, &Isometry2::identity()));
        blocked.points_m.push(Point::new(1.0, 0.0, 0.0));
        surround.add(&blocked, &Isometry2::identity());
        let ahead_m = surround.field(Point2::origin()).ahead_m(0.0, 0.3);
        assert!((ahead_m - 1.73).abs() < 1e-9, "{ahead_m} m: the wall, not the grain of dust before it");
        assert!(surround.field(Point2::origin()).ahead_m(std::f64::consts::PI, 0.3) > 5.0, "nothing is behind");
    }
}
