//! The two walls beside an opening: how wide the branch between them is, and where it leads.

use crosscut_stage::Beam;

use super::LOOKOUT_M;
use crate::ring::{Position, Ring};

/// Bisections of a way of at most 8 m or a half turn: to 1 cm and 0.2° at worst.
const BISECTIONS: usize = 10;

/// The wall on one side of an edge.
#[derive(Clone, Copy, Debug)]
pub(super) struct Side {
    /// Its return at the edge.
    pub(super) at: usize,
    /// It lies clockwise of the edge.
    pub(super) clockwise: bool,
}

/// Both sides of an edge.
pub(crate) struct Sides<'a> {
    pub(super) ring: &'a Ring,
    pub(super) clockwise: Side,
    pub(super) anticlockwise: Side,
}

impl Side {
    /// The returns of the wall, from the edge onward, half way round the ring at most.
    pub(super) fn along(self, ring: &Ring) -> impl Iterator<Item = usize> {
        let (n, wall) = (ring.len(), ring.entries[self.at].wall);
        let step = if self.clockwise { n - 1 } else { 1 };
        (0..n.div_ceil(2)).map(move |s| (self.at + s * step) % n).take_while(move |&at| ring.entries[at].wall == wall)
    }

    /// The wall as a line from return to return: each return from the edge onward with the one before it.
    fn line_m(self, ring: &Ring) -> impl Iterator<Item = [Position; 2]> {
        let positions_m = move || self.along(ring).map(|at| ring.entries[at].position_m);
        let end_m = ring.entries[self.at].position_m;
        std::iter::once(end_m).chain(positions_m()).zip(positions_m()).map(|(before_m, after_m)| [before_m, after_m])
    }

    /// Where the wall, seen from the edge, comes within [`LOOKOUT_M`] of the sensor; its end at the edge if it does not.
    pub(super) fn anchor_m(self, ring: &Ring) -> Position {
        let within = self.line_m(ring).find(|[_, after_m]| after_m.norm() <= LOOKOUT_M);
        within.map_or(ring.entries[self.at].position_m, |[before_m, after_m]| {
            if before_m.norm() <= LOOKOUT_M { after_m } else { on_circle_m(before_m, after_m) }
        })
    }

    /// The place of the wall that is nearest to a point.
    fn nearest_m(self, ring: &Ring, point_m: Position) -> Position {
        let nearest = self.line_m(ring).map(|piece_m| nearest_on_m(piece_m, point_m));
        let nearest = nearest.min_by(|a, b| (a - point_m).norm_squared().total_cmp(&(b - point_m).norm_squared()));
        nearest.unwrap_or(ring.entries[self.at].position_m)
    }
}

impl<'a> Sides<'a> {
    /// Of the edge from one return to the next.
    pub(super) fn of(ring: &'a Ring, clockwise: usize, anticlockwise: usize) -> Self {
        let [clockwise, anticlockwise] =
            [(clockwise, true), (anticlockwise, false)].map(|(at, clockwise)| Side { at, clockwise });
        Self { ring, clockwise, anticlockwise }
    }

    /// The walls clockwise and anticlockwise of the edge.
    pub(crate) fn walls(&self) -> [u32; 2] {
        [self.clockwise, self.anticlockwise].map(|side| self.ring.entries[side.at].wall)
    }

    /// The two returns at the edge.
    pub(crate) fn edge_m(&self) -> [Position; 2] {
        [self.clockwise, self.anticlockwise].map(|side| self.ring.entries[side.at].position_m)
    }

    /// What the beams between them saw.
    pub(crate) fn between(&self) -> impl Iterator<Item = Beam> + Clone {
        self.ring.between(self.clockwise.at, self.anticlockwise.at)
    }

    /// Whether one of those came back with nothing.
    pub(super) fn is_dark(&self) -> bool {
        self.between().any(|beam| beam == Beam::NoReturn)
    }

    /// The side whose wall comes nearer to the sensor at the edge, and the other.
    pub(super) fn by_range(&self) -> [Side; 2] {
        let range_m = |side: Side| self.ring.entries[side.at].range_m;
        let clockwise_first = range_m(self.clockwise) <= range_m(self.anticlockwise);
        if clockwise_first { [self.clockwise, self.anticlockwise] } else { [self.anticlockwise, self.clockwise] }
    }

    /// The two ends of the shortest line across the branch, at most [`LOOKOUT_M`] from the sensor.
    ///
    /// From the anchor of each side to the nearest return of the other side; the shorter of the two.
    pub(super) fn mouth_m(&self) -> [Position; 2] {
        let across =
            |from: Side, to: Side| [from.anchor_m(self.ring), to.nearest_m(self.ring, from.anchor_m(self.ring))];
        let lines = [across(self.clockwise, self.anticlockwise), across(self.anticlockwise, self.clockwise)];
        let length_m = |[a, b]: [Position; 2]| (a - b).norm();
        if length_m(lines[0]) <= length_m(lines[1]) { lines[0] } else { lines[1] }
    }

    /// Where the centreline of the branch is last seen, at most [`LOOKOUT_M`] from the sensor.
    ///
    /// The centreline runs half the width away from the wall on the far side. What is seen of the branch ends at the
    /// beam past the end of the near wall, and here at a circle of that radius around the sensor. From where the near
    /// wall ends along the beam, then along the circle, the far wall comes nearer and nearer.
    pub(super) fn lookout_m(&self, width_m: f64) -> Option<Position> {
        let [near, far] = self.by_range();
        let (corner_m, opposite_m) = (near.anchor_m(self.ring), far.anchor_m(self.ring));
        let at_lookout_m = corner_m * (LOOKOUT_M / corner_m.norm()).max(1.0);
        let turn_rad = corner_m.perp(&opposite_m).atan2(corner_m.dot(&opposite_m));
        let on_beam = |share: f64| corner_m + (at_lookout_m - corner_m) * share;
        let on_circle = |share: f64| nalgebra::Rotation2::new(share * turn_rad) * at_lookout_m;
        let far_wall_m: Vec<[Position; 2]> = far.line_m(self.ring).collect();
        let reached = |point_m: Position| {
            let near_enough = |piece_m: &[Position; 2]| {
                (nearest_on_m(*piece_m, point_m) - point_m).norm_squared() <= (0.5 * width_m).powi(2)
            };
            far_wall_m.iter().any(near_enough)
        };
        if reached(at_lookout_m) {
            Some(bisect(on_beam, reached))
        } else if reached(on_circle(1.0)) {
            Some(bisect(on_circle, reached))
        } else {
            None
        }
    }
}

/// Where a line from outside to inside meets the circle of [`LOOKOUT_M`] around the sensor.
fn on_circle_m(outside_m: Position, inside_m: Position) -> Position {
    bisect(|share| outside_m + (inside_m - outside_m) * share, |point_m| point_m.norm() <= LOOKOUT_M)
}

/// The point of a piece of a line that is nearest to another.
fn nearest_on_m([from_m, to_m]: [Position; 2], point_m: Position) -> Position {
    let along = to_m - from_m;
    let share = ((point_m - from_m).dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
    // A piece of no length is its end.
    if share.is_nan() { to_m } else { from_m + along * share }
}

/// The first point of a way of which the end is reached and the start is not.
fn bisect(way: impl Fn(f64) -> Position, reached: impl Fn(Position) -> bool) -> Position {
    let (mut before, mut after) = (0.0, 1.0);
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (before + after);
        if reached(way(middle)) { after = middle } else { before = middle }
    }
    way(after)
}
