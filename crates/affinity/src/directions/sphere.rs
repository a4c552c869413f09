//! The sphere of directions, in cells of nearly one size.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::ops::Range;

use nalgebra::{Unit, Vector3};

/// Steps of the table of heights, from 0 to 1.
const HEIGHTS: f64 = 2048.0;

/// Rings of cells around the vertical axis. All cells are as high as the rings, and about as wide.
#[derive(Clone, Debug, Default)]
pub(super) struct Sphere {
    /// Of each ring, from the lowest up: its cells.
    rings: Vec<Range<usize>>,
    /// Height of a ring.
    step_rad: f64,
    /// Elevation at which the lowest ring begins.
    lowest_rad: f64,
    /// The sine of the elevation at which each ring ends.
    ends: Vec<f64>,
    /// Of heights on the unit sphere, in equal steps from -1 to 1: the ring there.
    of_height: Vec<u16>,
    /// Of each cell: the direction of its middle.
    pub(super) directions: Vec<Unit<Vector3<f64>>>,
    /// Of each cell: those that it touches, also at a corner, ascending.
    pub(super) neighbours: Vec<Vec<u32>>,
}

impl Sphere {
    /// The whole sphere in about `cells` cells.
    pub(super) fn of(cells: usize) -> Self {
        let rings = (PI / (4.0 * PI / cells as f64).sqrt()).round().max(3.0);
        Self::of_rings(rings as usize, PI / rings, -FRAC_PI_2, |elevation_rad, step_rad| {
            (TAU * elevation_rad.cos() / step_rad).round().max(3.0) as usize
        })
    }

    /// The horizon alone, in one ring.
    pub(super) fn level(cells: usize) -> Self {
        let step_rad = TAU / cells as f64;
        Self::of_rings(1, step_rad, -0.5 * step_rad, |_, _| cells)
    }

    fn of_rings(rings: usize, step_rad: f64, lowest_rad: f64, cells: impl Fn(f64, f64) -> usize) -> Self {
        let mut sphere = Self { step_rad, lowest_rad, ..Self::default() };
        for ring in 0..rings {
            let elevation_rad = lowest_rad + (ring as f64 + 0.5) * step_rad;
            let (first, count) = (sphere.directions.len(), cells(elevation_rad, step_rad));
            sphere.rings.push(first..first + count);
            let bearings_rad = (0..count).map(|column| (column as f64 + 0.5) / count as f64 * TAU - PI);
            sphere.directions.extend(bearings_rad.map(|bearing_rad| direction(bearing_rad, elevation_rad)));
        }
        sphere.ends = (1..=rings).map(|ring| (lowest_rad + ring as f64 * step_rad).sin()).collect();
        let ring_at = |height: f64| sphere.ends.partition_point(|end| *end <= height).min(rings - 1) as u16;
        sphere.of_height = (0..=2 * HEIGHTS as usize).map(|at| ring_at(at as f64 / HEIGHTS - 1.0)).collect();
        sphere.neighbours = (0..sphere.directions.len()).map(|cell| sphere.around(cell)).collect();
        sphere
    }

    /// Number of cells.
    pub(super) fn len(&self) -> usize {
        self.directions.len()
    }

    /// The rings, from the lowest up: the cells of each, anticlockwise from -π.
    pub(super) fn rings(&self) -> &[Range<usize>] {
        &self.rings
    }

    /// From a cell's middle to the next.
    pub(super) fn step_rad(&self) -> f64 {
        self.step_rad
    }

    /// Where a ring begins and another one ends, radians; 0 of the horizon alone.
    pub(super) fn elevations_rad(&self, first: usize, last: usize) -> [f64; 2] {
        if self.rings.len() == 1 {
            return [0.0; 2];
        }
        [first, last + 1].map(|ring| (self.lowest_rad + ring as f64 * self.step_rad).clamp(-FRAC_PI_2, FRAC_PI_2))
    }

    /// The cell in which a point lies that is `range_m` from the sensor.
    pub(super) fn cell(&self, point_m: &Vector3<f64>, range_m: f64) -> usize {
        // A table in place of an arc sine for each point.
        let height = (point_m.z / range_m).clamp(-1.0, 1.0);
        let mut ring = usize::from(self.of_height[((height + 1.0) * HEIGHTS) as usize]);
        while height >= self.ends[ring] && ring + 1 < self.rings.len() {
            ring += 1;
        }
        let ring = &self.rings[ring];
        let turn = point_m.y.atan2(point_m.x) / TAU + 0.5;
        ring.start + ((turn * ring.len() as f64) as usize).min(ring.len() - 1)
    }

    /// Calls `each` for every cell whose middle is no farther than `reach_rad` from a direction.
    pub(super) fn near(&self, towards: &Vector3<f64>, reach_rad: f64, mut each: impl FnMut(usize)) {
        let elevation_rad = towards.z.clamp(-1.0, 1.0).asin();
        let turn = towards.y.atan2(towards.x) / TAU + 0.5;
        let least_cos = reach_rad.min(PI).cos();
        let ring_of = |rad: f64| ((rad - self.lowest_rad) / self.step_rad - 0.5).clamp(0.0, self.rings.len() as f64);
        let rings = ring_of(elevation_rad - reach_rad).ceil() as usize..=ring_of(elevation_rad + reach_rad) as usize;
        for ring in self.rings.get(*rings.start()..(rings.end() + 1).min(self.rings.len())).unwrap_or_default() {
            let cos = self.directions[ring.start].z.mul_add(-self.directions[ring.start].z, 1.0).max(0.0).sqrt();
            // Half the width of the cap along this ring is no more, by the haversine.
            let cos_of_both = cos * towards.z.mul_add(-towards.z, 1.0).max(0.0).sqrt();
            let half_turn = ((reach_rad.min(PI) / 2.0).sin() / cos_of_both.sqrt()).min(1.0).asin() / PI;
            let count = ring.len() as f64;
            let columns = if half_turn >= 0.5 {
                0..ring.len() as isize
            } else {
                ((turn - half_turn) * count - 0.5).ceil() as isize..((turn + half_turn) * count - 0.5) as isize + 1
            };
            for column in columns.take(ring.len()) {
                let cell = ring.start + column.rem_euclid(ring.len() as isize) as usize;
                if self.directions[cell].dot(towards) >= least_cos {
                    each(cell);
                }
            }
        }
    }

    fn around(&self, cell: usize) -> Vec<u32> {
        let Some(at) = self.rings.iter().position(|ring| ring.contains(&cell)) else { return Vec::new() };
        let column = cell - self.rings[at].start;
        let of_turn = |column: f64| column / self.rings[at].len() as f64;
        let mut found = Vec::new();
        for ring in &self.rings[at.saturating_sub(1)..(at + 2).min(self.rings.len())] {
            // Of the rings above and below, the cells that share a stretch of an edge or a corner.
            let count = ring.len() as f64;
            let slack = if ring.contains(&cell) { 1e-6 } else { -1e-6 };
            let from = (of_turn(column as f64) * count - slack).floor() as isize;
            let to = (of_turn(column as f64 + 1.0) * count + slack).ceil() as isize;
            found
                .extend((from..to).map(|column| (ring.start + column.rem_euclid(ring.len() as isize) as usize) as u32));
        }
        found.sort_unstable();
        found.dedup();
        found.retain(|&other| other as usize != cell);
        found
    }
}

/// The unit vector of a bearing and an elevation.
fn direction(bearing_rad: f64, elevation_rad: f64) -> Unit<Vector3<f64>> {
    let (up, out) = elevation_rad.sin_cos();
    Unit::new_unchecked(Vector3::new(out * bearing_rad.cos(), out * bearing_rad.sin(), up))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_direction_is_in_the_cell_nearest_to_it_or_one_beside() {
        for sphere in [Sphere::of(300), Sphere::of(2000), Sphere::level(360)] {
            for cell in 0..sphere.len() {
                assert_eq!(sphere.cell(&(sphere.directions[cell].scale(7.0)), 7.0), cell);
                assert!(!sphere.neighbours[cell].is_empty() && sphere.neighbours[cell].len() <= 14);
                for &other in &sphere.neighbours[cell] {
                    assert!(sphere.neighbours[other as usize].contains(&(cell as u32)), "{cell} and {other}");
                }
            }
        }
    }

    #[test]
    fn the_cells_of_a_cap_are_those_within_its_angle() {
        let sphere = Sphere::of(1000);
        for towards in sphere.directions.iter().step_by(37) {
            for reach_rad in [0.01, 0.1, 0.5, 1.2, 3.2] {
                let mut found = Vec::new();
                sphere.near(towards, reach_rad, |cell| found.push(cell));
                found.sort_unstable();
                let within = |cell: &usize| sphere.directions[*cell].dot(towards) >= f64::cos(reach_rad.min(PI));
                assert_eq!(found, (0..sphere.len()).filter(within).collect::<Vec<_>>(), "{towards:?} {reach_rad}");
            }
        }
    }
}
