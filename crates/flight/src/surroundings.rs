//! What a vehicle has seen around it: square cells of free space and of walls, in the frame of the
//! poses. Each cell is what most of the last scans in whose view it lay saw there, for as long as the doubt of the pose since
//! then is small beside a mouth.

use std::cmp::Ordering;
use std::collections::VecDeque;

use crosscut_stage::{PoseDoubt, unit};
use nalgebra::{Isometry2, Point2, Vector2};

use crate::Tracked;
use crate::rays::{Ray, RayEnd, Rays};

/// Side of a cell.
pub(crate) const CELL_M: f64 = 0.1;

/// Cells farther from the vehicle than this are forgotten, along each axis.
const RADIUS_M: f64 = 16.1;
pub(crate) const SIDE: usize = (2.0 * RADIUS_M / CELL_M) as usize;

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
pub(crate) enum CellState {
    Never,
    /// Beams passed through, and none of them came back: it is free, or rock beyond is dark and beams were lost on the way.
    Dark,
    Free,
    Wall,
}

/// A scan may see dust, or the edge of a wall too near: what most of the last scans saw in a cell counts, of this many.
const MOST_ODDS: u32 = 3;

/// A cell, in 32 bits, so that a row of cells is set at once: the last scan that saw it, counted from 1 (scan 0 is none), times 8, and how
/// many more of the last scans saw a wall here than free space, plus `MOST_ODDS`; as many of both also of beams that did not come back.
#[derive(Clone, Copy, Debug, Default)]
struct SeenCell(u32);

/// The cells around the vehicle.
#[derive(Clone, Debug, Default)]
pub(crate) struct Surroundings {
    cells: Vec<SeenCell>,
    /// The cell of the corner with the least coordinates, in whole numbers.
    corner: Vector2<f64>,
    added_from: Option<Isometry2<f64>>,
    /// Of the scans that are not forgotten: the doubt of the pose, and the stamp.
    scans: VecDeque<(PoseDoubt, u64)>,
    /// How many scans were forgotten.
    forgotten: u32,
    /// What a scan sees, as a polygon in the frame of the poses, metres; and where the middles of each row of cells cross it.
    outline: Vec<Point2<f64>>,
    crossings: Vec<Vec<f64>>,
}

impl Surroundings {
    /// Forgets everything: the poses have a new beginning.
    pub(crate) fn clear(&mut self) {
        self.forgotten = self.forgotten.saturating_add(self.scans.len() as u32);
        self.scans.clear();
        self.added_from = None;
    }

    /// Adds a view from a pose, its rays by bearing; those of walls end at a wall.
    pub(crate) fn add(&mut self, Tracked { pose, doubt, .. }: &Tracked, stamp_ns: u64, rays: &Rays) {
        let place_m = Point2::from(pose.translation.vector);
        let is_certain = |(before, _): &(PoseDoubt, u64)| {
            let sd_m = doubt.since(before).and_then(|since| since.sd_m(place_m));
            sd_m.is_some_and(|sd_m| sd_m <= MOST_OFF_M)
        };
        while self.scans.front().is_some_and(|before| !is_certain(before)) {
            self.scans.pop_front();
            self.forgotten += 1;
        }
        if let Some(from) = self.added_from {
            let moved = from.inv_mul(pose);
            if moved.translation.vector.norm() < MOVED_M && moved.rotation.angle().abs() < TURNED_RAD {
                return;
            }
        }
        self.added_from = Some(*pose);
        self.scans.push_back((*doubt, stamp_ns));
        self.surround(pose);
        let scan = self.forgotten.saturating_add(self.scans.len() as u32);
        let reach_m = |ray: &Ray| ray.free_m.min(REACH_M);
        // A wall that a scan sees is not free in it, although other beams pass through its cell.
        for (first, next) in rays.pairs() {
            let [from, to] = [first, next].map(Ray::end_m);
            let is_wall = |ray: &Ray| matches!(ray.end, RayEnd::Wall(_)) && ray.free_m <= reach_m(ray);
            if !is_wall(first) || !is_wall(next) {
                continue;
            }
            let parts = if are_joined(first, next) { ((to - from).norm() / CELL_M).ceil().max(1.0) } else { 1.0 };
            for part in 0..=parts as usize {
                let wall = from + (to - from) * (part as f64 / parts);
                let place_m = (pose * Point2::from(wall)).coords;
                let cell = index_of(self.corner, place_m).and_then(|at| self.cells.get_mut(at));
                cell.into_iter().for_each(|cell| cell.set([self.forgotten, scan], CellState::Wall));
            }
        }
        let any_dark = rays.rays.iter().any(|ray| ray.end == RayEnd::Range);
        for seen in [CellState::Free, CellState::Dark].into_iter().take(1 + usize::from(any_dark)) {
            self.outline.clear();
            for (first, next) in rays.pairs() {
                let is_dark = [first, next].iter().any(|ray| ray.end == RayEnd::Range);
                // Between neighbours that see one wall it runs from the one to the other, else the nearer one counts.
                let mut ends_m = [first, next].map(reach_m);
                if is_dark != (seen == CellState::Dark) {
                    ends_m = [0.0; 2];
                } else if !are_joined(first, next) {
                    ends_m = [ends_m[0].min(ends_m[1]); 2];
                }
                let ends = [first, next].into_iter().zip(ends_m);
                self.outline.extend(ends.map(|(ray, end_m)| pose * Point2::from(ray.towards * end_m)));
            }
            if !rays.full_turn {
                // The view begins and ends at the sensor.
                self.outline.push(place_m);
            }
            self.fill([self.forgotten, scan], seen);
        }
    }

    /// Sets the cells whose middles lie in the outline: in each row, those between its first and second crossing, and so on.
    fn fill(&mut self, scans: [u32; 2], seen: CellState) {
        self.crossings.resize(SIDE, Vec::new());
        self.crossings.iter_mut().for_each(Vec::clear);
        let at = |place_m: &Point2<f64>| place_m.coords / CELL_M - self.corner - Vector2::repeat(0.5);
        for (from, to) in self.outline.iter().zip(self.outline.iter().cycle().skip(1)) {
            let [from, to] = [at(from), at(to)];
            let (low, high) = if from.y <= to.y { (from, to) } else { (to, from) };
            let rows = low.y.ceil().max(0.0) as usize..high.y.ceil().clamp(0.0, SIDE as f64) as usize;
            for row in rows {
                let share = (row as f64 - low.y) / (high.y - low.y);
                self.crossings[row].push(low.x + share * (high.x - low.x));
            }
        }
        for (row, crossings) in self.crossings.iter_mut().enumerate() {
            crossings.sort_unstable_by(f64::total_cmp);
            for pair in crossings.chunks_exact(2) {
                let [first, end] = [pair[0], pair[1]].map(|x| x.ceil().clamp(0.0, SIDE as f64) as usize);
                self.cells[row * SIDE + first..row * SIDE + end.max(first)]
                    .iter_mut()
                    .for_each(|cell| cell.set(scans, seen));
            }
        }
    }

    /// How far it is free from a pose in a direction of its frame, by the earlier scans, up to `farthest_m`.
    pub(crate) fn ray(&self, pose: &Isometry2<f64>, bearing_rad: f64, farthest_m: f64) -> Ray {
        let direction = pose.rotation * unit(bearing_rad);
        let mut free_m = RAY_FROM_M;
        while free_m < farthest_m {
            match self.at(pose.translation.vector + direction * free_m) {
                CellState::Free | CellState::Dark => free_m += 0.5 * CELL_M,
                CellState::Wall => return Ray::new(bearing_rad, free_m, RayEnd::WallBefore),
                CellState::Never => return Ray::new(bearing_rad, free_m, RayEnd::Unknown),
            }
        }
        Ray::new(bearing_rad, farthest_m, RayEnd::Range)
    }

    /// Lays the cells around a pose; what was seen where they lay before stays.
    fn surround(&mut self, pose: &Isometry2<f64>) {
        let corner = (pose.translation.vector / CELL_M).map(f64::floor) - Vector2::repeat((SIDE / 2) as f64);
        let off = corner - self.corner;
        if !self.cells.is_empty() && off.amax() <= OFF_MIDDLE_M / CELL_M {
            return;
        }
        self.corner = corner;
        let side = SIDE as f64;
        if self.scans.len() == 1 || off.amax() >= side {
            self.cells.clear();
            self.cells.resize(SIDE * SIDE, SeenCell::default());
            return;
        }
        // Cells of rows and columns that come in are empty; those that go out lie there before they are emptied.
        let places = (off.y * side + off.x).rem_euclid(side * side);
        self.cells.rotate_left(places as usize);
        let come_in = |off: f64| if off > 0.0 { SIDE - off as usize..SIDE } else { 0..-off as usize };
        let (columns, rows) = (come_in(off.x), come_in(off.y));
        for (at, row) in self.cells.chunks_exact_mut(SIDE).enumerate() {
            let emptied = if rows.contains(&at) { 0..SIDE } else { columns.clone() };
            row[emptied].fill(SeenCell::default());
        }
    }

    fn at(&self, place_m: Vector2<f64>) -> CellState {
        self.state_of(index_of(self.corner, place_m).and_then(|at| self.cells.get(at)).copied().unwrap_or_default())
    }

    fn state_of(&self, cell: SeenCell) -> CellState {
        if cell.scan() <= self.forgotten {
            return CellState::Never;
        }
        match cell.odds().cmp(&MOST_ODDS) {
            Ordering::Greater => CellState::Wall,
            Ordering::Equal => CellState::Dark,
            Ordering::Less => CellState::Free,
        }
    }

    /// The corner of the cells with the least coordinates, metres.
    pub(crate) fn corner_m(&self) -> Vector2<f64> {
        self.corner * CELL_M
    }

    /// What a disc lies on whose middle is a corner of cells, in cells from the corner of all: a wall anywhere, else what
    /// was not seen free anywhere. Of a disc that is not all within the cells, `Never`.
    pub(crate) fn under(&self, disc: &Disc, [x, y]: [usize; 2]) -> CellState {
        let inside = disc.reach..=SIDE.saturating_sub(disc.reach);
        if self.cells.is_empty() || !inside.contains(&x) || !inside.contains(&y) {
            return CellState::Never;
        }
        // From the first cell of the square around the disc on.
        let cells = &self.cells[(y - disc.reach) * SIDE + x - disc.reach..];
        let mut under = CellState::Free;
        for at in &disc.cells {
            match self.state_of(cells[*at]) {
                CellState::Wall => return CellState::Wall,
                CellState::Free => {}
                CellState::Never | CellState::Dark => under = CellState::Never,
            }
        }
        under
    }

    /// The stamp of the last scan that saw a cell, counted from the corner along both axes.
    pub(crate) fn seen_ns(&self, x: usize, y: usize) -> Option<u64> {
        let cell = self.cells.get(y * SIDE + x).filter(|_| x < SIDE)?;
        let number = cell.scan().checked_sub(self.forgotten + 1)?;
        self.scans.get(number as usize).map(|(_, stamp_ns)| *stamp_ns)
    }
}

/// A disc around a corner of cells.
#[derive(Clone, Debug)]
pub(crate) struct Disc {
    /// The side of the square around it, in cells from its middle.
    reach: usize,
    /// Its cells, by their places from the first one of that square on, in rows as long as all cells'. Those at its rim come first, as
    /// walls stand there.
    cells: Vec<usize>,
}

impl Disc {
    pub(crate) fn new(radius_m: f64) -> Self {
        let reach = (radius_m / CELL_M).ceil() as usize;
        let off_m = |[x, y]: &[usize; 2]| {
            [x, y].map(|along| (*along as f64 + 0.5 - reach as f64) * CELL_M).into_iter().fold(0.0, f64::hypot)
        };
        let square = (0..2 * reach).flat_map(|y| (0..2 * reach).map(move |x| [x, y]));
        let mut cells: Vec<[usize; 2]> = square.filter(|cell| off_m(cell) <= radius_m).collect();
        cells.sort_by(|a, b| off_m(b).total_cmp(&off_m(a)));
        Self { reach, cells: cells.into_iter().map(|[x, y]| y * SIDE + x).collect() }
    }
}

impl SeenCell {
    fn scan(self) -> u32 {
        self.0 / 8
    }

    fn odds(self) -> u32 {
        self.0 % 8
    }

    /// Sets what a scan saw here; the first that it is said to have seen counts. `scans`: the last that is forgotten, and this one.
    fn set(&mut self, [forgotten, scan]: [u32; 2], seen: CellState) {
        let before = if self.scan() > forgotten { self.odds() } else { MOST_ODDS };
        let odds = match seen {
            CellState::Wall => (before + 1).min(2 * MOST_ODDS),
            CellState::Free => before.max(1) - 1,
            CellState::Dark | CellState::Never => before - u32::from(before > MOST_ODDS),
        };
        *self = if self.scan() == scan { *self } else { Self(scan * 8 + odds) };
    }
}

/// Whether two neighbouring rays end at one surface, without an edge between them.
fn are_joined(from: &Ray, to: &Ray) -> bool {
    let [from_m, to_m] = [from, to].map(Ray::end_m);
    from.end == to.end && (from.end == RayEnd::Range || (to_m - from_m).norm() <= JOINED_M)
}

/// The index of the cell of a place.
fn index_of(corner: Vector2<f64>, place_m: Vector2<f64>) -> Option<usize> {
    let at = place_m / CELL_M - corner;
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
    fn ahead() -> Rays {
        let ray = |degree: i32| {
            let bearing_rad = f64::from(degree).to_radians();
            Ray::new(bearing_rad, 2.0 / bearing_rad.cos(), RayEnd::Wall(0))
        };
        Rays::of_one_wall((-60..=60).map(ray).collect(), false)
    }

    #[test]
    fn what_was_ahead_is_known_once_it_lies_behind() {
        let mut surroundings = Surroundings::default();
        surroundings.add(&at(0.0), 0, &ahead());
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
        surroundings.add(&at(0.0), 0, &ahead());
        let far = ahead().rays.into_iter().map(|ray| Ray { free_m: 6.0, end: RayEnd::Range, ..ray });
        let door = Rays::of_one_wall(far.collect(), false);
        surroundings.add(&at(0.3), 0, &door);
        assert_eq!(surroundings.ray(&Isometry2::identity(), 0.0, 5.0).end, RayEnd::Range);
        surroundings.add(&at(100.0), 0, &door);
        assert_eq!(surroundings.ray(&Isometry2::identity(), 0.0, 5.0).end, RayEnd::Unknown);
        assert_eq!(surroundings.ray(&Isometry2::translation(100.0, 0.0), 0.0, 5.0).end, RayEnd::Range);
    }

    #[test]
    fn what_was_seen_is_unknown_once_the_pose_since_then_is_in_doubt() {
        let mut surroundings = Surroundings::default();
        surroundings.add(&at(0.0), 0, &ahead());
        let mut later = at(0.0);
        let seen = |surroundings: &Surroundings| surroundings.ray(&Isometry2::identity(), 0.0, 5.0).end;
        for (guessed_m, end) in [(0.2, RayEnd::WallBefore), (0.1, RayEnd::Unknown)] {
            let guessed = MotionDoubt { guessed_m, ..MotionDoubt::default() };
            later.doubt.add(&guessed, Point2::origin());
            // The vehicle stands: nothing is seen anew.
            surroundings.add(&later, 0, &ahead());
            assert_eq!(seen(&surroundings), end);
        }
    }
}
