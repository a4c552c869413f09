//! How far the vehicle's ball gets straight on in each direction, and how much room there is.

use nalgebra::{Unit, Vector3};

use super::sight::{Seen, Sight};
use super::sphere::Sphere;

/// Of each cell: the distance that the centre of a ball of `radius_m` can go in its direction before it touches what is
/// seen, metres; infinite where nothing came back, and -1 where nothing is known.
///
/// A return p stops the ball in direction e where its distance from the ray is less than the radius r, at
/// p·e - √(r² - |p - (p·e) e|²).
pub(super) fn reach_m(sphere: &Sphere, sight: &Sight, radius_m: f64, out: &mut Vec<f64>) {
    out.clear();
    out.extend(sight.seen.iter().map(|seen| if *seen == Seen::Unknown { -1.0 } else { f64::INFINITY }));
    for (cell, seen) in sight.seen.iter().enumerate() {
        let Seen::Return(point_m) = seen else { continue };
        let range_m = point_m.norm();
        // Also beyond the ball's width, the cell itself ends at what it shows.
        out[cell] = out[cell].min(range_m - radius_m);
        sphere.near(&(point_m / range_m), (radius_m / range_m).min(1.0).asin(), |near| {
            let along_m = sphere.directions[near].dot(point_m);
            let aside_m2 = range_m * range_m - along_m * along_m;
            let stops_m = along_m - (radius_m * radius_m - aside_m2).max(0.0).sqrt();
            out[near] = out[near].min(stops_m);
        });
    }
    for (reach_m, seen) in out.iter_mut().zip(&sight.seen) {
        *reach_m = if *seen == Seen::Unknown { -1.0 } else { reach_m.max(0.0) };
    }
}

/// The distance of a place from the nearest thing that is seen, metres.
pub(super) fn clear_m(sight: &Sight, place_m: &Vector3<f64>) -> f64 {
    let squared_m2 = sight.seen.iter().map(|seen| match seen {
        Seen::Return(point_m) => (point_m - place_m).norm_squared(),
        _ => f64::INFINITY,
    });
    squared_m2.fold(f64::INFINITY, f64::min).sqrt()
}

/// The radius of the largest ball that holds the sensor and no return, and whose centre is in view and no farther aside than the
/// nearest return: near the ground the ball rises to the middle of the place, and does not roll along. The centre is no farther
/// away at all where nothing is seen beyond, or, in a level sweep, nothing above and below. `up` is the vertical axis.
pub(super) fn room_m(sphere: &Sphere, sight: &Sight, up: &Vector3<f64>) -> f64 {
    let here_m = clear_m(sight, &Vector3::zeros());
    if !here_m.is_finite() {
        return here_m;
    }
    let is_level = sphere.rings().len() == 1;
    let is_in_view = |place_m: &Vector3<f64>, range_m: f64| match sight.seen[sphere.cell(place_m, range_m)] {
        Seen::Return(point_m) if !is_level => range_m <= point_m.norm() && place_m.cross(up).norm() <= here_m,
        Seen::Unknown => false,
        _ => range_m <= here_m,
    };
    let (mut best_m, mut place_m, mut step_m) = (here_m, Vector3::zeros(), 0.5 * here_m);
    while step_m > 0.05 * here_m {
        let tried = MOVES.map(|[x, y, z]| {
            let moved_m = place_m + Unit::new_normalize(Vector3::new(x, y, z)).scale(step_m);
            let range_m = moved_m.norm();
            let inside = range_m == 0.0 || is_in_view(&moved_m, range_m);
            let room_m = if inside { clear_m(sight, &moved_m) } else { 0.0 };
            (if room_m >= range_m { room_m } else { 0.0 }, moved_m)
        });
        let Some((room_m, moved_m)) = tried.into_iter().max_by(|a, b| a.0.total_cmp(&b.0)) else { break };
        if room_m > best_m {
            // Far from the nearest return steps are longer, so that few reach the middle of any place.
            (best_m, place_m, step_m) = (room_m, moved_m, 2.0 * step_m);
        } else {
            step_m *= 0.5;
        }
    }
    best_m
}

/// Along the axes and between them.
const MOVES: [[f64; 3]; 14] = [
    [1.0, 0.0, 0.0],
    [-1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, -1.0, 0.0],
    [0.0, 0.0, 1.0],
    [0.0, 0.0, -1.0],
    [1.0, 1.0, 1.0],
    [1.0, 1.0, -1.0],
    [1.0, -1.0, 1.0],
    [1.0, -1.0, -1.0],
    [-1.0, 1.0, 1.0],
    [-1.0, 1.0, -1.0],
    [-1.0, -1.0, 1.0],
    [-1.0, -1.0, -1.0],
];
