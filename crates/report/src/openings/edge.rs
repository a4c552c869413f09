//! An edge of the visible free space, between the ends of two walls: how wide the branch behind it is, and where it
//! leads.

use std::f64::consts::{PI, TAU};

use crosscut_scan::{Clearance, DOORWAY_TIMES, Doorway, Position, Return};
use crosscut_stage::{Beam, Evidence, Known, Opening};

use super::{LOOKOUT_M, WIDENS, bearing_rad, point};
use crate::wall_ring::WallRing;

/// The line of a wall behind its end is that between two returns this far apart: over a shorter stretch, the line of a
/// rough wall misses what is far off by more than its roughness.
const LINE_M: f64 = 1.5;

/// The far side of a branch is no nearer to the direction of the nearer wall than 45°: the cosine of that.
const BRANCH_COS: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// Bisections of a way: they leave 1 cm of 8 m, and 0.2° of a half turn.
const BISECTIONS: usize = 10;
/// A distance that is larger by this factor is larger however both were rounded.
const ROUNDING: f64 = 1.001;
/// More pieces of a wall are seldom near where a branch is last seen.
const NEAR_PIECES: usize = 32;

/// Where a wall ends beside an edge.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WallEnd {
    /// Its return at the edge, counted in the outline.
    pub(crate) at: usize,
    /// The wall lies clockwise of the edge.
    pub(crate) is_clockwise: bool,
}

/// Two returns of walls, and the beams between them, anticlockwise.
pub(crate) struct FreeEdge<'a> {
    pub(crate) outline: &'a WallRing,
    pub(super) clockwise: WallEnd,
    pub(super) anticlockwise: WallEnd,
}

impl WallEnd {
    /// The returns of the wall, from the edge onward, half way round the ring at most.
    fn along(self, outline: &WallRing) -> impl Iterator<Item = &Return> {
        outline.wall_from(self.at, !self.is_clockwise).take(outline.len().div_ceil(2))
    }

    /// The wall as a line from return to return: each return from the edge onward with the one before it.
    fn line(self, outline: &WallRing) -> impl Iterator<Item = [&Return; 2]> {
        let mut before = &outline.ring.returns[self.at];
        self.along(outline).map(move |after| [std::mem::replace(&mut before, after), after])
    }

    /// The wall as a line, each piece by the positions of its two ends.
    fn line_m(self, outline: &WallRing) -> impl Iterator<Item = [Position; 2]> {
        self.line(outline).map(|piece| piece.map(|one| one.position_m))
    }

    /// The unit direction in which the wall runs towards this end, from the return of it that is about this far before
    /// the end; `None` of a single return.
    pub(crate) fn runs_out(self, outline: &WallRing, length_m: f64) -> Option<Position> {
        let end_m = outline.position_m(self.at);
        let mut longest_m = Position::zeros();
        for one in self.along(outline) {
            longest_m = end_m - one.position_m;
            if longest_m.norm_squared() >= length_m * length_m {
                break;
            }
        }
        longest_m.try_normalize(0.0)
    }

    /// Where the wall, seen from the edge, comes within [`LOOKOUT_M`] of the sensor; its end at the edge if it does
    /// not.
    pub(super) fn anchor_m(self, outline: &WallRing) -> Position {
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
    fn nearest_m(self, outline: &WallRing, point_m: Position) -> Position {
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

impl<'a> FreeEdge<'a> {
    /// The edge from one return of the outline anticlockwise to another.
    pub(crate) fn between(outline: &'a WallRing, [from, to]: [usize; 2]) -> Self {
        let clockwise = WallEnd { at: from, is_clockwise: true };
        let anticlockwise = WallEnd { at: to, is_clockwise: false };
        Self { outline, clockwise, anticlockwise }
    }

    /// The edges between every two neighbouring returns that are of two walls, or at least this far from each other.
    pub(crate) fn all(outline: &'a WallRing, least_m: f64) -> impl Iterator<Item = Self> {
        let is_edge = move |&[from, to]: &[usize; 2]| {
            outline.wall(from) != outline.wall(to) || outline.ring.are_apart(from, to, least_m)
        };
        outline.pairs().filter(is_edge).map(|pair| Self::between(outline, pair))
    }

    /// Whether the returns beside the edge are of two walls.
    pub(crate) fn is_between_walls(&self) -> bool {
        let [a, b] = self.walls();
        a != b
    }

    /// Whether some beam into the edge is known.
    pub(crate) fn is_known(&self) -> bool {
        let mut between = self.between_beams().peekable();
        between.peek().is_none() || between.any(|beam| beam != Beam::Unknown)
    }

    /// The walls clockwise and anticlockwise of the edge.
    pub(crate) fn walls(&self) -> [u32; 2] {
        self.ends().map(|end| self.outline.wall(end.at))
    }

    /// The two returns at the edge, by their numbers in the revolution.
    pub(crate) fn returns(&self) -> [u32; 2] {
        self.ends().map(|end| self.outline.ring.returns[end.at].number)
    }

    /// The positions of the two returns at the edge.
    pub(crate) fn ends_m(&self) -> [Position; 2] {
        self.ends().map(|end| self.outline.position_m(end.at))
    }

    fn ends(&self) -> [WallEnd; 2] {
        [self.clockwise, self.anticlockwise]
    }

    /// How far the walls leave each other's line at the edge: a wall that continues leaves none. The distance of the
    /// nearer end from the line of the farther wall, or twice that of the farther end from the line of the nearer wall,
    /// if that is less; 0 where a wall has no direction.
    pub(crate) fn clearance_m(&self) -> f64 {
        let [from_m, to_m] = self.ends_m();
        let [Some(before), Some(after)] = self.ends().map(|end| end.runs_out(self.outline, LINE_M)) else { return 0.0 };
        let clearance = Clearance::at(to_m - from_m, [before, -after], self.by_range()[0].is_clockwise);
        clearance.clear_m.min(2.0 * clearance.depth_m.abs())
    }

    /// How far the walls leave each other's line where the farther one leads away from the line of the nearer one, as the
    /// far side of a branch does; `None` elsewhere.
    pub(crate) fn clearance_of_branch(&self) -> Option<Clearance> {
        let [from_m, to_m] = self.ends_m();
        let [before, after] = self.ends().map(|end| end.runs_out(self.outline, LINE_M));
        let (before, after) = (before?, after?);
        let leads_away = before.dot(&after).abs() < BRANCH_COS;
        leads_away.then(|| Clearance::at(to_m - from_m, [before, -after], self.by_range()[0].is_clockwise))
    }

    /// How far its nearer end is from the sensor.
    pub(crate) fn range_m(&self) -> f64 {
        self.outline.range_m(self.by_range()[0].at)
    }

    /// How far a strip of this width leaves the edge outward before it meets one of the returns; infinite if it meets
    /// none.
    pub(crate) fn depth_m(&self, returns_m: impl Iterator<Item = Position>, strip_width_m: f64) -> f64 {
        let [from_m, to_m] = self.ends_m();
        let middle_m = 0.5 * (from_m + to_m);
        let along = (to_m - from_m).normalize();
        // The edge runs anticlockwise around the sensor, so its right-hand normal points outward.
        let outward = Position::new(along.y, -along.x);
        let ahead_m = returns_m.map(|return_m| return_m - middle_m).filter(|ahead_m| {
            // The ends of the edge itself may lie ahead by a rounding error.
            ahead_m.dot(&outward) > 0.0 && ahead_m.dot(&along).abs() < strip_width_m / 2.0
        });
        ahead_m.map(|ahead_m| ahead_m.dot(&outward)).fold(f64::INFINITY, f64::min)
    }

    /// How far the walls are apart at the edge; the last two returns of each count, as one may be a stray return.
    fn width_m(&self) -> f64 {
        let last_two_m = |end: WallEnd| end.along(self.outline).take(2).map(|one| one.position_m);
        let across_m =
            last_two_m(self.clockwise).flat_map(|a| last_two_m(self.anticlockwise).map(move |b| (a - b).norm()));
        across_m.fold(0.0, f64::max)
    }

    /// The width of the doorway of which the nearer wall is one side, if all that is seen through it lies behind it.
    pub(super) fn doorway_m(&self, vehicle_width_m: f64) -> Option<f64> {
        let [near, far] = self.by_range();
        let onward = near.runs_out(self.outline, LINE_M)?;
        let ends = [near.at, far.at];
        let doorway = Doorway::beside(&self.outline.ring, ends, near.is_clockwise, onward, vehicle_width_m)?;
        (doorway.behind_m > 0.0).then_some(doorway.width_m)
    }

    /// Whether this edge and another one anticlockwise of it begin at the two sides of a doorway: their nearer walls run
    /// towards each other, a vehicle fits between them, and all that is seen there lies behind them.
    pub(super) fn is_doorway_to(&self, other: &Self, vehicle_width_m: f64) -> bool {
        let (outline, sides) = (self.outline, [self.by_range()[0], other.by_range()[0]]);
        let width_m = outline.ring.distance_m(sides[0].at, sides[1].at);
        let is_door_wide = (vehicle_width_m..=DOORWAY_TIMES * vehicle_width_m).contains(&width_m);
        if !is_door_wide || !sides[0].is_clockwise || sides[1].is_clockwise {
            return false;
        }
        let ([from, to], count) = ([self.anticlockwise.at, other.clockwise.at], outline.len());
        let seen = (0..=(to + count - from) % count).map(|step| (from + step) % count);
        [[0, 1], [1, 0]].into_iter().all(|[near, far]| {
            let side = sides[near];
            let ends = [side.at, sides[far].at];
            let doorway = side
                .runs_out(outline, LINE_M)
                .and_then(|onward| Doorway::between(&outline.ring, ends, side.is_clockwise, onward, seen.clone()));
            doorway.is_some_and(|doorway| doorway.behind_m > 0.0)
        })
    }

    /// The edge from where this one begins to where another one anticlockwise of it ends.
    pub(super) fn up_to(&self, other: &Self) -> Self {
        Self { anticlockwise: other.anticlockwise, ..*self }
    }

    /// The opening that the edge is, and the middle of its mouth.
    pub(crate) fn opening(&self) -> (Opening, Position) {
        let (ends_m, towards) = (self.ends_m(), self.towards());
        let is_ahead = |[a, b]: [Position; 2]| (a + b).dot(&towards) > 0.0;
        let length_m = |[a, b]: [Position; 2]| (a - b).norm();
        let of_branch = |anchors_m: &_| is_ahead(*anchors_m) && length_m(*anchors_m) <= WIDENS * self.width_m();
        let anchors_m = Some(self.anchors_m()).filter(of_branch).unwrap_or(ends_m);
        let mouth_m = Some(self.mouth_m(anchors_m)).filter(|mouth_m| is_ahead(*mouth_m)).unwrap_or(ends_m);
        let (middle_m, width_m) = (0.5 * (mouth_m[0] + mouth_m[1]), length_m(mouth_m));
        let lookout_m = self.lookout_m(anchors_m, width_m).unwrap_or(middle_m);
        let opening = Opening {
            bearing_rad: bearing_rad(if is_ahead([lookout_m; 2]) { lookout_m } else { towards }),
            width_m,
            walls: self.walls(),
            returns: self.returns().map(Some),
            gaps: Vec::new(),
            evidence: if self.is_dark() { Evidence::NoReturn } else { Evidence::SeenThrough },
            known: Known::Judged,
            edge_m: ends_m.map(point),
            p: None,
        };
        (opening, middle_m)
    }

    /// The angle over which the edge is seen, anticlockwise.
    pub(crate) fn seen_at_rad(&self) -> f64 {
        let [from_m, to_m] = self.ends_m();
        from_m.perp(&to_m).atan2(from_m.dot(&to_m)).rem_euclid(TAU)
    }

    /// The direction in which the middle of the edge is seen.
    fn towards(&self) -> Position {
        let [from_m, _] = self.ends_m();
        nalgebra::Rotation2::new(0.5 * self.seen_at_rad()) * from_m.normalize()
    }

    /// Whether the edge spans half a turn or more, and most beams into it came back with nothing. A wall that continued
    /// straight across it would have to pass on the other side of the sensor.
    pub(super) fn is_open_side(&self) -> bool {
        self.seen_at_rad() >= PI && self.is_mostly_dark()
    }

    /// Whether more than half of the beams between them came back with nothing.
    pub(crate) fn is_mostly_dark(&self) -> bool {
        let (mut dark, mut beams) = (0, 0);
        for beam in self.between_beams() {
            beams += 1;
            dark += usize::from(beam == Beam::NoReturn);
        }
        2 * dark > beams
    }

    /// What the beams between the two returns saw.
    pub(crate) fn between_beams(&self) -> impl Iterator<Item = Beam> + Clone {
        self.outline.ring.between(self.clockwise.at, self.anticlockwise.at)
    }

    /// The width, at the nearer end, of the beams between them that came back with nothing.
    pub(crate) fn dark_m(&self) -> f64 {
        let dark = self.between_beams().filter(|beam| *beam == Beam::NoReturn).count();
        let [near, _] = self.by_range();
        dark as f64 * self.outline.ring.step_rad * self.outline.range_m(near.at)
    }

    /// Whether a beam between them came back with nothing.
    pub(super) fn is_dark(&self) -> bool {
        self.between_beams().any(|beam| beam == Beam::NoReturn)
    }

    /// The end that is nearer to the sensor, and the other.
    fn by_range(&self) -> [WallEnd; 2] {
        let range_m = |end: WallEnd| self.outline.range_m(end.at);
        let clockwise_first = range_m(self.clockwise) <= range_m(self.anticlockwise);
        if clockwise_first { [self.clockwise, self.anticlockwise] } else { [self.anticlockwise, self.clockwise] }
    }

    /// Where the wall on each side, seen from the edge, comes within [`LOOKOUT_M`] of the sensor; clockwise side first.
    fn anchors_m(&self) -> [Position; 2] {
        self.ends().map(|end| end.anchor_m(self.outline))
    }

    /// The two ends of the shortest line across the branch, at most [`LOOKOUT_M`] from the sensor: the shorter of the
    /// lines from the anchor of each side to the nearest place of the other side.
    fn mouth_m(&self, anchors_m: [Position; 2]) -> [Position; 2] {
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
    fn lookout_m(&self, anchors_m: [Position; 2], width_m: f64) -> Option<Position> {
        let [near, far] = self.by_range();
        let [corner_m, opposite_m] = if near.is_clockwise { anchors_m } else { [anchors_m[1], anchors_m[0]] };
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

/// The first point that is reached on a way from a start that is not reached to an end that is.
fn bisect(way: impl Fn(f64) -> Position, reached: impl Fn(Position) -> bool) -> Position {
    let (mut before, mut after) = (0.0, 1.0);
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (before + after);
        if reached(way(middle)) { after = middle } else { before = middle }
    }
    way(after)
}
