//! Walls that stand free in front of others: pillars. They are found here whatever the affinity is; the one that is called
//! `passage` has rules of its own for them, so that it does not tie them to what is behind.

use crosscut_stage::{Beam, Junction, Point, Revolution, Wall};

use crate::ring::{Position, Ring};

/// What is seen past either end of an island lies at least this much farther.
const BEHIND_M: f64 = 0.5;
/// Walls that run out in directions no farther apart are the sides of one way on: two branches are farther apart.
const ONE_WAY_RAD: f64 = 35.0 * std::f64::consts::PI / 180.0;

/// What is asked of an island.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limits {
    /// It is shorter.
    pub(crate) island_m: f64,
    /// A vehicle can pass beside it.
    pub(crate) vehicle_width_m: f64,
}

/// Sets `island` of the walls of `out` that are short and stand free, and takes them out of `ring`. A wall stands free
/// if on both sides the next wall, going around the sensor, is farther away; or if it is on one side, and on the other
/// there is room, and both are long walls that run out past it side by side: it stands in the way on between them. Where
/// a limited view ends, it is enough that there is room to the end of it, or that the wall is nearer than a vehicle lets
/// one come: then it is of the vehicle itself.
///
/// Nearest first: one that is partly hidden by another is judged by what is beside both. Two beside each other, neither
/// of them farther, stand free together.
pub(crate) fn mark(revolution: &Revolution, limits: &Limits, ring: &mut Ring, out: &mut Junction) {
    let mut is_seen = vec![false; out.walls.len()];
    ring.entries.iter().for_each(|entry| is_seen[entry.wall as usize] = true);
    let mut others = is_seen.iter().filter(|&&is_seen| is_seen).count();
    let are_short = are_short(revolution, out, limits.island_m);
    let is_short = |wall: u32| are_short[wall as usize];
    // Of a cloud, the level view does not see every wall.
    let short = |wall: &&Wall| is_short(wall.id) && is_seen[wall.id as usize];
    let nearest_m = |wall: &Wall| nearest_m(revolution, &out.wall_of_return, wall.id);
    let mut candidates: Vec<(f64, u32)> =
        out.walls.iter().filter(short).map(|wall| (nearest_m(wall), wall.id)).collect();
    candidates.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut candidates: Vec<u32> = candidates.into_iter().map(|(_, id)| id).collect();
    while let Some(free) = first_free(ring, &candidates, limits, &is_short).filter(|free| free.len() < others) {
        others -= free.len();
        for id in free {
            out.walls[id as usize].island = true;
            ring.remove(id);
            candidates.retain(|&other| other != id);
        }
    }
}

/// The first of the walls that stands free; if there is none, the first two that do together.
fn first_free(ring: &Ring, walls: &[u32], limits: &Limits, is_short: &impl Fn(u32) -> bool) -> Option<Vec<u32>> {
    let alone = walls.iter().map(|&id| vec![id]);
    let pairs = pairs_beside_each_other(ring, walls).into_iter().map(|[b, a]| vec![walls[a], walls[b]]);
    alone.chain(pairs).find(|free| stand_free(ring, free, limits, is_short))
}

/// The walls that follow each other around the sensor, as their places in `walls`, the later first; in order. Two others
/// stand free together only if each does alone. The first and the last of a limited view have but one side each, so
/// they count as well.
fn pairs_beside_each_other(ring: &Ring, walls: &[u32]) -> Vec<[usize; 2]> {
    let mut places = vec![None; walls.iter().max().map_or(0, |&id| id as usize + 1)];
    walls.iter().enumerate().for_each(|(place, &id)| places[id as usize] = Some(place));
    let place = |at: usize| places.get(ring.entries[at].wall as usize).copied().flatten();
    let ends = (!ring.full_turn && ring.len() > 0).then(|| (0, ring.len() - 1));
    let beside = (0..ring.edges()).map(|at| (at, ring.after(at))).chain(ends);
    let mut pairs: Vec<[usize; 2]> = beside
        .filter_map(|(at, next)| Some([place(at)?, place(next)?]))
        .filter(|[a, b]| a != b)
        .map(|[a, b]| [a.max(b), a.min(b)])
        .collect();
    pairs.sort_unstable();
    pairs.dedup();
    pairs
}

/// Whether no two returns of each wall are so far from each other.
fn are_short(revolution: &Revolution, out: &Junction, least_m: f64) -> Vec<bool> {
    let are_near = |a: &Point, b: &Point| (a - b).norm_squared() < least_m * least_m;
    let returns = || revolution.points_m.iter().zip(&out.wall_of_return);
    let mut first: Vec<Option<&Point>> = vec![None; out.walls.len()];
    let mut are_short = vec![true; out.walls.len()];
    for (point, wall) in returns() {
        let Some(wall) = wall.map(|id| id as usize) else { continue };
        are_short[wall] &= are_near(first[wall].get_or_insert(point), point);
    }
    // Most are long by that. The first return in the message may be in the middle of the others.
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

fn stand_free(ring: &Ring, walls: &[u32], limits: &Limits, is_short: &impl Fn(u32) -> bool) -> bool {
    let is_one = |at: usize| walls.contains(&ring.entries[at].wall);
    let is_of_vehicle =
        || (0..ring.len()).filter(|&at| is_one(at)).all(|at| ring.entries[at].range_m < limits.vehicle_width_m);
    // In doubt it is a wall: any beam of which nothing is known may have met more of it.
    let is_cut = |at: usize, anticlockwise: bool| {
        let is_doubtful = || ring.beams_to_end(at, anticlockwise).contains(&Beam::Unknown);
        is_one(at) && (ring.room_to_end_m(at, anticlockwise) < limits.vehicle_width_m || is_doubtful())
    };
    let is_at_end = !ring.full_turn && ring.len() > 0 && (is_cut(0, false) || is_cut(ring.len() - 1, true));
    if is_at_end && !is_of_vehicle() {
        return false;
    }
    let steps: Vec<Step> = (0..ring.edges()).filter_map(|at| Step::from_one_to_another(ring, at, is_one)).collect();
    let behind = steps.iter().filter(|step| step.goes_behind(ring)).count();
    let in_way = |[a, b]: [&Step; 2]| {
        let has_room = |step: &Step| step.goes_behind(ring) || step.aside_m(ring) >= limits.vehicle_width_m;
        let is_long = |step: &Step| !is_short(ring.entries[step.outer].wall);
        [a, b].iter().all(|step| has_room(step) && is_long(step))
            && stands_between(ring, [a, b], limits.vehicle_width_m)
    };
    match &steps[..] {
        [] => false, // nothing is beside them
        _ if behind == steps.len() => true,
        [a, b] if behind == 1 => in_way([a, b]),
        _ => false,
    }
}

/// From an end of a wall to the return beside it, which is of another.
struct Step {
    inner: usize,
    outer: usize,
    /// The other wall goes on anticlockwise.
    anticlockwise: bool,
}

impl Step {
    /// The step from an entry to the next, if one of them alone `is_one` of the walls asked about.
    fn from_one_to_another(ring: &Ring, at: usize, is_one: impl Fn(usize) -> bool) -> Option<Self> {
        let next = ring.after(at);
        match (is_one(at), is_one(next)) {
            (true, false) => Some(Self { inner: at, outer: next, anticlockwise: true }),
            (false, true) => Some(Self { inner: next, outer: at, anticlockwise: false }),
            _ => None,
        }
    }

    fn goes_behind(&self, ring: &Ring) -> bool {
        ring.entries[self.outer].range_m > ring.entries[self.inner].range_m + BEHIND_M
    }

    /// How far the two ends are apart across the beams, at the nearer of them.
    fn aside_m(&self, ring: &Ring) -> f64 {
        let [inner, outer] = [self.inner, self.outer].map(|at| &ring.entries[at]);
        let apart = inner.beam.abs_diff(outer.beam);
        let apart = if ring.full_turn { apart.min(ring.beams.len() - apart) } else { apart };
        inner.range_m.min(outer.range_m) * apart as f64 * ring.step_rad
    }

    /// The direction in which the other wall runs towards its end here, over a length of it.
    fn runs_out(&self, ring: &Ring, length_m: f64) -> Option<Position> {
        let end = &ring.entries[self.outer];
        let along = ring.onward(self.outer, self.anticlockwise);
        let to_end_m = along.take_while(|entry| entry.wall == end.wall).map(|entry| end.position_m - entry.position_m);
        let mut longest_m = Position::zeros();
        for offset_m in to_end_m {
            longest_m = offset_m;
            if offset_m.norm() >= length_m {
                break;
            }
        }
        longest_m.try_normalize(0.0)
    }
}

/// Whether what is between two steps stands between walls that run out in one direction, with room for a vehicle to the
/// line of either.
fn stands_between(ring: &Ring, [a, b]: [&Step; 2], vehicle_width_m: f64) -> bool {
    let runs_out = |step: &Step| step.runs_out(ring, vehicle_width_m);
    let (Some(along_a), Some(along_b)) = (runs_out(a), runs_out(b)) else { return false };
    let off_line_m = |step: &Step, along: Position| {
        along.perp(&(ring.entries[step.inner].position_m - ring.entries[step.outer].position_m)).abs()
    };
    along_a.dot(&along_b) > ONE_WAY_RAD.cos()
        && off_line_m(a, along_a) >= vehicle_width_m
        && off_line_m(b, along_b) >= vehicle_width_m
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
        let mut ring = Ring::default();
        ring.fill(&revolution, &sweep, &junction.wall_of_return);
        mark(&revolution, &Limits { island_m, vehicle_width_m: 0.6 }, &mut ring, &mut junction);
        assert!(ring.entries.iter().all(|entry| !junction.walls[entry.wall as usize].island), "islands are taken out");
        junction.walls.iter().map(|wall| wall.island).collect()
    }

    #[test]
    fn a_short_piece_in_front_of_its_neighbours_is_an_island_and_a_long_one_is_not() {
        let labels = [0, 0, 0, 1, 1, 0, 0, 0];
        let ranges_m = [5.0, 5.0, 5.0, 2.0, 2.0, 5.0, 5.0, 5.0];
        assert_eq!(marked(ranges_m, labels, 2.0), [false, true]);
        assert_eq!(marked(ranges_m, labels, 1.0), [false, false], "1.5 m long");
        assert_eq!(marked(ranges_m, labels, 0.0), [false, false], "switched off");
    }

    #[test]
    fn a_piece_with_a_neighbour_as_near_is_a_wall_unless_that_is_an_island_itself() {
        let labels = [0, 0, 1, 2, 0, 0, 0, 0];
        assert_eq!(marked([5.0, 2.1, 2.0, 5.0, 5.0, 5.0, 5.0, 5.0], [0, 0, 1, 0, 0, 0, 0, 0], 2.0), [false, false]);
        assert_eq!(marked([5.0, 5.0, 1.0, 2.2, 5.0, 5.0, 5.0, 5.0], labels, 2.0), [false, true, true]);
    }

    #[test]
    fn two_pieces_as_near_as_each_other_stand_free_together_and_not_beside_a_wall() {
        let labels = [0, 0, 1, 2, 0, 0, 0, 0];
        assert_eq!(marked([5.0, 5.0, 2.0, 2.2, 5.0, 5.0, 5.0, 5.0], labels, 2.0), [false, true, true]);
        assert_eq!(marked([5.0, 2.3, 2.0, 2.2, 5.0, 5.0, 5.0, 5.0], labels, 2.0), [false, false, false]);
        let two = [2.0, 2.2, 2.0, 2.2, 2.0, 2.2, 2.0, 2.2];
        assert_eq!(marked(two, [0, 1, 0, 1, 0, 1, 0, 1], 5.0), [false, false], "something is a wall");
    }

    #[test]
    fn beside_the_end_of_a_limited_view_a_short_piece_is_an_island_if_there_is_room_that_is_known_to_be_free() {
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
    fn beside_the_end_of_a_limited_view_what_is_nearer_than_a_vehicle_lets_a_wall_come_is_of_the_vehicle() {
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
        let mut ring = Ring::default();
        ring.fill(&revolution, &sweep, &junction.wall_of_return);
        mark(&revolution, &Limits { island_m: 2.0, vehicle_width_m: 0.6 }, &mut ring, &mut junction);
        assert!(!junction.walls[0].island && !junction.walls[2].island, "long walls");
        junction.walls[1].island
    }

    #[test]
    fn a_short_piece_behind_the_end_of_a_wall_is_an_island_where_a_vehicle_passes_on_both_sides_into_one_way() {
        assert!(piece_in_way([-0.9, -0.3], 0.0));
        assert!(piece_in_way([-0.9, -0.3], 20.0));
        assert!(!piece_in_way([-0.9, -0.3], 50.0), "the tip between two branches");
        assert!(!piece_in_way([-1.7, -1.1], 0.0), "on the line of the right wall: it goes on behind a branch");
    }
}
