//! What a vehicle's ball can do in a mesh: the truth, from its triangles alone.
//!
//! The room between triangles is cut into voxels. The ball fits where its centre is farther than its radius from every
//! triangle. Of the voxels that it reaches from a place on a way of 1.5 ρ or less, those that the sphere of radius ρ about
//! the place cuts fall into components: the ways on at ρ. A place is clear if their number is the same for ρ from 2 to 3
//! local radii, the local radius being that of the largest ball whose centre lies in the largest one about the place.
//! Of a lidar that does not look everywhere, the ways are the components of what is cut in its view.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashSet};

use nalgebra::{Point3, Vector3};

use super::mesh::Mesh;

/// Multiples of the local radius.
pub const RADII: [f64; 5] = [2.0, 2.25, 2.5, 2.75, 3.0];

/// A way on.
#[derive(Clone, Debug)]
pub struct TrueWay {
    pub direction: Vector3<f64>,
    /// Diameter of the largest ball.
    pub clearance_m: f64,
    /// The mean of the voxels that it is cut in.
    pub middle_m: Point3<f64>,
}

/// Free space, as distances from the triangles.
pub struct Space {
    pub voxel_m: f64,
    low_m: Point3<f64>,
    size: [usize; 3],
    /// Squared distance from the nearest triangle, voxels.
    squared: Vec<f32>,
}

impl Space {
    pub fn new(mesh: &Mesh, voxel_m: f64) -> Self {
        let bounds_m = mesh.bounds_m();
        let [low_m, high_m] = bounds_m;
        let low_m = low_m - Vector3::repeat(4.0 * voxel_m);
        let size = [0, 1, 2].map(|axis| ((high_m[axis] - low_m[axis]) / voxel_m) as usize + 5);
        let mut space = Self { voxel_m, low_m, size, squared: vec![f32::MAX; size.iter().product()] };
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.corners_m;
            let longest_m = (b - a).norm().max((c - a).norm()).max((c - b).norm());
            let parts = (longest_m / (0.5 * voxel_m)).ceil().max(1.0);
            for i in 0..=parts as usize {
                for j in 0..=parts as usize - i {
                    let point_m = a + (b - a) * (i as f64 / parts) + (c - a) * (j as f64 / parts);
                    if let Some(at) = space.voxel(&point_m) {
                        space.squared[at] = 0.0;
                    }
                }
            }
        }
        space.spread();
        // Beyond the mesh there is nothing to reach: where a passage is cut off, it ends.
        for voxel in 0..space.squared.len() {
            let middle_m = space.middle_m(voxel);
            if (0..3).any(|axis| !(bounds_m[0][axis]..bounds_m[1][axis]).contains(&middle_m[axis])) {
                space.squared[voxel] = 0.0;
            }
        }
        space
    }

    /// The squared distance of every voxel from the nearest one at 0, axis by axis: the lower envelope of parabolas.
    fn spread(&mut self) {
        let [nx, ny, nz] = self.size;
        let mut line = Vec::new();
        for (count, stride) in [(nx, 1), (ny, nx), (nz, nx * ny)] {
            for start in (0..self.squared.len()).filter(|at| (at / stride) % count == 0) {
                line.clear();
                line.extend((0..count).map(|step| self.squared[start + step * stride]));
                let (mut hull, mut from) = (Vec::<usize>::new(), Vec::<f32>::new());
                let value = |at: usize| line[at] + (at * at) as f32;
                for at in (0..count).filter(|at| line[*at] < f32::MAX) {
                    let mut meets = f32::NEG_INFINITY;
                    while let Some(&last) = hull.last() {
                        meets = (value(at) - value(last)) / (2 * (at - last)) as f32;
                        if from.last().is_some_and(|from| meets <= *from) {
                            (hull.pop(), from.pop());
                            meets = f32::NEG_INFINITY;
                        } else {
                            break;
                        }
                    }
                    (hull.push(at), from.push(meets));
                }
                let mut part = 0;
                for step in 0..if hull.is_empty() { 0 } else { count } {
                    while part + 1 < hull.len() && from[part + 1] <= step as f32 {
                        part += 1;
                    }
                    let away = step.abs_diff(hull[part]) as f32;
                    self.squared[start + step * stride] = line[hull[part]] + away * away;
                }
            }
        }
    }

    fn voxel(&self, point_m: &Point3<f64>) -> Option<usize> {
        let at = (point_m - self.low_m) / self.voxel_m;
        let [x, y, z] = [0, 1, 2].map(|axis| at[axis] as usize);
        let inside = at.min() >= 0.0 && x < self.size[0] && y < self.size[1] && z < self.size[2];
        inside.then(|| x + self.size[0] * (y + self.size[1] * z))
    }

    fn middle_m(&self, voxel: usize) -> Point3<f64> {
        let [nx, ny, _] = self.size;
        let at = [voxel % nx, voxel / nx % ny, voxel / (nx * ny)].map(|at| (at as f64 + 0.5) * self.voxel_m);
        self.low_m + Vector3::from(at)
    }

    fn clear_of(&self, voxel: usize) -> f64 {
        f64::from(self.squared[voxel]).sqrt() * self.voxel_m
    }

    /// The distance of a place from the nearest triangle, metres; 0 outside the grid.
    pub fn clear_m(&self, place_m: &Point3<f64>) -> f64 {
        self.voxel(place_m).map_or(0.0, |voxel| self.clear_of(voxel))
    }

    /// Number of voxels, and the middle of each.
    pub fn count(&self) -> usize {
        self.squared.len()
    }

    pub fn place_m(&self, voxel: usize) -> Point3<f64> {
        self.middle_m(voxel)
    }

    /// The local radius at a place, metres.
    pub fn room_m(&self, place_m: &Point3<f64>) -> f64 {
        let here_m = self.clear_m(place_m);
        let reach = (here_m / self.voxel_m) as isize;
        let mut best_m = here_m;
        for x in -reach..=reach {
            for y in -reach..=reach {
                for z in -reach..=reach {
                    let off = Vector3::new(x as f64, y as f64, z as f64) * self.voxel_m;
                    if off.norm() <= here_m {
                        best_m = best_m.max(self.clear_m(&(place_m + off)));
                    }
                }
            }
        }
        best_m
    }

    fn beside(&self, voxel: usize) -> impl Iterator<Item = (usize, f64)> {
        let [nx, ny, nz] = self.size.map(|count| count as isize);
        let at = [voxel as isize % nx, voxel as isize / nx % ny, voxel as isize / (nx * ny)];
        (0..27).filter(|step| *step != 13).filter_map(move |step: isize| {
            let off = [step % 3 - 1, step / 3 % 3 - 1, step / 9 - 1];
            let [x, y, z] = [at[0] + off[0], at[1] + off[1], at[2] + off[2]];
            let inside = (0..nx).contains(&x) && (0..ny).contains(&y) && (0..nz).contains(&z);
            let steps = off.iter().map(|o| (o * o) as f64).sum::<f64>().sqrt();
            inside.then(|| ((x + nx * (y + ny * z)) as usize, steps))
        })
    }

    /// The voxels that a ball of `radius_m` reaches from a place on a way of this many metres, and the way to each.
    pub fn reached(&self, place_m: &Point3<f64>, radius_m: f64, most_m: f64) -> Vec<(usize, f64)> {
        let fits = |voxel: usize| self.clear_of(voxel) > radius_m;
        // Of each voxel one more than the way to it, metres, and 0 where none leads; and the voxels that are reached.
        let (mut reached_m, mut reached) = (vec![0.0; self.count()], Vec::new());
        let mut open = BinaryHeap::new();
        let key = |way_m: f64| Reverse((way_m * 1e6) as u64);
        if let Some(start) = self.voxel(place_m).filter(|start| fits(*start)) {
            reached_m[start] = 1.0;
            reached.push(start);
            open.push((key(0.0), start));
        }
        while let Some((at_key, at)) = open.pop() {
            let way_m = reached_m[at] - 1.0;
            if at_key != key(way_m) {
                continue;
            }
            for (next, steps) in self.beside(at).filter(|(next, _)| fits(*next)) {
                let next_m = way_m + steps * self.voxel_m;
                let known_m = reached_m[next];
                if next_m <= most_m && (known_m == 0.0 || next_m + 1.0 < known_m) {
                    if known_m == 0.0 {
                        reached.push(next);
                    }
                    reached_m[next] = next_m + 1.0;
                    open.push((key(next_m), next));
                }
            }
        }
        reached.sort_unstable();
        reached.into_iter().map(|voxel| (voxel, reached_m[voxel] - 1.0)).collect()
    }

    /// The ways on at a radius, of what is reached: their parts at elevations in `view_deg`, which may be several of a way.
    pub fn ways(
        &self,
        place_m: &Point3<f64>,
        rho_m: f64,
        view_deg: [f64; 2],
        reached: &[(usize, f64)],
    ) -> Vec<TrueWay> {
        let view = view_deg.map(|deg| deg.to_radians().sin());
        let is_seen = |voxel: usize| {
            let off_m = self.middle_m(voxel) - place_m;
            (view[0]..=view[1]).contains(&(off_m.z / off_m.norm()))
        };
        let off_m = |voxel: usize| (self.middle_m(voxel) - place_m).norm();
        let thick_m = 1.75 * self.voxel_m;
        let shell: Vec<usize> = reached
            .iter()
            .filter(|(voxel, way_m)| *way_m <= 1.5 * rho_m && (rho_m..rho_m + thick_m).contains(&off_m(*voxel)))
            .map(|(voxel, _)| *voxel)
            .filter(|voxel| is_seen(*voxel))
            .collect();
        let mut left: HashSet<usize> = shell.iter().copied().collect();
        let mut found = Vec::new();
        for first in shell {
            if !left.remove(&first) {
                continue;
            }
            let (mut part, mut at) = (vec![first], 0);
            while let Some(&voxel) = part.get(at) {
                at += 1;
                part.extend(self.beside(voxel).map(|(next, _)| next).filter(|next| left.remove(next)));
            }
            part.sort_unstable();
            let sum: Vector3<f64> = part.iter().map(|voxel| (self.middle_m(*voxel) - place_m).normalize()).sum();
            let clearance_m = 2.0 * part.iter().map(|voxel| self.clear_of(*voxel)).fold(0.0, f64::max);
            let middles_m: Vector3<f64> = part.iter().map(|voxel| self.middle_m(*voxel).coords).sum();
            let middle_m = Point3::from(middles_m / part.len() as f64);
            found.push(TrueWay { direction: sum.normalize(), clearance_m, middle_m });
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_room_has_two_ways_on_and_a_cube_none() {
        for (half_m, wanted) in [([20.0, 2.0, 2.0], 2), ([2.0, 2.0, 2.0], 0)] {
            let corner = |at: usize| {
                Point3::from([0, 1, 2].map(|axis| half_m[axis] * if at >> axis & 1 == 1 { 1.0 } else { -1.0 }))
            };
            let sides = [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];
            let halves = sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
            let mesh = Mesh::new(halves.map(|of| of.map(corner)));
            assert!((mesh.range_m(&Point3::origin(), &Vector3::y()) - 2.0).abs() < 1e-9);
            let space = Space::new(&mesh, 0.2);
            let place_m = Point3::new(0.05, 0.05, 0.05);
            let room_m = space.room_m(&place_m);
            assert!((room_m - 2.0).abs() < 0.3, "{room_m}");
            let reached = space.reached(&place_m, 0.3, 1.5 * 3.0 * room_m);
            for radii in RADII {
                let ways = space.ways(&place_m, radii * room_m, [-90.0, 90.0], &reached);
                assert_eq!(ways.len(), wanted);
                assert!(ways.iter().all(|way| way.direction.x.abs() > 0.99 && (way.clearance_m - 4.0).abs() < 0.5));
            }
        }
    }
}
