//! Walls that stand free in front of others: pillars.

use crosscut_stage::{Junction, Point, Revolution};

use crate::ring::{Entry, Ring};

/// What is seen past either end of an island lies at least this much farther.
const BEHIND_M: f64 = 0.5;

/// Sets `island` of the walls that are shorter than `island_m` and on both sides of which the next wall, going around
/// the sensor, is farther away. Nearest first: one that is partly hidden by another is judged by what is beside both.
/// Without beams nothing is in front of anything.
pub fn mark(revolution: &Revolution, island_m: f64, out: &mut Junction) {
    let Some(sweep) = &revolution.sweep else { return };
    let mut ring = Ring::default();
    ring.fill(revolution, sweep, &out.wall_of_return);
    let mut candidates: Vec<(f64, u32)> = Vec::new();
    for wall in &out.walls {
        let (nearest_m, length_m) = extent_m(revolution, &out.wall_of_return, wall.id);
        if length_m < island_m {
            candidates.push((nearest_m, wall.id));
        }
    }
    candidates.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (_, id) in candidates {
        let others = out.walls.iter().filter(|wall| !wall.island).count();
        if others > 1 && stands_free(&ring, id) {
            out.walls[id as usize].island = true;
            ring.entries.retain(|entry| entry.wall != id);
        }
    }
}

/// Range of the nearest return of a wall, and the largest distance of one of its returns from the first.
fn extent_m(revolution: &Revolution, wall_of_return: &[Option<u32>], id: u32) -> (f64, f64) {
    let mut first: Option<Point> = None;
    let (mut nearest_m, mut length_m) = (f64::INFINITY, 0.0f64);
    for (i, _) in wall_of_return.iter().enumerate().filter(|(_, wall)| **wall == Some(id)) {
        let point = revolution.points_m[i];
        let first = *first.get_or_insert(point);
        nearest_m = nearest_m.min(revolution.range_m(i));
        length_m = length_m.max((point - first).norm());
    }
    (nearest_m, length_m)
}

fn stands_free(ring: &Ring, id: u32) -> bool {
    let n = ring.len();
    let at_an_end = |entry: Option<&Entry>| !ring.full_turn && entry.is_some_and(|entry| entry.wall == id);
    if at_an_end(ring.entries.first()) || at_an_end(ring.entries.last()) {
        return false;
    }
    (0..ring.edges()).all(|at| {
        let [a, b] = [ring.entries[at], ring.entries[(at + 1) % n]];
        let (inner, outer) = match (a.wall == id, b.wall == id) {
            (true, false) => (a, b),
            (false, true) => (b, a),
            _ => return true,
        };
        outer.range_m > inner.range_m + BEHIND_M
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crosscut_stage::{Beam, Sweep, Wall};

    /// Eight beams all around, one wall label for each.
    fn marked(ranges_m: [f64; 8], labels: [u32; 8], island_m: f64) -> Vec<bool> {
        let bearings_rad: Vec<f64> = (0..8).map(|beam| f64::from(beam) * std::f64::consts::FRAC_PI_4).collect();
        let points = ranges_m.iter().zip(&bearings_rad).map(|(r, b)| Point::new(r * b.cos(), r * b.sin(), 0.0));
        let revolution = Revolution {
            points_m: points.collect(),
            sweep: Some(Sweep {
                beams: (0..8).map(Beam::Return).collect(),
                step_rad: std::f64::consts::FRAC_PI_4,
                full_turn: true,
                bearings_rad,
                ..Sweep::default()
            }),
            ..Revolution::default()
        };
        let walls = 1 + *labels.iter().max().expect("eight");
        let wall = |id| Wall { id, returns: 1, bearing_rad: [0.0; 2], island: false };
        let mut junction = Junction {
            walls: (0..walls).map(wall).collect(),
            wall_of_return: labels.map(Some).to_vec(),
            ..Junction::default()
        };
        mark(&revolution, island_m, &mut junction);
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
        assert_eq!(marked([5.0, 5.0, 2.0, 2.2, 5.0, 5.0, 5.0, 5.0], labels, 2.0), [false, false, false]);
        assert_eq!(marked([5.0, 5.0, 1.0, 2.2, 5.0, 5.0, 5.0, 5.0], labels, 2.0), [false, true, true]);
    }
}
