//! The two walls beside an opening: how wide the branch between them is, and where it leads.

use std::f64::consts::{PI, TAU};

use crosscut_scan::{Position, Return};
use crosscut_stage::Beam;

use super::LOOKOUT_M;
use crate::outline::Outline;

/// This many bisections of a way of at most 8 m or a half turn leave 1 cm or 0.2°.
const BISECTIONS: usize = 10;
/// What is farther by this factor is farther whatever was rounded.
const ROUNDING: f64 = 1.001;
/// More pieces of a wall are seldom near where a branch is last seen.
const NEAR_PIECES: usize = 32;

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
    pub(super) outline: &'a Outline,
    pub(super) clockwise: Side,
    pub(super) anticlockwise: Side,
}

impl Side {
    /// The returns of the wall, from the edge onward, half way round the ring at most.
    pub(super) fn along(self, outline: &Outline) -> impl Iterator<Item = &Return> {
        outline.wall_from(self.at, !self.clockwise).take(outline.len().div_ceil(2))
    }

    /// The wall as a line from return to return: each return from the edge onward with the one before it.
    fn line(self, outline: &Outline) -> impl Iterator<Item = [&Return; 2]> {
        let mut before = &outline.ring.returns[self.at];
        self.along(outline).map(move |after| [std::mem::replace(&mut before, after), after])
    }

    /// The wall as a line, each piece by the positions of its two ends.
    fn line_m(self, outline: &Outline) -> impl Iterator<Item = [Position; 2]> {
        self.line(outline).map(|piece| piece.map(|one| one.position_m))
    }

    /// Where the wall, seen from the edge, comes within [`LOOKOUT_M`] of the sensor; its end at the edge if it does
    /// not.
    pub(super) fn anchor_m(self, outline: &Outline) -> Position {
        let within = self.line(outline).find(|[_, after]| after.range_m <= LOOKOUT_M);
        within.map_or(outline.position_m(self.at), |[before, after]| {
            if before.range_m <= LOOKOUT_M {
                after.position_m
            } else {
                on_circle_m(before.position_m, after.position_m)
            }
        })
    }

    /// The place of the wall that is nearest to a point.
    fn nearest_m(self, outline: &Outline, point_m: Position) -> Position {
        let (mut nearest_m, mut least) = (outline.position_m(self.at), f64::INFINITY);
        for piece_m in self.line_m(outline) {
            // This needs no division, and excludes most pieces.
            if !is_within(piece_m, point_m, ROUNDING * least) {
                continue;
            }
            let on_piece_m = nearest_on_m(piece_m, point_m);
            let squared = (on_piece_m - point_m).norm_squared();
            if squared < least {
                (nearest_m, least) = (on_piece_m, squared);
            }
        }
        nearest_m
    }
}

impl<'a> Sides<'a> {
    /// Of the edge from one return to the next.
    pub(super) fn of(outline: &'a Outline, clockwise: usize, anticlockwise: usize) -> Self {
        let [clockwise, anticlockwise] =
            [(clockwise, true), (anticlockwise, false)].map(|(at, clockwise)| Side { at, clockwise });
        Self { outline, clockwise, anticlockwise }
    }

    /// Whether the returns beside the edge are of two walls.
    pub(crate) fn are_two_walls(&self) -> bool {
        let [a, b] = self.walls();
        a != b
    }

    /// Whether anything is known of what is in the edge.
    pub(crate) fn is_known(&self) -> bool {
        let mut between = self.between().peekable();
        between.peek().is_none() || between.any(|beam| beam != Beam::Unknown)
    }

    /// The walls clockwise and anticlockwise of the edge.
    pub(crate) fn walls(&self) -> [u32; 2] {
        [self.clockwise, self.anticlockwise].map(|side| self.outline.wall(side.at))
    }

    /// The two returns at the edge.
    pub(crate) fn edge_m(&self) -> [Position; 2] {
        [self.clockwise, self.anticlockwise].map(|side| self.outline.position_m(side.at))
    }

    /// How far the walls are apart at the edge; the last two returns of each count, as one may be a stray return.
    pub(super) fn width_m(&self) -> f64 {
        let last_two_m = |side: Side| side.along(self.outline).take(2).map(|one| one.position_m);
        let across_m =
            last_two_m(self.clockwise).flat_map(|a| last_two_m(self.anticlockwise).map(move |b| (a - b).norm()));
        across_m.fold(0.0, f64::max)
    }

    /// The width of the doorway through which the farther wall is seen, if it is: from the end of the nearer wall to the
    /// wall on the other side of the farther one. All seen returns of the farther wall lie behind the line between the two.
    pub(super) fn doorway_m(&self) -> Option<f64> {
        let [near, far] = self.by_range();
        let [jamb_m, other_m] =
            [near.at, self.outline.beyond(far.at, near.clockwise)?].map(|at| self.outline.position_m(at));
        let across = other_m - jamb_m;
        let behind = |one: &Return| {
            let left = across.perp(&(one.position_m - jamb_m));
            if near.clockwise { left < 0.0 } else { left > 0.0 }
        };
        far.along(self.outline).all(behind).then_some(across.norm())
    }

    /// The angle over which the edge is seen, anticlockwise.
    pub(super) fn seen_at_rad(&self) -> f64 {
        let [from_m, to_m] = self.edge_m();
        from_m.perp(&to_m).atan2(from_m.dot(&to_m)).rem_euclid(TAU)
    }

    /// The direction in which the middle of the edge is seen.
    pub(super) fn towards(&self) -> Position {
        let [from_m, _] = self.edge_m();
        nalgebra::Rotation2::new(0.5 * self.seen_at_rad()) * from_m.normalize()
    }

    /// Whether the edge spans half a turn or more, and most beams into it came back with nothing. A wall that went on
    /// straight across it would have to pass on the other side of the sensor.
    pub(super) fn is_open_side(&self) -> bool {
        self.seen_at_rad() >= PI && self.is_mostly_dark()
    }

    /// Whether more than half of the beams between them came back with nothing.
    pub(super) fn is_mostly_dark(&self) -> bool {
        let (mut dark, mut beams) = (0, 0);
        for beam in self.between() {
            beams += 1;
            dark += usize::from(beam == Beam::NoReturn);
        }
        2 * dark > beams
    }

    /// What the beams between the two returns saw.
    pub(crate) fn between(&self) -> impl Iterator<Item = Beam> + Clone {
        self.outline.ring.between(self.clockwise.at, self.anticlockwise.at)
    }

    /// Whether more than half of the beams between them end at pillars, or at returns of no wall.
    pub(super) fn is_shaded(&self) -> bool {
        let shaded = self.between().filter(|beam| matches!(beam, Beam::Return(_))).count();
        2 * shaded > self.between().count()
    }

    /// The width, at the nearer end, of the beams between them that came back with nothing.
    pub(super) fn dark_m(&self) -> f64 {
        let dark = self.between().filter(|beam| *beam == Beam::NoReturn).count();
        let [near, _] = self.by_range();
        dark as f64 * self.outline.ring.step_rad * self.outline.range_m(near.at)
    }

    /// Whether a beam between them came back with nothing.
    pub(super) fn is_dark(&self) -> bool {
        self.between().any(|beam| beam == Beam::NoReturn)
    }

    /// The side whose wall comes nearer to the sensor at the edge, and the other.
    pub(super) fn by_range(&self) -> [Side; 2] {
        let range_m = |side: Side| self.outline.range_m(side.at);
        let clockwise_first = range_m(self.clockwise) <= range_m(self.anticlockwise);
        if clockwise_first { [self.clockwise, self.anticlockwise] } else { [self.anticlockwise, self.clockwise] }
    }

    /// Where the wall on each side, seen from the edge, comes within [`LOOKOUT_M`] of the sensor; clockwise side first.
    pub(super) fn anchors_m(&self) -> [Position; 2] {
        [self.clockwise, self.anticlockwise].map(|side| side.anchor_m(self.outline))
    }

    /// The two ends of the shortest line across the branch, at most [`LOOKOUT_M`] from the sensor: the shorter of the
    /// lines from the anchor of each side to the nearest place of the other side.
    pub(super) fn mouth_m(&self, anchors_m: [Position; 2]) -> [Position; 2] {
        let [clockwise_m, anticlockwise_m] = anchors_m;
        let lines = [
            [clockwise_m, self.anticlockwise.nearest_m(self.outline, clockwise_m)],
            [anticlockwise_m, self.clockwise.nearest_m(self.outline, anticlockwise_m)],
        ];
        let length_m = |[a, b]: [Position; 2]| (a - b).norm();
        if length_m(lines[0]) <= length_m(lines[1]) { lines[0] } else { lines[1] }
    }

    /// Where the centreline of the branch is last seen, at most [`LOOKOUT_M`] from the sensor.
    ///
    /// The centreline runs half the width away from the wall on the far side. What is seen of the branch ends at the
    /// beam past the end of the near wall, and here at a circle of that radius around the sensor. From where the near
    /// wall ends along the beam, then along the circle, the far wall comes nearer and nearer.
    pub(super) fn lookout_m(&self, anchors_m: [Position; 2], width_m: f64) -> Option<Position> {
        let [near, far] = self.by_range();
        let [corner_m, opposite_m] = if near.clockwise { anchors_m } else { [anchors_m[1], anchors_m[0]] };
        let at_lookout_m = corner_m * (LOOKOUT_M / corner_m.norm()).max(1.0);
        let turn_rad = corner_m.perp(&opposite_m).atan2(corner_m.dot(&opposite_m));
        let on_beam = |share: f64| corner_m + (at_lookout_m - corner_m) * share;
        let on_circle = |share: f64| nalgebra::Rotation2::new(share * turn_rad) * at_lookout_m;
        // Only pieces that are near the start of both ways can be near a point of one.
        let near_m = 0.5 * width_m;
        let reach_m = [corner_m, on_circle(1.0)].map(|end_m| (end_m - at_lookout_m).norm());
        let reach_m = ROUNDING * (reach_m[0].max(reach_m[1]) + near_m);
        let mut wall_m = Vec::with_capacity(NEAR_PIECES);
        wall_m.extend(far.line_m(self.outline).filter(|&piece_m| is_within(piece_m, at_lookout_m, reach_m * reach_m)));
        first_within_m(on_beam, &wall_m, near_m).or_else(|| first_within_m(on_circle, &wall_m, near_m))
    }
}

/// The first point of a way that is within this distance of a wall, if its end is.
fn first_within_m(way: impl Fn(f64) -> Position, wall_m: &[[Position; 2]], distance_m: f64) -> Option<Position> {
    let is_reached = |point_m| wall_m.iter().any(|&piece_m| is_within(piece_m, point_m, distance_m * distance_m));
    is_reached(way(1.0)).then(|| bisect(way, is_reached))
}

/// Whether a piece of a line comes within the root of `squared` of a point.
fn is_within([from_m, to_m]: [Position; 2], point_m: Position, squared: f64) -> bool {
    let (along, offset) = (to_m - from_m, point_m - from_m);
    let (length_squared, on_line) = (along.norm_squared(), offset.dot(&along));
    // Nearest is one of its ends, or the foot of the perpendicular; no root is taken, and nothing is divided.
    if on_line <= 0.0 {
        offset.norm_squared() <= squared
    } else if on_line >= length_squared {
        (point_m - to_m).norm_squared() <= squared
    } else {
        along.perp(&offset).powi(2) <= squared * length_squared
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
