//! Ways on: what is left of the sphere of directions at a distance at which it falls apart and stays apart.

use nalgebra::Vector3;

use super::reach::clear_m;
use super::sight::{Seen, Sight};
use super::sphere::Sphere;
use crosscut_stage::DisjointSets;

/// One way on.
#[derive(Clone, Debug, Default)]
pub struct WayFound {
    /// Towards it; a unit vector.
    pub direction: Vector3<f64>,
    /// The diameter of the largest ball that passes, at the distance at which it was found, metres.
    pub clearance_m: f64,
    /// How far the vehicle gets straight on, metres; infinite where nothing came back.
    pub reach_m: f64,
    /// The distance at which it merges with another way, or with what is too near, metres: the next wall beside it.
    pub merges_m: f64,
    /// The share of its cells in which nothing came back.
    pub no_return_share: f64,
    /// It goes on beyond what the sensor looks at.
    pub cut_by_view: bool,
    /// Its cells, ascending.
    pub cells: Vec<u32>,
}

/// Distances, as multiples of the room.
#[derive(Clone, Copy, Debug)]
pub struct Cut {
    /// A way is a component of the directions in which the vehicle gets as far.
    pub apart: f64,
    /// And gets as far in one of them.
    pub on: f64,
    /// Cells at least.
    pub cells: usize,
}

/// The ways at a cut, by their first cell.
pub(super) fn find(sphere: &Sphere, sight: &Sight, reach_m: &[f64], room_m: f64, cut: Cut) -> Vec<WayFound> {
    let (apart_m, on_m) = (cut.apart * room_m, cut.on * room_m);
    let is_open = |cell: usize| reach_m[cell] >= apart_m;
    let mut sets = DisjointSets::default();
    sets.reset(sphere.len());
    for cell in (0..sphere.len()).filter(|cell| is_open(*cell)) {
        for &other in sphere.neighbours[cell].iter().filter(|other| (**other as usize) < cell && is_open(**other as usize)) {
            sets.join(cell, other as usize);
        }
    }
    let mut of_root: Vec<(usize, WayFound)> = Vec::new();
    for cell in (0..sphere.len()).filter(|cell| is_open(*cell)) {
        let root = sets.root(cell);
        let at = of_root.iter().position(|(known, _)| *known == root).unwrap_or_else(|| {
            of_root.push((root, WayFound::default()));
            of_root.len() - 1
        });
        of_root[at].1.cells.push(cell as u32);
    }
    let mut ways: Vec<WayFound> = of_root.into_iter().map(|(_, way)| way).collect();
    for way in &mut ways {
        let cells = || way.cells.iter().map(|cell| *cell as usize);
        way.reach_m = cells().map(|cell| reach_m[cell]).fold(0.0, f64::max);
        let sum: Vector3<f64> = cells().map(|cell| sphere.directions[cell].into_inner()).sum();
        way.direction = sum.try_normalize(0.0).unwrap_or(sphere.directions[way.cells[0] as usize].into_inner());
        let none = cells().filter(|cell| sight.seen[*cell] == Seen::Nothing).count();
        way.no_return_share = none as f64 / way.cells.len() as f64;
        way.cut_by_view =
            cells().any(|cell| sphere.neighbours[cell].iter().any(|other| sight.seen[*other as usize] == Seen::Unknown));
        let at_m = 0.5 * (apart_m + on_m);
        let rooms_m = cells().map(|cell| clear_m(sight, &sphere.directions[cell].scale(at_m)));
        way.clearance_m = 2.0 * rooms_m.fold(0.0, f64::max);
    }
    ways.retain(|way| way.reach_m >= on_m && way.cells.len() >= cut.cells);
    ways
}
