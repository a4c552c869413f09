//! Walls that stand free in front of others: pillars.
//!
//! `crosscut_scan::Islands` looks for them among pieces, before any wall is known. These rules look at whole walls, of any
//! affinity, and know where each of them ends. Asked for whole walls, the rules for pieces did worse in wet mines and
//! among pillars, so there are two.

use std::f64::consts::TAU;

use crosscut_scan::{BEHIND_M, Position, WIDEST_RAD, faces_dark};
use crosscut_stage::{Beam, Junction, Point, Revolution, Wall};

use crate::openings::WallEnd;
use crate::wall_ring::WallRing;

/// Two walls within 35° of parallel bound one opening: two branches are farther apart.
const ONE_OPENING_RAD: f64 = 35.0 * std::f64::consts::PI / 180.0;

/// Sets `island` of the walls of `out` that are shorter than `island_m`, seen over less than [`WIDEST_RAD`] and stand free,
/// and takes them out of `outline`.
///
/// A wall stands free if
/// - on both sides the next wall, around the sensor, is farther away, or nothing is seen beside a wall that is smaller
///   than the vehicle ([`faces_dark`]); or
/// - on one side it is, on the other there is room for a vehicle, and both are long walls that run out past it side by
///   side: it stands in the opening between them;
/// - and where a limited view ends beside it, there is room to that end, or it is nearer than a vehicle lets a wall
///   come, and so part of the vehicle.
///
/// The nearest is found first, so that one that it partly hides is judged by the walls beside both. Two neighbours,
/// neither of them farther, stand free together.
pub(crate) fn mark(
    revolution: &Revolution,
    island_m: f64,
    vehicle_width_m: f64,
    outline: &mut WallRing,
    out: &mut Junction,
) {
    let mut others = out.walls.len();
    let (are_short, are_small) = (are_short(revolution, out, island_m), are_short(revolution, out, vehicle_width_m));
    let is_narrow = |wall: &Wall| (wall.bearing_rad[1] - wall.bearing_rad[0]).rem_euclid(TAU) < WIDEST_RAD;
    let may_stand_free = |wall: &&Wall| are_short[wall.id as usize] && is_narrow(wall);
    let nearest_m = |wall: &Wall| nearest_m(revolution, &out.wall_of_return, wall.id);
    let mut candidates: Vec<(f64, u32)> =
        out.walls.iter().filter(may_stand_free).map(|wall| (nearest_m(wall), wall.id)).collect();
    candidates.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut candidates: Vec<u32> = candidates.into_iter().map(|(_, id)| id).collect();
    loop {
        let search = WallSearch { outline, are_short: &are_short, are_small: &are_small, vehicle_width_m };
        let Some(free) = search.first_free(&candidates).filter(|free| free.len() < others) else { return };
        others -= free.len();
        for id in free {
            out.walls[id as usize].island = true;
            outline.remove(id);
            candidates.retain(|&other| other != id);
        }
    }
}

/// Whether each wall has no two returns that are this far from each other.
fn are_short(revolution: &Revolution, out: &Junction, least_m: f64) -> Vec<bool> {
    let are_near = |a: &Point, b: &Point| (a - b).norm_squared() < least_m * least_m;
    let returns = || revolution.points_m.iter().zip(&out.wall_of_return);
    let mut first: Vec<Option<&Point>> = vec![None; out.walls.len()];
    let mut are_short = vec![true; out.walls.len()];
    for (point, wall) in returns() {
        let Some(wall) = wall.map(|id| id as usize) else { continue };
        are_short[wall] &= are_near(first[wall].get_or_insert(point), point);
    }
    // Most walls are long by that. The first return in the message may lie in the middle of the others.
    for (id, is_short) in (0..).zip(&mut are_short).filter(|(_, is_short)| **is_short) {
        let wall: Vec<&Point> = returns().filter(|(_, wall)| **wall == Some(id)).map(|(point, _)| point).collect();
        *is_short = (1..wall.len()).all(|a| wall[..a].iter().all(|b| are_near(wall[a], b)));
    }
    are_short
}

/// Range of the nearest return of a wall.
fn nearest_m(revolution: &Revolution, wall_of_return: &[Option<u32>], id: u32) -> f64 {
    let of_wall = (0..wall_of_return.len()).filter(|&i| wall_of_return[i] == Some(id));
    of_wall.map(|i| revolution.range_m(i)).fold(f64::INFINITY, f64::min)
}

/// One look for walls that stand free.
#[derive(Clone, Copy)]
struct WallSearch<'a> {
    outline: &'a WallRing,
    are_short: &'a [bool],
    /// For each wall whether it is smaller than the vehicle.
    are_small: &'a [bool],
    vehicle_width_m: f64,
}

impl WallSearch<'_> {
    /// The first of the walls that stands free; if there is none, the first two that do together.
    fn first_free(&self, walls: &[u32]) -> Option<Vec<u32>> {
        let alone = walls.iter().map(|&id| vec![id]);
        let pairs = self.neighbours(walls).into_iter().map(|[b, a]| vec![walls[a], walls[b]]);
        alone.chain(pairs).find(|free| self.stand_free(free))
    }

    /// The pairs of walls that are neighbours around the sensor, as their places in `walls`, the later first; in order.
    /// Two that are no neighbours stand free together only if each does alone. The first and the last wall of a limited
    /// view have but one neighbour each, so they count as a pair as well.
    fn neighbours(&self, walls: &[u32]) -> Vec<[usize; 2]> {
        let mut places = vec![None; walls.iter().max().map_or(0, |&id| id as usize + 1)];
        walls.iter().enumerate().for_each(|(place, &id)| places[id as usize] = Some(place));
        let place = |at: usize| places.get(self.outline.wall(at) as usize).copied().flatten();
        let ends_of_view =
            (!self.outline.ring.full_turn && !self.outline.is_empty()).then(|| [0, self.outline.len() - 1]);
        let mut pairs: Vec<[usize; 2]> = (self.outline.pairs().chain(ends_of_view))
            .filter_map(|[at, next]| Some([place(at)?, place(next)?]))
            .filter(|[a, b]| a != b)
            .map(|[a, b]| [a.max(b), a.min(b)])
            .collect();
        pairs.sort_unstable();
        pairs.dedup();
        pairs
    }

    fn stand_free(&self, walls: &[u32]) -> bool {
        let (outline, n) = (self.outline, self.outline.len());
        let is_one = |at: usize| walls.contains(&outline.wall(at));
        let are_of_vehicle = || (0..n).filter(|&at| is_one(at)).all(|at| outline.range_m(at) < self.vehicle_width_m);
        // Any unknown beam may have met more of the wall.
        let is_cut = |at: usize, anticlockwise: bool| {
            let is_doubtful = || outline.beams_to_end(at, anticlockwise).contains(&Beam::Unknown);
            is_one(at) && (outline.room_to_end_m(at, anticlockwise) < self.vehicle_width_m || is_doubtful())
        };
        let is_at_end = !outline.ring.full_turn && n > 0 && (is_cut(0, false) || is_cut(n - 1, true));
        if is_at_end && !are_of_vehicle() {
            return false;
        }
        let ends: Vec<FreeEnd> = outline.pairs().filter_map(|pair| free_end(pair, is_one)).collect();
        let is_free = |end: &&FreeEnd| self.is_behind(end) || self.stands_in_dark(end);
        match (&ends[..], ends.iter().filter(is_free).count()) {
            ([], _) => false,
            (all, behind) if behind == all.len() => true,
            ([a, b], 1) => self.is_in_opening_between(a, b),
            _ => false,
        }
    }

    fn is_behind(&self, (end, neighbour): &FreeEnd) -> bool {
        self.outline.range_m(neighbour.at) > self.outline.range_m(*end) + BEHIND_M
    }

    /// Whether nothing is seen beside this end of a wall that is smaller than the vehicle.
    fn stands_in_dark(&self, (end, neighbour): &FreeEnd) -> bool {
        let beside = if neighbour.is_clockwise { [neighbour.at, *end] } else { [*end, neighbour.at] };
        self.are_small[self.outline.wall(*end) as usize]
            && faces_dark(&self.outline.ring, *end, beside, self.vehicle_width_m)
    }

    /// Whether long walls run out on both sides in one direction, with room for a vehicle to the line of either.
    fn is_in_opening_between(&self, a: &FreeEnd, b: &FreeEnd) -> bool {
        let (outline, width_m) = (self.outline, self.vehicle_width_m);
        let has_room = |end: &FreeEnd| self.is_behind(end) || self.aside_m(end) >= width_m;
        let is_long = |(_, neighbour): &FreeEnd| !self.are_short[outline.wall(neighbour.at) as usize];
        if ![a, b].into_iter().all(|end| has_room(end) && is_long(end)) {
            return false;
        }
        let runs_out = |(_, neighbour): &FreeEnd| neighbour.runs_out(outline, width_m);
        let (Some(along_a), Some(along_b)) = (runs_out(a), runs_out(b)) else { return false };
        let off_line_m = |(end, neighbour): &FreeEnd, along: Position| {
            along.perp(&(outline.position_m(*end) - outline.position_m(neighbour.at))).abs()
        };
        along_a.dot(&along_b) > ONE_OPENING_RAD.cos()
            && off_line_m(a, along_a) >= width_m
            && off_line_m(b, along_b) >= width_m
    }

    /// How far the two returns are apart across the beams, at the nearer of them.
    fn aside_m(&self, (end, neighbour): &FreeEnd) -> f64 {
        let (outline, apart) = (self.outline, self.outline.ring.beams_apart(*end, neighbour.at));
        outline.range_m(*end).min(outline.range_m(neighbour.at)) * apart as f64 * outline.ring.step_rad
    }
}

/// The return at which a wall that may stand free ends, and the end of its neighbour there.
type FreeEnd = (usize, WallEnd);

/// What is between two neighbouring returns, if one of them alone `is_one` of the walls that may stand free.
fn free_end([at, next]: [usize; 2], is_one: impl Fn(usize) -> bool) -> Option<FreeEnd> {
    match (is_one(at), is_one(next)) {
        (true, false) => Some((at, WallEnd { at: next, is_clockwise: false })),
        (false, true) => Some((next, WallEnd { at, is_clockwise: true })),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crosscut_stage::{Beam, Sweep};

    /// Eight beams all around, one wall label for each.
    fn marked(ranges_m: [f64; 8], labels: [u32; 8], island_m: f64) -> Vec<bool> {
        let step_rad = std::f64::consts::FRAC_PI_4;
        let beams = (0..8).map(Beam::Return).collect();
        marked_in(Sweep { beams, step_rad, full_turn: true, ..Sweep::default() }, &ranges_m, &labels, island_m)
    }

    /// A sweep from bearing 0 on, with a range and a wall label for each return.
    fn marked_in(mut sweep: Sweep, ranges_m: &[f64], labels: &[u32], island_m: f64) -> Vec<bool> {
        sweep.bearings_rad = (0..sweep.len()).map(|beam| beam as f64 * sweep.step_rad).collect();
        let returns = sweep.beams.iter().zip(&sweep.bearings_rad).filter(|(beam, _)| matches!(beam, Beam::Return(_)));
        let points = ranges_m.iter().zip(returns).map(|(r, (_, b))| Point::new(r * b.cos(), r * b.sin(), 0.0));
        let revolution = Revolution { points_m: points.collect(), ..Revolution::default() };
        let walls = 1 + *labels.iter().max().expect("some");
        let wall = |id| Wall { id, returns: 1, bearing_rad: [0.0; 2], island: false };
        let mut junction = Junction {
            walls: (0..walls).map(wall).collect(),
            wall_of_return: labels.iter().copied().map(Some).collect(),
            ..Junction::default()
        };
        let mut outline = WallRing::default();
        outline.fill(&revolution, &sweep, &junction.wall_of_return).expect("in message order");
        mark(&revolution, island_m, 0.6, &mut outline, &mut junction);
        assert!(outline.walls().iter().all(|&wall| !junction.walls[wall as usize].island), "islands are taken out");
        junction.walls.iter().map(|wall| wall.island).collect()
    }

    #[test]
    fn short_walls_before_both_neighbours_are_islands() {
        let labels = [0, 0, 0, 1, 1, 0, 0, 0];
        let ranges_m = [5.0, 5.0, 5.0, 2.0, 2.0, 5.0, 5.0, 5.0];
        assert_eq!(marked(ranges_m, labels, 2.0), [false, true]);
        assert_eq!(marked(ranges_m, labels, 1.0), [false, false], "1.5 m long");
        assert_eq!(marked(ranges_m, labels, 0.0), [false, false], "switched off");
    }

    #[test]
    fn walls_with_a_near_neighbour_are_no_islands() {
        let labels = [0, 0, 1, 2, 0, 0, 0, 0];
        assert_eq!(marked([5.0, 2.1, 2.0, 5.0, 5.0, 5.0, 5.0, 5.0], [0, 0, 1, 0, 0, 0, 0, 0], 2.0), [false, false]);
        assert_eq!(marked([5.0, 5.0, 1.0, 2.2, 5.0, 5.0, 5.0, 5.0], labels, 2.0), [false, true, true]);
    }

    #[test]
    fn two_equally_near_walls_stand_free_together() {
        let labels = [0, 0, 1, 2, 0, 0, 0, 0];
        assert_eq!(marked([5.0, 5.0, 2.0, 2.2, 5.0, 5.0, 5.0, 5.0], labels, 2.0), [false, true, true]);
        assert_eq!(marked([5.0, 2.3, 2.0, 2.2, 5.0, 5.0, 5.0, 5.0], labels, 2.0), [false, false, false]);
        let two = [2.0, 2.2, 2.0, 2.2, 2.0, 2.2, 2.0, 2.2];
        assert_eq!(marked(two, [0, 1, 0, 1, 0, 1, 0, 1], 5.0), [false, false], "something is a wall");
    }

    #[test]
    fn walls_cut_by_the_view_are_no_islands() {
        let is_island = |beside: Beam, beams_beside: usize| {
            let beams = std::iter::repeat_n(beside, beams_beside).chain((0..5).map(Beam::Return)).collect();
            let sweep = Sweep { beams, step_rad: 10f64.to_radians(), full_turn: false, ..Sweep::default() };
            marked_in(sweep, &[3.0, 3.0, 6.0, 6.0, 6.0], &[0, 0, 1, 1, 1], 2.0)[0]
        };
        assert!(is_island(Beam::NoReturn, 3), "1 m");
        assert!(!is_island(Beam::NoReturn, 2), "0.5 m");
        assert!(!is_island(Beam::Unknown, 3) && !is_island(Beam::Unknown, 0), "cut by the end of the view");
    }

    #[test]
    fn near_walls_at_the_end_of_the_view_are_islands() {
        let is_island = |range_m: f64| {
            let beams = (0..5).map(Beam::Return).collect();
            let sweep = Sweep { beams, step_rad: 10f64.to_radians(), full_turn: false, ..Sweep::default() };
            marked_in(sweep, &[range_m, range_m, 6.0, 6.0, 6.0], &[0, 0, 1, 1, 1], 2.0)[0]
        };
        assert!(is_island(0.5) && !is_island(0.7));
    }

    /// A right wall that ends 4 m ahead, a piece 6 m ahead whose ends lie `piece_m` to the left, and a left wall 6 m
    /// long that runs `left_deg` off the right one. Whether the piece is an island.
    fn piece_in_way(piece_m: [f64; 2], left_deg: f64) -> bool {
        let line = |[from, to]: [Position; 2], wall: u32| {
            let at = move |k: i32| from + (to - from) * f64::from(k) / 40.0;
            (0..=40).map(move |k| (at(k), wall))
        };
        let at = Position::new;
        let (left_m, onward) = (at(2.0, 2.0), at(left_deg.to_radians().cos(), left_deg.to_radians().sin()));
        let walls = [
            line([at(0.0, -2.0), at(4.0, -2.0)], 0),
            line([at(6.0, piece_m[0]), at(6.0, piece_m[1])], 1),
            line([left_m, left_m + onward * 6.0], 2),
        ];
        let step_rad = std::f64::consts::TAU / 720.0;
        let mut seen: Vec<Option<(Position, u32)>> = vec![None; 720];
        for (position_m, wall) in walls.into_iter().flatten() {
            let beam = (position_m.y.atan2(position_m.x) / step_rad).round() as i32 + 360;
            seen[beam as usize % 720] = Some((position_m, wall));
        }
        let mut returns = 0..;
        let beams = seen.iter().map(|seen| seen.and_then(|_| returns.next()).map_or(Beam::NoReturn, Beam::Return));
        let sweep = Sweep {
            beams: beams.collect(),
            step_rad,
            full_turn: true,
            bearings_rad: (0..720).map(|beam| f64::from(beam - 360) * step_rad).collect(),
            ..Sweep::default()
        };
        let points_m =
            seen.iter().flatten().map(|(position_m, _)| Point::new(position_m.x, position_m.y, 0.0)).collect();
        let revolution = Revolution { points_m, ..Revolution::default() };
        let wall = |id| Wall { id, returns: 1, bearing_rad: [0.0; 2], island: false };
        let wall_of_return = seen.iter().flatten().map(|&(_, wall)| Some(wall)).collect();
        let mut junction = Junction { walls: (0..3).map(wall).collect(), wall_of_return, ..Junction::default() };
        let mut outline = WallRing::default();
        outline.fill(&revolution, &sweep, &junction.wall_of_return).expect("in message order");
        mark(&revolution, 2.0, 0.6, &mut outline, &mut junction);
        assert!(!junction.walls[0].island && !junction.walls[2].island, "long walls");
        junction.walls[1].island
    }

    #[test]
    fn walls_that_stand_in_one_opening_are_islands() {
        assert!(piece_in_way([-0.9, -0.3], 0.0));
        assert!(piece_in_way([-0.9, -0.3], 20.0));
        assert!(!piece_in_way([-0.9, -0.3], 50.0), "the tip between two branches");
        assert!(!piece_in_way([-1.7, -1.1], 0.0), "on the line of the right wall: it goes on behind a branch");
    }
}
