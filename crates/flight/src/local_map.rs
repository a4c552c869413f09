//! The walls around the vehicle, as line points in square cells.

use nalgebra::Point2;

use crate::line_points::LinePoint;

/// Side of a cell; line points farther apart than this are never matched.
pub(crate) const CELL_M: f64 = 0.5;

/// A cell takes no more line points than this.
const MAX_IN_CELL: usize = 16;

/// Line points nearer to one that is there than this add nothing.
const LEAST_APART_M: f64 = 0.08;

/// Line points face the same way if the cosine of the angle between their normals is more than this.
const ALIKE: f64 = 0.7;

/// Up to this angle that a line point turns, the cosine changes by less, rad.
pub(crate) const TURNED_RAD: f64 = 0.1;

/// What faces the same way by so much still does after such a turn; what does not by so much does not after two of them.
const SURELY_ALIKE: f64 = ALIKE + TURNED_RAD;
const PERHAPS_ALIKE: f64 = ALIKE - 2.0 * TURNED_RAD;

/// This many line points are kept as the nearest of a place.
const NEAREST: usize = 3;

/// Low 24 bits of the sort key: the index of the line point. The other bits are those of its squared distance, which is cut by
/// less than [`ROUNDING_M`].
const INDEX: u64 = (1 << 24) - 1;

/// The sort key of no line point.
const NOTHING: u64 = u64::MAX;

/// Distances are compared with this much to spare, for rounding.
pub(crate) const ROUNDING_M: f64 = 1e-9;

/// The table of cells repeats itself after this many cells along either axis; a power of two.
const TABLE: i32 = 64;

/// No cell.
const NONE: u32 = u32::MAX;

/// Line points seen within a few scans of each other.
#[derive(Clone, Debug, Default)]
pub(crate) struct LocalMap {
    /// For each place in the table, the first of the cells that have it. Empty until there is a cell.
    first: Vec<u32>,
    cells: Vec<Bucket>,
    /// [`MAX_IN_CELL`] for each cell, of which the first ones count.
    points: Vec<LinePoint>,
}

#[derive(Clone, Copy, Debug)]
struct Bucket {
    at: [i32; 2],
    /// How many line points it has.
    len: usize,
    /// The next cell that has the same place in the table.
    next: u32,
}

/// The line points nearest to a place that may face the same way, ascending by distance.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Near {
    /// As indices of the map's.
    points: [u32; NEAREST],
    len: usize,
    /// All others are no nearer to the place than this.
    pub(crate) others_m: f64,
}

/// The nearest line point within a cell's side that faces the same way.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NearestPoint<'a> {
    pub(crate) wall: Option<&'a LinePoint>,
    /// Its distance; a cell's side without it.
    pub(crate) apart_m: f64,
    /// While what it was looked up for moves by less than this and turns by less than [`TURNED_RAD`], it is the nearest of
    /// those that were asked.
    pub(crate) holds_m: f64,
}

impl LocalMap {
    pub(crate) fn is_empty(&self) -> bool {
        self.cells.is_empty()
    }

    pub(crate) fn clear(&mut self) {
        self.first.fill(NONE);
        self.cells.clear();
        self.points.clear();
    }

    /// All line points.
    pub(crate) fn points(&self) -> impl Iterator<Item = &LinePoint> {
        self.cells.iter().zip(self.points.chunks(MAX_IN_CELL)).flat_map(|(cell, points)| &points[..cell.len])
    }

    pub(crate) fn insert(&mut self, point: LinePoint) {
        let at = cell_of(&point.position_m);
        let cell = self.find(at).unwrap_or_else(|| self.add_cell(at, &point));
        let (first, len) = (cell * MAX_IN_CELL, self.cells[cell].len);
        let is_new = |other: &LinePoint| {
            let apart_m2 = (other.position_m - point.position_m).norm_squared();
            apart_m2 > LEAST_APART_M * LEAST_APART_M || other.normal.dot(&point.normal) < 0.5
        };
        if len < MAX_IN_CELL && self.points[first..first + len].iter().all(is_new) {
            self.points[first + len] = point;
            self.cells[cell].len += 1;
        }
    }

    /// Adds an empty cell, with room for line points.
    fn add_cell(&mut self, at: [i32; 2], filler: &LinePoint) -> usize {
        self.first.resize((TABLE * TABLE) as usize, NONE);
        let cell = self.cells.len();
        self.cells.push(Bucket { at, len: 0, next: NONE });
        self.points.resize(self.cells.len() * MAX_IN_CELL, *filler);
        self.link(cell);
        cell
    }

    fn link(&mut self, cell: usize) {
        let first = &mut self.first[place_of(self.cells[cell].at)];
        self.cells[cell].next = std::mem::replace(first, cell as u32);
    }

    fn find(&self, at: [i32; 2]) -> Option<usize> {
        let mut index = *self.first.get(place_of(at))?;
        while let Some(cell) = self.cells.get(index as usize) {
            if cell.at == at {
                return Some(index as usize);
            }
            index = cell.next;
        }
        None
    }

    /// Drops what lies farther than `radius_m` from `centre_m` along either axis.
    pub(crate) fn keep_around(&mut self, centre_m: &Point2<f64>, radius_m: f64) {
        let [x, y] = cell_of(centre_m);
        let radius = (radius_m / CELL_M).ceil() as i32;
        let is_far = |at: [i32; 2]| at[0].abs_diff(x).max(at[1].abs_diff(y)) > radius.unsigned_abs();
        if !self.cells.iter().any(|cell| is_far(cell.at)) {
            return;
        }
        let mut kept = 0;
        for cell in 0..self.cells.len() {
            if !is_far(self.cells[cell].at) {
                self.cells[kept] = self.cells[cell];
                self.points.copy_within(cell * MAX_IN_CELL..(cell + 1) * MAX_IN_CELL, kept * MAX_IN_CELL);
                kept += 1;
            }
        }
        self.cells.truncate(kept);
        self.points.truncate(kept * MAX_IN_CELL);
        self.first.fill(NONE);
        (0..kept).for_each(|cell| self.link(cell));
    }

    /// The nearest line point within a cell's side that faces the same way.
    pub(crate) fn nearest(&self, point: &LinePoint) -> Option<&LinePoint> {
        let (mut nearest, mut least_m2) = (None, CELL_M * CELL_M);
        self.cells_around(
            &point.position_m,
            &mut least_m2,
            |least_m2| *least_m2,
            |least_m2, first, points| {
                for (index, other) in (first..).zip(points) {
                    let off_m2 = (other.position_m - point.position_m).norm_squared();
                    if off_m2 < *least_m2 && other.normal.dot(&point.normal) > ALIKE {
                        (nearest, *least_m2) = (Some(index), off_m2);
                    }
                }
            },
        );
        nearest.map(|index| &self.points[index])
    }

    /// The line points around one, of those that may face the same way.
    pub(crate) fn near(&self, point: &LinePoint) -> Near {
        let place_m = &point.position_m;
        let seen_m = seen_m(in_cell_m(place_m, cell_of(place_m)));
        // Squared distances as whole numbers, of which the last bits are the index: what is sorted so needs no branches.
        let (mut kept, mut others) = ([NOTHING; NEAREST], (seen_m * seen_m).to_bits());
        self.cells_around(
            place_m,
            &mut others,
            |others| f64::from_bits(*others),
            |others, first, points| {
                for (index, other) in (first..).zip(points) {
                    let off_m2 = (other.position_m - place_m).norm_squared();
                    let may_be_alike = other.normal.dot(&point.normal) > PERHAPS_ALIKE;
                    let mut farther = if may_be_alike { off_m2.to_bits() & !INDEX | index as u64 } else { NOTHING };
                    for kept in &mut kept {
                        (*kept, farther) = (farther.min(*kept), farther.max(*kept));
                    }
                    *others = farther.min(*others);
                }
            },
        );
        let len = kept.iter().filter(|kept| **kept != NOTHING).count();
        let others_m = f64::from_bits(others & !INDEX).sqrt();
        Near { points: kept.map(|kept| (kept & INDEX) as u32), len, others_m }
    }

    /// Calls `see` with the line points, and the index of the first, of the cell of a place and of each beside it that is no
    /// farther than the root of `within_m2` of the bound, which `see` may lower.
    fn cells_around<B>(
        &self,
        place_m: &Point2<f64>,
        bound: &mut B,
        within_m2: impl Fn(&B) -> f64,
        mut see: impl FnMut(&mut B, usize, &[LinePoint]),
    ) {
        let [x, y] = cell_of(place_m);
        let [in_x_m, in_y_m] = in_cell_m(place_m, [x, y]);
        // The place's own cell is first: what is found there rules out most of the others.
        for [dx, dy] in AROUND {
            let (beside_x_m, beside_y_m) = (beside_m(dx, in_x_m), beside_m(dy, in_y_m));
            if beside_x_m * beside_x_m + beside_y_m * beside_y_m > within_m2(bound) {
                continue;
            }
            let Some(cell) = self.find([x + dx, y + dy]) else { continue };
            let first = cell * MAX_IN_CELL;
            see(bound, first, &self.points[first..first + self.cells[cell].len]);
        }
    }

    /// Of these, the nearest within a cell's side that faces the same way.
    pub(crate) fn nearest_of(&self, near: &Near, point: &LinePoint) -> NearestPoint<'_> {
        let (mut wall, mut alike, mut least_m2, mut next_m2) = (None, 1.0, CELL_M * CELL_M, f64::INFINITY);
        for other in near.points[..near.len].iter().map(|&index| &self.points[index as usize]) {
            let apart_m2 = (other.position_m - point.position_m).norm_squared();
            let cosine = other.normal.dot(&point.normal);
            if apart_m2 < least_m2 && cosine > ALIKE {
                next_m2 = if wall.is_some() { least_m2.min(next_m2) } else { next_m2 };
                (wall, alike, least_m2) = (Some(other), cosine, apart_m2);
            } else {
                next_m2 = apart_m2.min(next_m2);
            }
        }
        let apart_m = least_m2.sqrt();
        // Until another is as near, or the wall is too far.
        let next_m = 0.5 * (next_m2.sqrt() - apart_m);
        let holds_m = if wall.is_some() { next_m.min(CELL_M - apart_m) } else { next_m };
        let holds_m = if alike > SURELY_ALIKE { (holds_m - ROUNDING_M).max(0.0) } else { 0.0 };
        NearestPoint { wall, apart_m, holds_m }
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

/// The place of a cell in the table.
fn place_of([x, y]: [i32; 2]) -> usize {
    ((y & (TABLE - 1)) * TABLE + (x & (TABLE - 1))) as usize
}

fn cell_of(position_m: &Point2<f64>) -> [i32; 2] {
    [position_m.x, position_m.y].map(|value_m| {
        // `as` cuts off, and saturates: a position beyond 5·10^8 m shares the last cell.
        let (cells, cut) = (value_m / CELL_M, (value_m / CELL_M) as i32);
        cut.saturating_sub(i32::from(f64::from(cut) > cells)).clamp(i32::MIN / 2, i32::MAX / 2)
    })
}

/// How far within its cell a place lies along each axis.
fn in_cell_m(place_m: &Point2<f64>, [x, y]: [i32; 2]) -> [f64; 2] {
    [place_m.x - f64::from(x) * CELL_M, place_m.y - f64::from(y) * CELL_M]
}

/// All that lies within this distance of a place that lies so far within its cell is in that cell or in one beside it.
fn seen_m(in_cell_m: [f64; 2]) -> f64 {
    let [side_x_m, side_y_m] = in_cell_m.map(|within_m| within_m.min(CELL_M - within_m));
    // Beyond the last cell it is not known.
    (CELL_M + side_x_m.min(side_y_m)).max(0.0)
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
        let of_cell = |(at, cell): (usize, &Bucket)| &map.points[at * MAX_IN_CELL..][..cell.len];
        let all: Vec<LinePoint> = map.cells.iter().enumerate().flat_map(of_cell).copied().collect();
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
