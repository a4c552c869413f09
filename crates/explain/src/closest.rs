//! The closest returns of two different walls.

use crosscut_stage::Frame;

/// Scans with more returns are not searched, because the search is O(n²).
const MOST_RETURNS: usize = 2048;

/// The two closest returns of different walls, after their walls.
pub(crate) fn pair(frame: &Frame) -> Option<([u32; 2], [usize; 2])> {
    let (points, wall_of) = (&frame.revolution.points_m, &frame.junction.wall_of_return);
    if points.len() > MOST_RETURNS {
        return None;
    }
    let mut closest: Option<(f64, [u32; 2], [usize; 2])> = None;
    for (j, wall_j) in wall_of.iter().enumerate() {
        for (i, wall_i) in wall_of[..j].iter().enumerate() {
            if let (Some(a), Some(b)) = (*wall_i, *wall_j)
                && a != b
            {
                let squared = (points[i] - points[j]).norm_squared();
                if closest.is_none_or(|(least, ..)| squared < least) {
                    closest = Some((squared, [a, b], [i, j]));
                }
            }
        }
    }
    closest.map(|(_, walls, returns)| (walls, returns))
}
