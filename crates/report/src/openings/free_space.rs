//! Openings by the visible free space, for affinities that decide nothing at gaps.

use crosscut_scan::Position;
use crosscut_stage::{DEPTH_M, Opening, Revolution};

use super::FreeEdge;
use crate::wall_ring::WallRing;

/// An opening, and the middle of its mouth.
type Mouth = (Opening, Position);

/// Every edge that the vehicle can pass into free space, those into the same branch joined.
pub(super) fn search(revolution: &Revolution, outline: &WallRing, vehicle_width_m: f64) -> Vec<Opening> {
    let edges = FreeEdge::all(outline, vehicle_width_m).filter(|edge| is_passable(edge, revolution, vehicle_width_m));
    let mut mouths: Vec<Mouth> = edges.map(|edge| edge.opening()).collect();
    // The nearest to each other are joined first, so that it does not matter where the outline begins.
    while let Some((at, next)) = nearest_into_one_branch(&mouths, outline.ring.full_turn) {
        let joined = mouths.remove(next);
        join(&mut mouths[if next < at { at - 1 } else { at }], joined);
    }
    mouths.into_iter().map(|(opening, _)| opening).collect()
}

/// Whether the vehicle can pass, and the walls leave each other's line by its width.
fn is_passable(edge: &FreeEdge<'_>, revolution: &Revolution, vehicle_width_m: f64) -> bool {
    let [from_m, to_m] = edge.ends_m();
    if (from_m - to_m).norm() < vehicle_width_m || !edge.is_known() {
        return false;
    }
    // The strip behind so wide an edge would begin on the other side of the sensor.
    if edge.is_open_side() {
        return true;
    }
    let dark_between_two = edge.is_between_walls() && edge.is_dark();
    let returns_m = revolution.points_m.iter().map(|point| point.coords.xy());
    (dark_between_two || edge.clearance_m() >= vehicle_width_m) && edge.depth_m(returns_m, vehicle_width_m) >= DEPTH_M
}

/// Of the neighbouring mouths of one branch, the two whose edges are nearest to each other.
fn nearest_into_one_branch(mouths: &[Mouth], full_turn: bool) -> Option<(usize, usize)> {
    let n = mouths.len();
    let pairs = (0..n).map(|at| (at, (at + 1) % n));
    let is_one_branch =
        |&(at, next): &(usize, usize)| at != next && (full_turn || next != 0) && overlap(&mouths[at], &mouths[next]);
    let apart_m = |(at, next): (usize, usize)| (mouths[next].0.edge_m[0] - mouths[at].0.edge_m[1]).norm();
    pairs.filter(is_one_branch).min_by(|&a, &b| apart_m(a).total_cmp(&apart_m(b)))
}

/// Whether two mouths overlap, so that both are of one branch.
fn overlap((one, one_m): &Mouth, (other, other_m): &Mouth) -> bool {
    (one_m - other_m).norm() < one.width_m.min(other.width_m) / 2.0
}

/// Joins the next edge anticlockwise of the same branch. The longer edge gives the mouth.
fn join(mouth: &mut Mouth, next: Mouth) {
    let (clockwise, anticlockwise) = (&mouth.0, &next.0);
    let walls = [clockwise.walls[0], anticlockwise.walls[1]];
    let returns = [clockwise.returns[0], anticlockwise.returns[1]];
    let edge_m = [clockwise.edge_m[0], anticlockwise.edge_m[1]];
    let length_m = |opening: &Opening| (opening.edge_m[0] - opening.edge_m[1]).norm();
    if length_m(anticlockwise) > length_m(clockwise) {
        *mouth = next;
    }
    (mouth.0.walls, mouth.0.returns, mouth.0.edge_m) = (walls, returns, edge_m);
}
