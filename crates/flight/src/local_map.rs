//! Walls as line points in square cells: those around the vehicle, which grow, and those of a place, which do not.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

use nalgebra::Point2;

use crate::line_points::LinePoint;

/// Side of a cell; line points farther apart than this are never matched.
pub(crate) const CELL_M: f64 = 0.5;

/// A cell takes no more line points than this.
const MAX_IN_CELL: usize = 16;

/// Line points nearer to one that is there than this add nothing.
const LEAST_APART_M: f64 = 0.08;

/// Line points seen within a few scans of each other.
#[derive(Clone, Debug, Default)]
pub(crate) struct LocalMap {
    /// Nothing depends on the order of the cells.
    cells: HashMap<[i32; 2], Vec<LinePoint>, BuildHasherDefault<CellHasher>>,
}

impl LocalMap {
    pub(crate) fn is_empty(&self) -> bool {
        self.cells.is_empty()
    }

    pub(crate) fn clear(&mut self) {
        self.cells.clear();
    }

    pub(crate) fn insert(&mut self, point: LinePoint) {
        let cell = self.cells.entry(cell_of(&point.position_m)).or_default();
        let is_new = |other: &LinePoint| {
            (other.position_m - point.position_m).norm() > LEAST_APART_M || other.normal.dot(&point.normal) < 0.5
        };
        if cell.len() < MAX_IN_CELL && cell.iter().all(is_new) {
            cell.push(point);
        }
    }

    /// Drops what lies farther than `radius_m` from `centre_m` along either axis.
    pub(crate) fn keep_around(&mut self, centre_m: &Point2<f64>, radius_m: f64) {
        let [x, y] = cell_of(centre_m);
        let radius = (radius_m / CELL_M).ceil() as i32;
        self.cells.retain(|cell, _| cell[0].abs_diff(x).max(cell[1].abs_diff(y)) <= radius.unsigned_abs());
    }

    /// The line points as they are now.
    pub(crate) fn fixed(&self) -> FixedMap {
        FixedMap::new(self)
    }
}

/// Where the nearest line point of a wall is looked up.
pub(crate) trait Nearest {
    /// The nearest line point within a cell's side whose normal points the same way.
    fn nearest(&self, point: &LinePoint) -> Option<&LinePoint>;
}

impl Nearest for LocalMap {
    fn nearest(&self, point: &LinePoint) -> Option<&LinePoint> {
        let [x, y] = cell_of(&point.position_m);
        let around = (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| [x + dx, y + dy]));
        nearest_of(around.filter_map(|cell| self.cells.get(&cell)).flatten(), point)
    }
}

/// Line points that no longer change, column by column: a look-up reads three short pieces of memory.
#[derive(Clone, Debug, Default)]
pub(crate) struct FixedMap {
    /// The least of the cells.
    low: [i32; 2],
    /// Cells of a column.
    rows: usize,
    /// Where the line points of each cell begin, and where the last ones end.
    begins: Vec<u32>,
    points: Vec<LinePoint>,
}

impl FixedMap {
    fn new(map: &LocalMap) -> Self {
        let along = |axis: usize| map.cells.keys().map(move |cell| cell[axis]);
        let bounds = |axis: usize| Some((along(axis).min()?, along(axis).max()?));
        let (Some((low_x, high_x)), Some((low_y, high_y))) = (bounds(0), bounds(1)) else { return Self::default() };
        let rows = (high_y - low_y) as usize + 1;
        let (mut begins, mut points) = (vec![0], Vec::new());
        for cell in (low_x..=high_x).flat_map(|x| (low_y..=high_y).map(move |y| [x, y])) {
            points.extend(map.cells.get(&cell).into_iter().flatten());
            begins.push(points.len() as u32);
        }
        Self { low: [low_x, low_y], rows, begins, points }
    }

    /// The line points of a column in the rows beside `row`.
    fn of_column(&self, column: i64, row: i64) -> &[LinePoint] {
        let columns = (self.begins.len() - 1) / self.rows.max(1);
        let Some(column) = usize::try_from(column).ok().filter(|column| *column < columns) else { return &[] };
        let within = |row: i64| row.clamp(0, self.rows as i64) as usize + column * self.rows;
        let [from, to] = [within(row - 1), within(row + 2)].map(|cell| self.begins[cell] as usize);
        &self.points[from..to]
    }
}

impl Nearest for FixedMap {
    fn nearest(&self, point: &LinePoint) -> Option<&LinePoint> {
        if self.points.is_empty() {
            return None;
        }
        let [x, y] = cell_of(&point.position_m).map(i64::from);
        let (column, row) = (x - i64::from(self.low[0]), y - i64::from(self.low[1]));
        nearest_of((-1..=1).flat_map(|dx| self.of_column(column + dx, row)), point)
    }
}

fn nearest_of<'a>(candidates: impl Iterator<Item = &'a LinePoint>, point: &LinePoint) -> Option<&'a LinePoint> {
    let faces_alike = |other: &&LinePoint| other.normal.dot(&point.normal) > 0.7;
    let by_distance =
        candidates.filter(faces_alike).map(|other| ((other.position_m - point.position_m).norm_squared(), other));
    let nearest = by_distance.min_by(|a, b| a.0.total_cmp(&b.0))?;
    (nearest.0 <= CELL_M * CELL_M).then_some(nearest.1)
}

/// Mixes the two numbers of a cell. Every scan looks up thousands of cells, and nobody chooses them to collide.
#[derive(Default)]
struct CellHasher(u64);

impl Hasher for CellHasher {
    fn finish(&self) -> u64 {
        self.0 ^ (self.0 >> 32)
    }

    fn write(&mut self, bytes: &[u8]) {
        for chunk in bytes.chunks(8) {
            let mut word = [0; 8];
            word[..chunk.len()].copy_from_slice(chunk);
            self.0 = (self.0.rotate_left(26) ^ u64::from_le_bytes(word)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        }
    }
}

fn cell_of(position_m: &Point2<f64>) -> [i32; 2] {
    // `as` saturates: a position beyond 10^9 m shares the last cell.
    [position_m.x, position_m.y].map(|value_m| ((value_m / CELL_M).floor() as i32).clamp(i32::MIN / 2, i32::MAX / 2))
}

#[cfg(test)]
mod tests {
    use nalgebra::{Unit, Vector2};

    use super::*;

    fn facing(x: f64, y: f64, normal: [f64; 2]) -> LinePoint {
        LinePoint { position_m: Point2::new(x, y), normal: Unit::new_normalize(Vector2::from(normal)) }
    }

    #[test]
    fn the_nearest_line_point_is_found_across_cells_and_on_the_same_side() {
        let mut map = LocalMap::default();
        let (front, back) = (facing(0.49, 0.0, [0.0, -1.0]), facing(0.55, 0.05, [0.0, 1.0]));
        map.insert(front);
        map.insert(back);
        assert_eq!(map.nearest(&facing(0.6, 0.05, [0.0, -1.0])), Some(&front));
        assert_eq!(map.nearest(&facing(0.6, 0.05, [0.0, 1.0])), Some(&back));
        assert_eq!(map.nearest(&facing(1.2, 0.0, [0.0, -1.0])), None, "too far");
    }

    #[test]
    fn what_lies_far_from_the_vehicle_is_dropped() {
        let mut map = LocalMap::default();
        map.insert(facing(0.0, 0.0, [0.0, 1.0]));
        map.insert(facing(30.0, 0.0, [0.0, 1.0]));
        map.keep_around(&Point2::new(30.0, 0.0), 20.0);
        assert_eq!(map.nearest(&facing(0.0, 0.0, [0.0, 1.0])), None);
        assert!(map.nearest(&facing(30.0, 0.1, [0.0, 1.0])).is_some());
    }

    #[test]
    fn a_fixed_map_finds_what_the_local_map_finds() {
        let mut map = LocalMap::default();
        let spread = |i: u32, step: f64| (f64::from(i) * step).sin() * 4.0;
        let point = |i: u32| facing(spread(i, 1.7), spread(i, 2.9) - 7.0, [spread(i, 0.3), spread(i, 0.7) + 0.1]);
        (0..900).map(point).for_each(|point| map.insert(point));
        let fixed = map.fixed();
        let asked = (1000..3000).map(|i| LinePoint { position_m: point(i).position_m * 1.3, ..point(i) });
        let found = asked.filter(|asked| {
            assert_eq!(fixed.nearest(asked), map.nearest(asked), "{asked:?}");
            map.nearest(asked).is_some()
        });
        assert!((500..1900).contains(&found.count()), "some are found, others are too far");
        assert_eq!(LocalMap::default().fixed().nearest(&point(0)), None, "an empty map");
    }
}
