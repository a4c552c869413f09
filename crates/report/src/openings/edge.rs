//! Whether the vehicle can pass between two returns into free space, and how nearly.

use crosscut_scan::Position;

use super::sides::{Side, Sides};
use crate::outline::Outline;

/// The line of a wall behind its end is taken over this stretch.
const LINE_M: f64 = 1.5;

/// How far the walls leave each other's line at the edge: a wall that goes on leaves none. The distance of the nearer
/// end from the line of the farther wall, or twice that of the farther end from the line of the nearer wall, if that is
/// less.
pub(crate) fn clearance_m(sides: &Sides<'_>) -> f64 {
    let [near, far] = sides.by_range();
    let end_m = |side: Side| sides.outline.position_m(side.at);
    let of_far_m = distance_from_line_m(sides.outline, far, end_m(near));
    let of_near_m = distance_from_line_m(sides.outline, near, end_m(far));
    of_far_m.min(2.0 * of_near_m)
}

/// Distance of a point from the line of the wall on one side; 0 where the wall has no direction.
fn distance_from_line_m(outline: &Outline, side: Side, point_m: Position) -> f64 {
    let end_m = outline.position_m(side.at);
    let along = end_m - stretch_start_m(outline, side);
    let across_m = along.perp(&(point_m - end_m)).abs() / along.norm();
    if across_m.is_nan() { 0.0 } else { across_m }
}

/// The return of the same wall about [`LINE_M`] before its end.
fn stretch_start_m(outline: &Outline, side: Side) -> Position {
    let end_m = outline.position_m(side.at);
    let mut start_m = end_m;
    for one in side.along(outline) {
        start_m = one.position_m;
        if (start_m - end_m).norm_squared() >= LINE_M * LINE_M {
            break;
        }
    }
    start_m
}

/// How far a strip of this width leaves the edge outward before it meets one of the returns; infinite if it meets none.
pub(crate) fn depth_m(returns_m: impl Iterator<Item = Position>, edge_m: [Position; 2], strip_width_m: f64) -> f64 {
    let middle_m = 0.5 * (edge_m[0] + edge_m[1]);
    let along = (edge_m[1] - edge_m[0]).normalize();
    // The edge runs anticlockwise around the sensor, so its right-hand normal points outward.
    let outward = Position::new(along.y, -along.x);
    let ahead_m = returns_m.map(|return_m| return_m - middle_m).filter(|ahead_m| {
        // The ends of the edge itself may lie ahead by a rounding error.
        ahead_m.dot(&outward) > 0.0 && ahead_m.dot(&along).abs() < strip_width_m / 2.0
    });
    ahead_m.map(|ahead_m| ahead_m.dot(&outward)).fold(f64::INFINITY, f64::min)
}
