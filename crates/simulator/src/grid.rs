//! A grid over the segments of a surface. It limits the search of a ray to the segments near it.

use crate::network::{Point, Vector};
use crate::segment::Segment;

/// Side of a cell, metres. A cell has a few segments, and a ray crosses a few dozen cells.
const CELL_M: f64 = 0.5;

/// The segments near each cell.
#[derive(Clone, Debug)]
pub(crate) struct Grid {
    origin_m: Point,
    columns: usize,
    rows: usize,
    /// The segments near cell c are `members[start[c]..start[c + 1]]`.
    start: Vec<u32>,
    members: Vec<u32>,
}

impl Grid {
    pub(crate) fn new(segments: &[Segment]) -> Self {
        let ends = || segments.iter().flat_map(|segment| [segment.from_m, segment.to_m]);
        let low = ends().fold(Point::new(f64::MAX, f64::MAX), |low, end| low.inf(&end));
        let high = ends().fold(Point::new(f64::MIN, f64::MIN), |high, end| high.sup(&end));
        if segments.is_empty() {
            return Self { origin_m: Point::origin(), columns: 0, rows: 0, start: vec![0], members: Vec::new() };
        }
        let columns = ((high.x - low.x) / CELL_M) as usize + 1;
        let rows = ((high.y - low.y) / CELL_M) as usize + 1;
        let mut grid = Self { origin_m: low, columns, rows, start: vec![0; columns * rows + 1], members: Vec::new() };
        // Counting sort: count the members of each cell, sum the counts to starts, then place the members.
        for segment in segments {
            grid.cells_under(segment).for_each(|cell| grid.start[cell + 1] += 1);
        }
        for cell in 0..columns * rows {
            grid.start[cell + 1] += grid.start[cell];
        }
        let mut next = grid.start.clone();
        grid.members = vec![0; grid.start[columns * rows] as usize];
        for (index, segment) in segments.iter().enumerate() {
            for cell in grid.cells_under(segment) {
                grid.members[next[cell] as usize] = index as u32;
                next[cell] += 1;
            }
        }
        grid
    }

    /// Calls `visit(members, leave_m)` for each cell along a ray until it returns `false`. The ray leaves the cell at
    /// `leave_m`. A ray from outside starts where it enters the grid.
    pub(crate) fn walk(
        &self,
        from_m: Point,
        direction: Vector,
        limit_m: f64,
        mut visit: impl FnMut(&[u32], f64) -> bool,
    ) {
        let Some(enter_m) = self.enters_at(from_m, direction, limit_m) else { return };
        let at = (from_m + direction * enter_m - self.origin_m) / CELL_M;
        let mut column = (at.x.max(0.0) as usize).min(self.columns - 1) as isize;
        let mut row = (at.y.max(0.0) as usize).min(self.rows - 1) as isize;
        let offset = (from_m - self.origin_m) / CELL_M;
        // Distance along the ray to the next line of the grid, and between lines, in x and in y.
        let lines = |offset: f64, cell: isize, slope: f64| {
            let line = cell + isize::from(slope > 0.0);
            if slope == 0.0 {
                (f64::INFINITY, 0.0)
            } else {
                ((line as f64 - offset) * CELL_M / slope, CELL_M / slope.abs())
            }
        };
        let (mut next_x_m, step_x_m) = lines(offset.x, column, direction.x);
        let (mut next_y_m, step_y_m) = lines(offset.y, row, direction.y);
        loop {
            let cell = row as usize * self.columns + column as usize;
            let leave_m = next_x_m.min(next_y_m);
            let members = &self.members[self.start[cell] as usize..self.start[cell + 1] as usize];
            if !visit(members, leave_m) || leave_m > limit_m {
                return;
            }
            if next_x_m < next_y_m {
                column += if direction.x > 0.0 { 1 } else { -1 };
                next_x_m += step_x_m;
            } else {
                row += if direction.y > 0.0 { 1 } else { -1 };
                next_y_m += step_y_m;
            }
            if column < 0 || row < 0 || column >= self.columns as isize || row >= self.rows as isize {
                return;
            }
        }
    }

    /// The segments of all cells within `reach_m` of a place, along each axis. A segment may come several times.
    pub(crate) fn near(&self, place_m: Point, reach_m: f64) -> impl Iterator<Item = u32> + '_ {
        let offset_m = place_m - self.origin_m;
        let cells = move |at_m: f64, cells: usize| {
            let cell = |at_m: f64| ((at_m / CELL_M).max(0.0) as usize).min(cells.saturating_sub(1));
            if cells == 0 { 0..0 } else { cell(at_m - reach_m)..cell(at_m + reach_m) + 1 }
        };
        let (columns, rows) = (cells(offset_m.x, self.columns), cells(offset_m.y, self.rows));
        let touched = rows.flat_map(move |row| columns.clone().map(move |column| row * self.columns + column));
        touched.flat_map(|cell| &self.members[self.start[cell] as usize..self.start[cell + 1] as usize]).copied()
    }

    /// The cells that the bounding box of a segment touches.
    fn cells_under(&self, segment: &Segment) -> impl Iterator<Item = usize> + use<> {
        let cell = |point: Point| {
            let at = (point - self.origin_m) / CELL_M;
            (at.x as usize, at.y as usize)
        };
        let (low, high) = (cell(segment.from_m.inf(&segment.to_m)), cell(segment.from_m.sup(&segment.to_m)));
        let columns = self.columns;
        (low.1..=high.1).flat_map(move |row| (low.0..=high.0).map(move |column| row * columns + column))
    }

    /// Distance at which a ray enters the grid: 0 from inside, `None` if it misses the grid.
    fn enters_at(&self, from_m: Point, direction: Vector, limit_m: f64) -> Option<f64> {
        let size = Vector::new(self.columns as f64, self.rows as f64) * CELL_M;
        let (mut enter_m, mut leave_m) = (0.0_f64, limit_m);
        for axis in 0..2 {
            let (low, slope) = (self.origin_m[axis] - from_m[axis], direction[axis]);
            if slope == 0.0 {
                if low > 0.0 || low + size[axis] < 0.0 {
                    return None;
                }
                continue;
            }
            let (a, b) = (low / slope, (low + size[axis]) / slope);
            enter_m = enter_m.max(a.min(b));
            leave_m = leave_m.min(a.max(b));
        }
        (enter_m <= leave_m && !self.members.is_empty()).then_some(enter_m)
    }
}
