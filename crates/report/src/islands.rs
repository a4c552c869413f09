//! Walls that stand free in front of others: pillars.

use crosscut_stage::{Beam, Junction, Point, Revolution, Sweep};

/// What is seen past either end of an island lies at least this much farther.
const BEHIND_M: f64 = 0.5;

/// Sets `island` of the walls that are shorter than `island_m` and on both sides of which the next wall, going around
/// the sensor, is farther away. Nearest first: one that is partly hidden by another is judged by what is beside both.
/// Without beams nothing is in front of anything.
pub fn mark(revolution: &Revolution, island_m: f64, out: &mut Junction) {
    let Some(sweep) = &revolution.sweep else { return };
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
        if others > 1 && stands_free(revolution, sweep, out, id) {
            out.walls[id as usize].island = true;
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

fn stands_free(revolution: &Revolution, sweep: &Sweep, out: &Junction, id: u32) -> bool {
    let mut ring: Vec<(usize, u32)> = Vec::new();
    for beam in &sweep.beams {
        if let Beam::Return(i) = *beam
            && let Some(wall) = out.wall_of_return[i as usize]
            && !out.walls[wall as usize].island
        {
            ring.push((i as usize, wall));
        }
    }
    let edges = if sweep.full_turn { ring.len() } else { ring.len().saturating_sub(1) };
    let at_an_end = |(_, wall): &(usize, u32)| *wall == id;
    if !sweep.full_turn && (ring.first().is_some_and(at_an_end) || ring.last().is_some_and(at_an_end)) {
        return false;
    }
    (0..edges).all(|at| {
        let ((i, wall_i), (j, wall_j)) = (ring[at], ring[(at + 1) % ring.len()]);
        let (inner, outer) = match (wall_i == id, wall_j == id) {
            (true, false) => (i, j),
            (false, true) => (j, i),
            _ => return true,
        };
        revolution.range_m(outer) > revolution.range_m(inner) + BEHIND_M
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crosscut_stage::Wall;

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
