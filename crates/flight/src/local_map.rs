//! The walls around the vehicle, as line points in square cells.

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

    /// The nearest line point within a cell's side whose normal points the same way.
    pub(crate) fn nearest(&self, point: &LinePoint) -> Option<&LinePoint> {
        let [x, y] = cell_of(&point.position_m);
        let (in_x_m, in_y_m) = (point.position_m.x - f64::from(x) * CELL_M, point.position_m.y - f64::from(y) * CELL_M);
        let (mut nearest, mut least_m2) = (None, CELL_M * CELL_M);
        // The point's own cell is first: what is found there rules out most of the others.
        for [dx, dy] in AROUND {
            let (beside_x_m, beside_y_m) = (beside_m(dx, in_x_m), beside_m(dy, in_y_m));
            if beside_x_m * beside_x_m + beside_y_m * beside_y_m > least_m2 {
                continue;
            }
            for other in self.cells.get(&[x + dx, y + dy]).into_iter().flatten() {
                let apart_m2 = (other.position_m - point.position_m).norm_squared();
                if apart_m2 < least_m2 && other.normal.dot(&point.normal) > 0.7 {
                    (nearest, least_m2) = (Some(other), apart_m2);
                }
            }
        }
        nearest
    }
}

/// A cell and its neighbours, those that share a side first.
const AROUND: [[i32; 2]; 9] = [[0, 0], [-1, 0], [1, 0], [0, -1], [0, 1], [-1, -1], [-1, 1], [1, -1], [1, 1]];

/// How far the cells on one side, -1 or 1, are from a point that lies so far within its own cell; 0 for its own.
fn beside_m(side: i32, within_m: f64) -> f64 {
    match side {
        0 => 0.0,
        1 => CELL_M - within_m,
        _ => within_m,
    }
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
    // `as` saturates: a position beyond 5·10^8 m shares the last cell.
    [position_m.x, position_m.y].map(|value_m| ((value_m / CELL_M).floor() as i32).clamp(i32::MIN / 2, i32::MAX / 2))
}

#[cfg(test)]
mod tests {
    use nalgebra::{Unit, Vector2};

    use super::*;

    fn facing(x: f64, y: f64, normal: [f64; 2]) -> LinePoint {
        LinePoint { position_m: Point2::new(x, y), normal: Unit::new_normalize(Vector2::from(normal)), tilt_rad2: 0.0 }
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
    fn no_line_point_is_nearer_than_the_one_that_is_found() {
        let mut map = LocalMap::default();
        let spread = |i: u32, step: f64| (f64::from(i) * step).sin() * 4.0;
        let point = |i: u32| facing(spread(i, 1.7), spread(i, 2.9) - 7.0, [spread(i, 0.3), spread(i, 0.7) + 0.1]);
        (0..900).map(point).for_each(|point| map.insert(point));
        let all: Vec<LinePoint> = map.cells.values().flatten().copied().collect();
        let mut found = 0;
        for asked in (1000..3000).map(|i| LinePoint { position_m: point(i).position_m * 1.3, ..point(i) }) {
            let apart_m = |other: &&LinePoint| (other.position_m - asked.position_m).norm();
            let alike = all.iter().filter(|other| other.normal.dot(&asked.normal) > 0.7 && apart_m(other) < CELL_M);
            let nearest = alike.min_by(|a, b| apart_m(a).total_cmp(&apart_m(b)));
            assert_eq!(map.nearest(&asked), nearest, "{asked:?}");
            found += usize::from(nearest.is_some());
        }
        assert!((500..1900).contains(&found), "{found}: some are found, others are too far");
    }
}
