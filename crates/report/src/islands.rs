//! Walls that stand free in front of others: pillars.

use crosscut_stage::{Junction, Point, Revolution, Wall};

use crate::ring::{Entry, Ring};

/// What is seen past either end of an island lies at least this much farther.
const BEHIND_M: f64 = 0.5;

/// Sets `island` of the walls of `out` that are shorter than `island_m` and on both sides of which the next wall, going
/// around the sensor, is farther away, and takes them out of `ring`. Nearest first: one that is partly hidden by another
/// is judged by what is beside both. Two beside each other, neither of them farther, stand free together.
pub fn mark(revolution: &Revolution, island_m: f64, ring: &mut Ring, out: &mut Junction) {
    let length_m = lengths_m(revolution, out);
    let short = |wall: &&Wall| length_m[wall.id as usize] < island_m;
    let nearest_m = |wall: &Wall| nearest_m(revolution, &out.wall_of_return, wall.id);
    let mut candidates: Vec<(f64, u32)> =
        out.walls.iter().filter(short).map(|wall| (nearest_m(wall), wall.id)).collect();
    candidates.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut candidates: Vec<u32> = candidates.into_iter().map(|(_, id)| id).collect();
    let mut others = out.walls.len();
    while let Some(free) = first_free(ring, &candidates).filter(|free| free.len() < others) {
        others -= free.len();
        for id in free {
            out.walls[id as usize].island = true;
            ring.remove(id);
            candidates.retain(|&other| other != id);
        }
    }
}

/// The first of the walls that stands free; if there is none, the first two that do together.
fn first_free(ring: &Ring, walls: &[u32]) -> Option<Vec<u32>> {
    let alone = walls.iter().map(|&id| vec![id]);
    let pairs = (1..walls.len()).flat_map(|b| (0..b).map(move |a| vec![walls[a], walls[b]]));
    alone.chain(pairs).find(|free| stand_free(ring, free))
}

/// The largest distance of a return of each wall from its first.
fn lengths_m(revolution: &Revolution, out: &Junction) -> Vec<f64> {
    let mut first: Vec<Option<Point>> = vec![None; out.walls.len()];
    let mut squared = vec![0.0f64; out.walls.len()];
    for (point, wall) in revolution.points_m.iter().zip(&out.wall_of_return) {
        let Some(wall) = wall.map(|id| id as usize) else { continue };
        let first = *first[wall].get_or_insert(*point);
        squared[wall] = squared[wall].max((point - first).norm_squared());
    }
    squared.iter_mut().for_each(|squared| *squared = squared.sqrt());
    squared
}

/// Range of the nearest return of a wall.
fn nearest_m(revolution: &Revolution, wall_of_return: &[Option<u32>], id: u32) -> f64 {
    let of_wall = (0..wall_of_return.len()).filter(|&i| wall_of_return[i] == Some(id));
    of_wall.map(|i| revolution.range_m(i)).fold(f64::INFINITY, f64::min)
}

fn stand_free(ring: &Ring, walls: &[u32]) -> bool {
    let is_one = |entry: &Entry| walls.contains(&entry.wall);
    if !ring.full_turn && (ring.entries.first().is_some_and(is_one) || ring.entries.last().is_some_and(is_one)) {
        return false;
    }
    (0..ring.edges()).all(|at| {
        let [a, b] = [ring.entries[at], ring.entries[ring.after(at)]];
        let (inner, outer) = match (is_one(&a), is_one(&b)) {
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
    use crosscut_stage::{Beam, Sweep};

    /// Eight beams all around, one wall label for each.
    fn marked(ranges_m: [f64; 8], labels: [u32; 8], island_m: f64) -> Vec<bool> {
        let bearings_rad: Vec<f64> = (0..8).map(|beam| f64::from(beam) * std::f64::consts::FRAC_PI_4).collect();
        let points = ranges_m.iter().zip(&bearings_rad).map(|(r, b)| Point::new(r * b.cos(), r * b.sin(), 0.0));
        let revolution = Revolution { points_m: points.collect(), ..Revolution::default() };
        let sweep = Sweep {
            beams: (0..8).map(Beam::Return).collect(),
            step_rad: std::f64::consts::FRAC_PI_4,
            full_turn: true,
            bearings_rad,
            ..Sweep::default()
        };
        let walls = 1 + *labels.iter().max().expect("eight");
        let wall = |id| Wall { id, returns: 1, bearing_rad: [0.0; 2], island: false };
        let mut junction = Junction {
            walls: (0..walls).map(wall).collect(),
            wall_of_return: labels.map(Some).to_vec(),
            ..Junction::default()
        };
        let mut ring = Ring::default();
        ring.fill(&revolution, &sweep, &junction.wall_of_return);
        mark(&revolution, island_m, &mut ring, &mut junction);
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
}
