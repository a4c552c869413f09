//! Edges of the visible free space that the vehicle can pass.
//!
//! Going around the sensor anticlockwise, every two returns p, q of walls that follow each other bound an edge. It is
//! an opening when
//!
//! 1. ‖p - q‖ is at least the vehicle's width,
//! 2. it is not merely a sparse stretch of one wall, whose returns at grazing incidence are metres apart but all on one
//!    line: either the two belong to different walls and beams between them came back with nothing
//!    ([`Evidence::NoReturn`]), or neither wall goes on along its own line across the edge: the nearer end clears the
//!    line of the farther wall by the vehicle's width, and the farther end leaves the line of the nearer wall by half
//!    of it. An edge that is seen over half a turn or more, most of it with nothing in it, is none such a stretch: the
//!    line of a wall would pass on the other side of the sensor;
//! 3. a strip of the vehicle's width that leaves the edge outward meets no return for [`DEPTH_M`];
//! 4. some beam between them is known: a masked sector is no opening, nor is what lies outside the view
//!    ([`Sweep::view`](crosscut_stage::Sweep::view)).
//!
//! Edges that lead into the same branch (a stray return deep inside it splits its edge in two) are one opening.
//!
//! That is [`OpeningRule::FreeSpace`], for walls of any origin. Where walls end at openings and nowhere else,
//! [`OpeningRule::BetweenWalls`] takes every edge between two different walls, so that walls and openings agree. One
//! wall all around has at most one opening by that rule, of those in free space:
//! - one in no shadow of a pillar, if there is one; in such a shadow the wall may turn a corner, so the walls there
//!   leave each other's line by [`SHADED_TIMES`] times the vehicle's width, or the dark part is as wide as the vehicle;
//! - of those, the one with the widest stretch of beams that came back with nothing;
//! - of equal ones, the widest;
//! - if there is none, a gap in the line of the wall that could be a doorway, as nothing is seen in it although no other
//!   beams get lost: the vehicle came in somewhere.
//!
//! By either rule no opening is narrower than the vehicle.
//!
//! A limited view may end in the middle of an opening. Where beams came back with nothing all the way from the last
//! return of a wall to the end of the view (single other beams apart), and leave room for the vehicle beside that
//! return, there is a way on of which a part is seen ([`Opening::cut_by_view`]).
//!
//! Bearing and width are those of the branch behind the edge, [`LOOKOUT_M`] from the sensor or where its centreline is
//! last seen, if that is nearer. Walls are lines from return to return. With N the wall whose end is nearer to the
//! sensor, F the other, d_F(x) the distance of x from F, and n (f) the place where N (F), followed from its end, comes
//! within 8 m:
//! ```text
//! width = min(d_F(n), d_N(f))
//! bearing of x, the first on the beam through n from n to the circle of 8 m, then on the circle towards F,
//!         with d_F(x) = width / 2
//! ```
//! The beam through n is where sight into the branch ends if N turns a corner there: there the centreline is last seen.
//!
//! A way into a room behind a doorway, between walls, is no wider than the doorway: at most [`DOORWAY_TIMES`] the
//! vehicle's width from the end of the nearer wall to the next wall beyond the farther one, with that one behind.
//!
//! Behind an edge more than 8 m away, walls may lead around a chamber instead of along a branch. Where n and f lie on
//! the other side of the sensor, or farther from each other than [`WIDENS`] times the width of the edge, the ends of
//! the edge take their place. If the line across the branch does not lie ahead, the edge replaces it. If x does not lie
//! ahead, the bearing is that of the middle of the edge. Bearing and width of a branch that the end of the view cuts
//! are those of the part in view.

mod doorway;
mod edge;
mod sides;

use std::cmp::Ordering;

use crosscut_scan::Position;
use crosscut_stage::{Beam, Evidence, Opening, Point, Revolution};

pub(crate) use self::doorway::doorway;
pub(crate) use self::edge::{clearance_m, depth_m};
use self::sides::Side;
pub(crate) use self::sides::Sides;
use crate::outline::Outline;

/// The free space beyond an opening is at least this deep, or not seen to be shallower.
pub const DEPTH_M: f64 = 3.0;

/// An opening's bearing and width are taken at most this far from the sensor.
pub const LOOKOUT_M: f64 = 8.0;

/// In the shadow of a pillar, one wall all around leads on if the walls leave each other's line by this many times the
/// vehicle's width: it may turn a corner there, or have a step.
pub const SHADED_TIMES: f64 = 3.0;

/// A doorway is at most this many times as wide as the vehicle.
pub const DOORWAY_TIMES: f64 = 4.0;

/// Walls this many times farther from each other than at the edge are no longer those of the branch.
pub const WIDENS: f64 = 2.5;

/// Which edges are openings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OpeningRule {
    /// Those through which the vehicle fits into free space.
    #[default]
    FreeSpace,
    /// Those between two walls.
    BetweenWalls,
}

/// Writes the openings between the walls of `outline`, which is filled from `revolution`, by bearing ascending.
pub fn find(
    rule: OpeningRule,
    revolution: &Revolution,
    outline: &Outline,
    vehicle_width_m: f64,
    out: &mut Vec<Opening>,
) {
    let outlook = Outlook { revolution, vehicle_width_m, outline };
    let is_one_wall = outline.walls().windows(2).all(|pair| pair[0] == pair[1]);
    let branches = match rule {
        OpeningRule::FreeSpace => outlook.in_free_space(1.0),
        OpeningRule::BetweenWalls if !is_one_wall => outlook.between_walls(),
        OpeningRule::BetweenWalls if outline.ring.full_turn => {
            let plainest = plainest(outlook.in_free_space(SHADED_TIMES), vehicle_width_m);
            if plainest.is_empty() { outlook.doorway() } else { plainest }
        }
        OpeningRule::BetweenWalls => Vec::new(),
    };
    out.clear();
    out.extend(branches.into_iter().map(|branch| branch.opening));
    if !outline.ring.full_turn {
        out.extend(outlook.cut_by_its_ends());
    }
    out.retain(|opening| opening.width_m >= vehicle_width_m);
    out.sort_by(|a, b| a.bearing_rad.total_cmp(&b.bearing_rad));
}

/// The sides of every two neighbouring returns that are of two walls, or at least this far from each other.
pub(crate) fn sides(outline: &Outline, least_m: f64) -> impl Iterator<Item = Sides<'_>> {
    let is_edge = move |&[from, to]: &[usize; 2]| {
        outline.wall(from) != outline.wall(to) || outline.ring.are_apart(from, to, least_m)
    };
    outline.pairs().filter(is_edge).map(|[from, to]| Sides::of(outline, from, to))
}

/// Whether the view goes all the way round, and something is known between any two walls.
pub(crate) fn sees_all(outline: &Outline) -> bool {
    let knows_all = || sides(outline, f64::INFINITY).all(|sides| sides.is_known());
    outline.ring.full_turn && (!outline.ring.beams.contains(&Beam::Unknown) || knows_all())
}

/// Of the branches that are wide enough, one in no shadow if there is one; of those, the one with the widest stretch of
/// beams that came back with nothing; of equal ones, the widest.
fn plainest(mut branches: Vec<Branch>, vehicle_width_m: f64) -> Vec<Branch> {
    let plain = |branch: &Branch| (!branch.is_shaded, branch.dark_m, branch.opening.width_m);
    branches.retain(|branch| branch.opening.width_m >= vehicle_width_m);
    let plainest = branches.into_iter().max_by(|a, b| plain(a).partial_cmp(&plain(b)).unwrap_or(Ordering::Equal));
    plainest.into_iter().collect()
}

/// An opening with the middle of its mouth.
struct Branch {
    opening: Opening,
    middle_m: Position,
    /// The width, at the nearer end of its edge, of the beams into it that came back with nothing.
    dark_m: f64,
    /// More than half of what is in its edge is hidden by pillars.
    is_shaded: bool,
}

impl Branch {
    /// Whether both lead into the same branch: their mouths overlap.
    fn is_same_way_as(&self, other: &Self) -> bool {
        let narrower_m = self.opening.width_m.min(other.opening.width_m);
        (self.middle_m - other.middle_m).norm() < narrower_m / 2.0
    }

    /// How far it is from the end of its edge to the start of that of the next branch anticlockwise.
    fn gap_to_m(&self, next: &Self) -> f64 {
        (next.opening.edge_m[0] - self.opening.edge_m[1]).norm()
    }

    /// Joins the next edge anticlockwise of the same branch. The mouth is that of the longer edge.
    fn join(&mut self, next: Self) {
        let (clockwise, anticlockwise) = (&self.opening, &next.opening);
        let walls = [clockwise.walls[0], anticlockwise.walls[1]];
        let edge_m = [clockwise.edge_m[0], anticlockwise.edge_m[1]];
        let (dark_m, is_shaded) = (self.dark_m + next.dark_m, self.is_shaded && next.is_shaded);
        let length_m = |opening: &Opening| (opening.edge_m[0] - opening.edge_m[1]).norm();
        if length_m(anticlockwise) > length_m(clockwise) {
            *self = next;
        }
        self.opening.walls = walls;
        self.opening.edge_m = edge_m;
        (self.dark_m, self.is_shaded) = (dark_m, is_shaded);
    }
}

/// One revolution, seen as the outline of its walls.
struct Outlook<'a> {
    revolution: &'a Revolution,
    vehicle_width_m: f64,
    outline: &'a Outline,
}

impl Outlook<'_> {
    /// Every edge between two walls that is not masked throughout.
    fn between_walls(&self) -> Vec<Branch> {
        sides(self.outline, self.vehicle_width_m)
            .filter(|sides| sides.are_two_walls() && sides.is_known())
            .map(|sides| {
                let mut branch = self.branch(&sides);
                let is_doorway = |m: &f64| (self.vehicle_width_m..=DOORWAY_TIMES * self.vehicle_width_m).contains(m);
                if let Some(doorway_m) = sides.doorway_m().filter(is_doorway) {
                    branch.opening.width_m = branch.opening.width_m.min(doorway_m);
                }
                branch
            })
            .collect()
    }

    /// Every edge that the vehicle can pass into free space, those into the same branch joined. An edge in the shadow
    /// of a pillar needs `shaded_times` the clearance of others.
    fn in_free_space(&self, shaded_times: f64) -> Vec<Branch> {
        let times = |sides: &Sides<'_>| {
            // Beams get lost at the edges of a pillar.
            let is_hidden = sides.is_shaded() && sides.dark_m() < self.vehicle_width_m;
            if is_hidden { shaded_times } else { 1.0 }
        };
        let edges = sides(self.outline, self.vehicle_width_m).filter(|sides| self.is_passable(sides, times(sides)));
        let mut branches: Vec<Branch> = edges.map(|sides| self.branch(&sides)).collect();
        // The nearest to each other are joined first, so that it does not matter where the outline begins.
        while let Some((at, next)) = self.nearest_into_same_way(&branches) {
            let joined = branches.remove(next);
            branches[if next < at { at - 1 } else { at }].join(joined);
        }
        branches
    }

    /// Of the neighbouring branches that are the same way, the two whose edges are nearest to each other.
    fn nearest_into_same_way(&self, branches: &[Branch]) -> Option<(usize, usize)> {
        let n = branches.len();
        let pairs = (0..n).map(|at| (at, (at + 1) % n));
        let is_same_way = |&(at, next): &(usize, usize)| {
            at != next && (self.outline.ring.full_turn || next != 0) && branches[at].is_same_way_as(&branches[next])
        };
        let apart = |(at, next): (usize, usize)| branches[at].gap_to_m(&branches[next]);
        pairs.filter(is_same_way).min_by(|&a, &b| apart(a).total_cmp(&apart(b)))
    }

    /// Whether the vehicle can pass, and the walls leave each other's line by `times` its width.
    fn is_passable(&self, sides: &Sides<'_>, times: f64) -> bool {
        let edge_m = sides.edge_m();
        if (edge_m[0] - edge_m[1]).norm() < self.vehicle_width_m || !sides.is_known() {
            return false;
        }
        // The strip behind so wide an edge would begin on the other side of the sensor.
        if sides.is_open_side() {
            return true;
        }
        let dark_between_two = sides.are_two_walls() && sides.is_dark();
        let returns_m = self.revolution.points_m.iter().map(|point| point.coords.xy());
        (dark_between_two || clearance_m(sides) >= times * self.vehicle_width_m)
            && depth_m(returns_m, edge_m, self.vehicle_width_m) >= DEPTH_M
    }

    /// The gap in the line of a wall that could be a doorway, if nothing is seen behind it either.
    fn doorway(&self) -> Vec<Branch> {
        let returns_m = || self.revolution.points_m.iter().map(|point| point.coords.xy());
        let is_deep = |sides: &Sides<'_>| depth_m(returns_m(), sides.edge_m(), self.vehicle_width_m) >= DEPTH_M;
        let doorway = doorway(self.outline, self.vehicle_width_m).filter(is_deep);
        doorway.map(|sides| self.branch(&sides)).into_iter().collect()
    }

    fn branch(&self, sides: &Sides<'_>) -> Branch {
        let (edge_m, towards) = (sides.edge_m(), sides.towards());
        let is_ahead = |[a, b]: [Position; 2]| (a + b).dot(&towards) > 0.0;
        let length_m = |[a, b]: [Position; 2]| (a - b).norm();
        let of_branch = |anchors_m: &_| is_ahead(*anchors_m) && length_m(*anchors_m) <= WIDENS * sides.width_m();
        let anchors_m = Some(sides.anchors_m()).filter(of_branch).unwrap_or(edge_m);
        let mouth_m = Some(sides.mouth_m(anchors_m)).filter(|mouth_m| is_ahead(*mouth_m)).unwrap_or(edge_m);
        let (middle_m, width_m) = (0.5 * (mouth_m[0] + mouth_m[1]), length_m(mouth_m));
        let lookout_m = sides.lookout_m(anchors_m, width_m).unwrap_or(middle_m);
        let opening = Opening {
            bearing_rad: bearing_rad(if is_ahead([lookout_m; 2]) { lookout_m } else { towards }),
            width_m,
            walls: sides.walls(),
            evidence: if sides.is_dark() { Evidence::NoReturn } else { Evidence::SeenThrough },
            edge_m: edge_m.map(point),
            p: None,
            cut_by_view: false,
        };
        Branch { opening, middle_m, dark_m: sides.dark_m(), is_shaded: sides.is_shaded() }
    }

    /// Ways on that an end of a limited view cuts.
    fn cut_by_its_ends(&self) -> Vec<Opening> {
        let Some(last) = self.outline.len().checked_sub(1) else { return Vec::new() };
        let before = Side { at: 0, clockwise: false };
        let after = Side { at: last, clockwise: true };
        [before, after].into_iter().filter_map(|side| self.cut_beside(side)).collect()
    }

    /// The way on between a wall and the end of the view.
    fn cut_beside(&self, side: Side) -> Option<Opening> {
        if self.outline.room_to_end_m(side.at, side.clockwise) < self.vehicle_width_m {
            return None;
        }
        let end = self.outline.ring.returns[side.at];
        let beams = if side.clockwise { self.outline.ring.beams.len() - 1 - end.beam } else { end.beam };
        let turn_rad = beams as f64 * self.outline.ring.step_rad;
        let towards_end = if side.clockwise { turn_rad } else { -turn_rad };
        let turned_m = |share: f64| nalgebra::Rotation2::new(share * towards_end) * end.position_m;
        let mut edge_m = [end.position_m, turned_m(1.0)];
        if !side.clockwise {
            edge_m.reverse();
        }
        Some(Opening {
            bearing_rad: bearing_rad(turned_m(0.5)),
            width_m: turned_m(1.0).normalize().perp(&side.anchor_m(self.outline)).abs(),
            walls: [self.outline.wall(side.at); 2],
            evidence: Evidence::NoReturn,
            edge_m: edge_m.map(point),
            p: None,
            cut_by_view: true,
        })
    }
}

fn bearing_rad(position_m: Position) -> f64 {
    position_m.y.atan2(position_m.x)
}

fn point(position_m: Position) -> Point {
    Point::new(position_m.x, position_m.y, 0.0)
}
