//! What a vehicle with a limited view has seen around it: square cells of free space and of walls, in the frame of the
//! poses. Each cell is what most of the last scans in whose view it lay saw there, for as long as the doubt of the pose since
//! then is small beside a mouth.

use std::collections::VecDeque;

use crosscut_stage::{PoseDoubt, unit};
use nalgebra::{Isometry2, Point2, Vector2};

use crate::Tracked;

/// Side of a cell.
const CELL_M: f64 = 0.1;

/// Cells farther from the vehicle than this are forgotten, along each axis.
const RADIUS_M: f64 = 16.1;
const SIDE: usize = (2.0 * RADIUS_M / CELL_M) as usize;

/// The vehicle moves within the cells; once it is this far from their middle, they are laid around it again.
const OFF_MIDDLE_M: f64 = 1.5;

/// Up to this distance from the vehicle, what was seen is remembered.
pub(crate) const REACH_M: f64 = RADIUS_M - OFF_MIDDLE_M - CELL_M;

/// A scan adds to the cells once the vehicle has moved or turned this far since the last one that did.
const MOVED_M: f64 = 0.2;
const TURNED_RAD: f64 = 0.1;

/// A ray begins at this distance: nearer to the sensor than this is the vehicle.
const RAY_FROM_M: f64 = 0.15;

/// What a scan saw is forgotten once the pose since then is known less well than this (standard deviation).
const MOST_OFF_M: f64 = 0.25;

/// Neighbouring returns of one wall that lie farther apart than this have an edge between them.
const JOINED_M: f64 = 1.2;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum CellState {
    Never,
    Free,
    Wall,
}

/// A scan may see dust, or the edge of a wall too near: what most of the last scans saw in a cell counts, of this many.
const MOST_ODDS: i8 = 3;

/// A cell.
#[derive(Clone, Copy, Debug, Default)]
struct SeenCell {
    /// How many more of the last scans saw a wall here than free space; below 0 the other way round.
    odds: i8,
    /// The last scan that saw it, counted from 1; scan 0 is none.
    scan: u32,
}

/// One direction of a view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ray {
    pub(crate) bearing_rad: f64,
    /// Nothing stands nearer than this.
    pub(crate) free_m: f64,
    pub(crate) end: RayEnd,
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

/// The cells around the vehicle.
#[derive(Clone, Debug, Default)]
pub(crate) struct Surroundings {
    cells: Vec<SeenCell>,
    /// The cell of the corner with the least coordinates, in whole numbers.
    corner: Vector2<f64>,
    added_from: Option<Isometry2<f64>>,
    /// The doubt of the poses of the scans that are not forgotten.
    doubts: VecDeque<PoseDoubt>,
    /// How many scans were forgotten.
    forgotten: u32,
}

impl Surroundings {
    /// Forgets everything: the poses have a new beginning.
    pub(crate) fn clear(&mut self) {
        self.forgotten = self.forgotten.saturating_add(self.doubts.len() as u32);
        self.doubts.clear();
        self.added_from = None;
    }

    /// Adds a view from a pose, its rays by bearing; those of walls end at a wall.
    pub(crate) fn add(&mut self, Tracked { pose, doubt, .. }: &Tracked, rays: &[Ray]) {
        let place_m = Point2::from(pose.translation.vector);
        let is_certain = |before: &PoseDoubt| {
            let sd_m = doubt.since(before).and_then(|since| since.sd_m(place_m));
            sd_m.is_some_and(|sd_m| sd_m <= MOST_OFF_M)
        };
        while self.doubts.front().is_some_and(|before| !is_certain(before)) {
            self.doubts.pop_front();
            self.forgotten += 1;
        }
        if let Some(from) = self.added_from {
            let moved = from.inv_mul(pose);
            if moved.translation.vector.norm() < MOVED_M && moved.rotation.angle().abs() < TURNED_RAD {
                return;
            }
        }
        self.added_from = Some(*pose);
        self.doubts.push_back(*doubt);
        self.surround(pose);
        let scan = self.forgotten.saturating_add(self.doubts.len() as u32);
        let reach_m = |ray: &Ray| ray.free_m.min(REACH_M);
        // A wall that a scan sees is not free in it, although other beams pass through its cell.
        for pair in rays.windows(2) {
            let [from, to] = [&pair[0], &pair[1]].map(|ray| unit(ray.bearing_rad) * ray.free_m);
            let is_wall = |ray: &Ray| matches!(ray.end, RayEnd::Wall(_)) && ray.free_m <= reach_m(ray);
            if !is_wall(&pair[0]) || !is_wall(&pair[1]) {
                continue;
            }
            let parts = if are_joined(pair) { ((to - from).norm() / CELL_M).ceil().max(1.0) } else { 1.0 };
            for part in 0..=parts as usize {
                let wall = from + (to - from) * (part as f64 / parts);
                let place_m = (pose * Point2::from(wall)).coords;
                set(&mut self.cells, self.corner, [self.forgotten, scan], place_m, true);
            }
        }
        for pair in rays.windows(2) {
            let turned_rad = pair[1].bearing_rad - pair[0].bearing_rad;
            let (from_m, to_m) = (reach_m(&pair[0]), reach_m(&pair[1]));
            // Between neighbours that see one wall it runs from the one to the other, else the nearer one counts.
            let is_one_wall = are_joined(pair);
            let parts = (from_m.max(to_m) * turned_rad / CELL_M).ceil().max(1.0);
            for part in 0..parts as usize {
                let share = part as f64 / parts;
                let free_m = if is_one_wall { from_m + (to_m - from_m) * share } else { from_m.min(to_m) };
                let direction = pose.rotation * unit(pair[0].bearing_rad + turned_rad * share);
                let steps = (free_m / CELL_M).ceil() as usize;
                // Nearer to the sensor than half of the way every other part is enough, than a quarter every fourth.
                let first = if part == 0 { 0 } else { steps >> (part.trailing_zeros() + 1) };
                for step in first..steps {
                    let place_m = pose.translation.vector + direction * (step as f64 * CELL_M);
                    set(&mut self.cells, self.corner, [self.forgotten, scan], place_m, false);
                }
            }
        }
    }

    /// How far it is free from a pose in a direction of its frame, by the earlier scans, up to `farthest_m`.
    pub(crate) fn ray(&self, pose: &Isometry2<f64>, bearing_rad: f64, farthest_m: f64) -> Ray {
        let direction = pose.rotation * unit(bearing_rad);
        let mut free_m = RAY_FROM_M;
        while free_m < farthest_m {
            match self.at(pose.translation.vector + direction * free_m) {
                CellState::Free => free_m += 0.5 * CELL_M,
                CellState::Wall => return Ray { bearing_rad, free_m, end: RayEnd::WallBefore },
                CellState::Never => return Ray { bearing_rad, free_m, end: RayEnd::Unknown },
            }
        }
        Ray { bearing_rad, free_m: farthest_m, end: RayEnd::Range }
    }

    /// Lays the cells around a pose; what was seen where they lay before stays.
    fn surround(&mut self, pose: &Isometry2<f64>) {
        let corner = (pose.translation.vector / CELL_M).map(f64::floor) - Vector2::repeat((SIDE / 2) as f64);
        let off = corner - self.corner;
        if !self.cells.is_empty() && off.amax() <= OFF_MIDDLE_M / CELL_M {
            return;
        }
        if self.doubts.len() > 1 {
            let mut cells = vec![SeenCell::default(); SIDE * SIDE];
            for y in 0..SIDE {
                for x in 0..SIDE {
                    if let Some(at) = index(Vector2::new(x as f64, y as f64) + off) {
                        cells[y * SIDE + x] = self.cells[at];
                    }
                }
            }
            self.cells = cells;
        } else {
            // What is there was forgotten.
            self.cells.resize(SIDE * SIDE, SeenCell::default());
        }
        self.corner = corner;
    }

    fn at(&self, place_m: Vector2<f64>) -> CellState {
        let cell = index_of(self.corner, place_m).and_then(|at| self.cells.get(at)).copied().unwrap_or_default();
        match cell {
            SeenCell { scan, .. } if scan <= self.forgotten => CellState::Never,
            SeenCell { odds: 1.., .. } => CellState::Wall,
            SeenCell { .. } => CellState::Free,
        }
    }
}

/// Sets what a scan saw at a place; the first that it is said to have seen there counts. `scans`: the last that is forgotten, and
/// this one.
fn set(
    cells: &mut [SeenCell],
    corner: Vector2<f64>,
    [forgotten, scan]: [u32; 2],
    place_m: Vector2<f64>,
    is_wall: bool,
) {
    let cell = index_of(corner, place_m).and_then(|at| cells.get_mut(at));
    if let Some(cell) = cell.filter(|cell| cell.scan != scan) {
        let before = if cell.scan > forgotten { cell.odds } else { 0 };
        let odds = before + if is_wall { 1 } else { -1 };
        *cell = SeenCell { odds: odds.clamp(-MOST_ODDS, MOST_ODDS), scan };
    }
}

/// Whether two neighbouring rays end at one surface, without an edge between them.
fn are_joined(pair: &[Ray]) -> bool {
    let [from_m, to_m] = [&pair[0], &pair[1]].map(|ray| unit(ray.bearing_rad) * ray.free_m);
    pair[0].end == pair[1].end && (pair[0].end == RayEnd::Range || (to_m - from_m).norm() <= JOINED_M)
}

/// The index of the cell of a place.
fn index_of(corner: Vector2<f64>, place_m: Vector2<f64>) -> Option<usize> {
    index(place_m / CELL_M - corner)
}

/// The index of the cell of a place, in cells from the corner.
fn index(at: Vector2<f64>) -> Option<usize> {
    let is_inside = |along: f64| (0.0..SIDE as f64).contains(&along);
    (is_inside(at.x) && is_inside(at.y)).then(|| at.y as usize * SIDE + at.x as usize)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use crosscut_stage::MotionDoubt;

    use super::*;

    fn at(x_m: f64) -> Tracked {
        Tracked { pose: Isometry2::translation(x_m, 0.0), doubt: PoseDoubt::default(), lost: false }
    }

    /// A view straight ahead, 2 m from a wall across.
    fn ahead() -> Vec<Ray> {
        let ray = |degree: i32| {
            let bearing_rad = f64::from(degree).to_radians();
            Ray { bearing_rad, free_m: 2.0 / bearing_rad.cos(), end: RayEnd::Wall(0) }
        };
        (-60..=60).map(ray).collect()
    }

    #[test]
    fn what_was_ahead_is_known_once_it_lies_behind() {
        let mut surroundings = Surroundings::default();
        surroundings.add(&at(0.0), &ahead());
        let turned = Isometry2::new(Vector2::new(1.0, 0.0), PI);
        let back = surroundings.ray(&turned, PI, 10.0);
        assert!(back.end == RayEnd::WallBefore && (back.free_m - 1.0).abs() < 0.15, "{back:?}");
        let along = surroundings.ray(&turned, 0.0, 10.0);
        assert!(along.end == RayEnd::Unknown && along.free_m < 1.3, "nothing was seen behind the start: {along:?}");
        let short = surroundings.ray(&turned, PI, 0.5);
        assert_eq!((short.end, short.free_m), (RayEnd::Range, 0.5));
    }

    #[test]
    fn the_last_view_counts_and_far_cells_are_forgotten() {
        let mut surroundings = Surroundings::default();
        surroundings.add(&at(0.0), &ahead());
        let door: Vec<Ray> = ahead().into_iter().map(|ray| Ray { free_m: 6.0, end: RayEnd::Range, ..ray }).collect();
        surroundings.add(&at(0.3), &door);
        assert_eq!(surroundings.ray(&Isometry2::identity(), 0.0, 5.0).end, RayEnd::Range);
        surroundings.add(&at(100.0), &door);
        assert_eq!(surroundings.ray(&Isometry2::identity(), 0.0, 5.0).end, RayEnd::Unknown);
        assert_eq!(surroundings.ray(&Isometry2::translation(100.0, 0.0), 0.0, 5.0).end, RayEnd::Range);
    }

    #[test]
    fn what_was_seen_is_unknown_once_the_pose_since_then_is_in_doubt() {
        let mut surroundings = Surroundings::default();
        surroundings.add(&at(0.0), &ahead());
        let mut later = at(0.0);
        let seen = |surroundings: &Surroundings| surroundings.ray(&Isometry2::identity(), 0.0, 5.0).end;
        for (guessed_m, end) in [(0.2, RayEnd::WallBefore), (0.1, RayEnd::Unknown)] {
            let guessed = MotionDoubt { guessed_m, ..MotionDoubt::default() };
            later.doubt.add(&guessed, Point2::origin());
            // The vehicle stands: nothing is seen anew.
            surroundings.add(&later, &ahead());
            assert_eq!(seen(&surroundings), end);
        }
    }
}
