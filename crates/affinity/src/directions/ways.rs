//! Ways on: the components of the directions in which the vehicle gets as far as they stay apart.

use crosscut_stage::{Between, DisjointSets, Evidence, Way};
use nalgebra::Vector3;

use super::reach::clear_m;
use super::sight::{Seen, Sight};
use super::sphere::Sphere;

/// Ways are components of the directions in which the vehicle gets as far, in multiples of the room at the sensor.
pub(super) const APART: f64 = 2.25;
/// And it gets as far in one of them.
pub(super) const ON: f64 = 2.475;
/// A single cell is not enough.
const LEAST_CELLS: usize = 2;
/// Whether a way stays by itself is asked at these distances.
const RADII: [f64; 5] = [1.75, 2.0, 2.25, 2.5, 2.75];
/// Of answers whose least way stays at as many of them, the share that is right, on development seeds.
const RIGHT_SHARE: [f64; RADII.len() + 1] = [0.4, 0.4, 0.5, 0.6, 0.85, 0.98];
/// And as much of it where the view cuts a way, or something is known in a smaller share of all directions: the room may be less
/// than is seen. If nothing is seen in the way either, as much as the second number.
const CUT_SHARE: [f64; 2] = [0.95, 0.87];
/// See [`CUT_SHARE`].
const KNOWN_SHARE: f64 = 0.75;

/// The mean of the unit vectors to the cells of one way is at least as long: an arc of less than half a turn (165°), or a cap of less
/// than 30 % of all directions. What is wider, as in a place that is wide for its height, may be several ways: then the odds are these.
const ONE_WAY: f64 = 0.7;
const WIDE_ODDS: f64 = 0.3;
/// And where something is seen nearer than this many radii of the vehicle: it is rather a part of the vehicle, and the room is its own.
pub(super) const OWN_RADII: f64 = 1.25;

/// A way, and its cells, ascending.
#[derive(Clone, Debug)]
pub struct Found {
    /// What is known of it.
    pub way: Way,
    /// The cells of the sphere that it takes.
    pub cells: Vec<u32>,
}

/// The ways, by their first cell, of a sight with as much room at the sensor, all but their slopes; none of them is sure where
/// `is_doubtful`.
pub(super) fn find(sphere: &Sphere, sight: &Sight, reach_m: &[f64], room_m: f64, is_doubtful: bool) -> Vec<Found> {
    let (mut sets, mut of_cell) = (DisjointSets::default(), Vec::new());
    let mut parts = components(sphere, reach_m, APART * room_m, &mut sets, &mut of_cell);
    let is_on = |cells: &Vec<u32>| cells.iter().any(|cell| reach_m[*cell as usize] >= ON * room_m);
    parts.retain(|cells| cells.len() >= LEAST_CELLS.min(sphere.rings().len()) && is_on(cells));
    let mut stays = vec![0; parts.len()];
    for radius in RADII {
        let at = components(sphere, reach_m, radius * room_m, &mut sets, &mut of_cell).len();
        // A way that shares its component with others, or has none, does not stay.
        let of_way: Vec<Vec<usize>> = parts.iter().map(|cells| within(cells, &of_cell)).collect();
        let mut taken = vec![0; at];
        of_way.iter().flatten().for_each(|part| taken[*part] += 1);
        for (stays, of_way) in stays.iter_mut().zip(&of_way) {
            *stays += usize::from(of_way.len() == 1 && taken[of_way[0]] == 1);
        }
    }
    let is_narrow = is_narrow(sphere, sight);
    let known = |(cells, stays): (Vec<u32>, usize)| {
        let mut way = known_of(sphere, sight, reach_m, room_m, &cells, RIGHT_SHARE[stays]);
        if way.cut_by_view || is_narrow {
            way.p *= CUT_SHARE[usize::from(way.evidence == Evidence::NoReturn)];
        }
        if is_doubtful {
            way.p = way.p.min(WIDE_ODDS);
        }
        Found { way, cells }
    };
    parts.into_iter().zip(stays).map(known).collect()
}

/// The components that cells lie in, ascending.
pub(super) fn within(cells: &[u32], of_cell: &[Option<usize>]) -> Vec<usize> {
    let mut within: Vec<usize> = cells.iter().filter_map(|cell| of_cell[*cell as usize]).collect();
    within.sort_unstable();
    within.dedup();
    within
}

/// Whether something is known in a small share of all directions.
pub(super) fn is_narrow(sphere: &Sphere, sight: &Sight) -> bool {
    let unknown = sight.seen.iter().filter(|seen| **seen == Seen::Unknown).count();
    (unknown as f64) > (1.0 - KNOWN_SHARE) * sphere.len() as f64
}

/// The components of the cells in which the vehicle gets as far, and of each cell its component.
pub(super) fn components(
    sphere: &Sphere,
    reach_m: &[f64],
    apart_m: f64,
    sets: &mut DisjointSets,
    of_cell: &mut Vec<Option<usize>>,
) -> Vec<Vec<u32>> {
    let is_open = |cell: usize| reach_m[cell] >= apart_m;
    sets.reset(sphere.len());
    for cell in (0..sphere.len()).filter(|cell| is_open(*cell)) {
        let before = sphere.neighbours[cell].iter().map(|other| *other as usize).take_while(|other| *other < cell);
        before.filter(|other| is_open(*other)).for_each(|other| sets.join(cell, other));
    }
    of_cell.clear();
    of_cell.resize(sphere.len(), None);
    let mut parts: Vec<Vec<u32>> = Vec::new();
    for cell in (0..sphere.len()).filter(|cell| is_open(*cell)) {
        // The root of a set is its smallest member.
        let part = *of_cell[sets.root(cell)].get_or_insert(parts.len());
        of_cell[cell] = Some(part);
        if part == parts.len() {
            parts.push(Vec::new());
        }
        parts[part].push(cell as u32);
    }
    parts
}

fn known_of(sphere: &Sphere, sight: &Sight, reach_m: &[f64], room_m: f64, cells: &[u32], right_share: f64) -> Way {
    let cells = || cells.iter().map(|cell| *cell as usize);
    let at_m = 0.5 * (APART + ON) * room_m;
    // Infinite where nothing is seen at all.
    let clear_m = |cell: usize| clear_m(sight, &sphere.directions[cell].scale(at_m)).min(at_m);
    let (mut largest_m, mut sum, mut by_room) = (0.0_f64, Vector3::zeros(), Vector3::zeros());
    for (clear_m, direction) in cells().map(|cell| (clear_m(cell), sphere.directions[cell].into_inner())) {
        largest_m = largest_m.max(clear_m);
        sum += direction;
        by_room += direction * (clear_m * clear_m);
    }
    let nothing = cells().filter(|cell| sight.seen[*cell] == Seen::Nothing).count();
    let is_beside_unknown =
        |cell: usize| sphere.neighbours[cell].iter().any(|other| sight.seen[*other as usize] == Seen::Unknown);
    let is_cut = cells().any(is_beside_unknown);
    let is_wide = sum.norm() < ONE_WAY * cells().count() as f64;
    let middle = by_room.try_normalize(0.0).filter(|middle| cells().any(|cell| cell == sphere.cell(middle, 1.0)));
    // That all around is not open in its middle.
    let farthest = cells().max_by(|a, b| reach_m[*a].total_cmp(&reach_m[*b]).then(b.cmp(a)));
    let of_farthest = farthest.map(|cell| sphere.directions[cell].into_inner());
    Way {
        direction: middle.or(of_farthest).unwrap_or_else(Vector3::x),
        slope_rad: 0.0,
        clearance_m: 2.0 * largest_m,
        p: if is_wide { WIDE_ODDS } else { right_share },
        evidence: if 2 * nothing > cells().count() { Evidence::NoReturn } else { Evidence::SeenThrough },
        cut_by_view: is_cut,
        is_wide,
    }
}

/// Where the ways would be one if they were cut at less: cells are let in from the farthest reach down, and each that joins two
/// ways parts them.
pub(super) fn between(sphere: &Sphere, reach_m: &[f64], ways: &[Found]) -> Vec<Between> {
    let mut way_of: Vec<Option<u32>> = vec![None; sphere.len()];
    for (number, found) in (0..).zip(ways) {
        found.cells.iter().for_each(|cell| way_of[*cell as usize] = Some(number));
    }
    let mut inwards: Vec<usize> = (0..sphere.len()).filter(|cell| reach_m[*cell] >= 0.0).collect();
    inwards.sort_unstable_by(|a, b| reach_m[*b].total_cmp(&reach_m[*a]).then(a.cmp(b)));
    let mut joined = DisjointSets::default();
    joined.reset(ways.len());
    let (mut is_in, mut found) = (vec![false; sphere.len()], Vec::new());
    for cell in inwards {
        is_in[cell] = true;
        for other in sphere.neighbours[cell].iter().map(|other| *other as usize).filter(|other| is_in[*other]) {
            way_of[cell] = way_of[cell].or(way_of[other]);
            if let (Some(a), Some(b)) = (way_of[cell], way_of[other])
                && joined.root(a as usize) != joined.root(b as usize)
            {
                joined.join(a as usize, b as usize);
                let direction = sphere.directions[cell].into_inner();
                found.push(Between { ways: [a.min(b), a.max(b)], direction, reach_m: reach_m[cell] });
            }
        }
    }
    found
}
