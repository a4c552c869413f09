//! Whether the vehicle can pass between two returns into free space.

use super::DEPTH_M;
use super::sides::{Side, Sides};
use crate::ring::{Position, Ring};

/// The line of a wall behind its end is taken over this stretch.
const LINE_M: f64 = 1.5;

/// Whether neither wall goes on along its own line across the edge, so that the vehicle can pass between them: the
/// nearer end clears the line of the farther wall by the vehicle's width, and the farther end leaves the line of the
/// nearer wall by half of it.
pub(super) fn leaves_the_line(sides: &Sides<'_>, vehicle_width_m: f64) -> bool {
    let [near, far] = sides.by_range();
    let end_m = |side: Side| sides.ring.entries[side.at].position_m;
    distance_from_line_m(sides.ring, far, end_m(near)) >= vehicle_width_m
        && distance_from_line_m(sides.ring, near, end_m(far)) >= vehicle_width_m / 2.0
}

/// Distance of a point from the line of the wall on one side; 0 where the wall has no direction.
fn distance_from_line_m(ring: &Ring, side: Side, point_m: Position) -> f64 {
    let end_m = ring.entries[side.at].position_m;
    let along = end_m - stretch_start_m(ring, side);
    let across_m = along.perp(&(point_m - end_m)).abs() / along.norm();
    if across_m.is_nan() { 0.0 } else { across_m }
}

/// The return of the same wall about [`LINE_M`] before its end.
fn stretch_start_m(ring: &Ring, side: Side) -> Position {
    let end_m = ring.entries[side.at].position_m;
    let mut start_m = end_m;
    for at in side.along(ring) {
        start_m = ring.entries[at].position_m;
        if (start_m - end_m).norm() >= LINE_M {
            break;
        }
    }
    start_m
}

/// Whether a strip of the vehicle's width that leaves the edge outward meets none of the returns for [`DEPTH_M`].
pub(super) fn is_deep(
    mut returns_m: impl Iterator<Item = Position>,
    edge_m: [Position; 2],
    vehicle_width_m: f64,
) -> bool {
    let middle_m = 0.5 * (edge_m[0] + edge_m[1]);
    let along = (edge_m[1] - edge_m[0]).normalize();
    // The edge runs anticlockwise around the sensor, so its right-hand normal points outward.
    let outward = Position::new(along.y, -along.x);
    !returns_m.any(|return_m| {
        let ahead_m = return_m - middle_m;
        (0.0..DEPTH_M).contains(&ahead_m.dot(&outward)) && ahead_m.dot(&along).abs() < vehicle_width_m / 2.0
    })
}
