//! Whether a wall goes on across a gap, or a vehicle can pass.

use std::cell::RefCell;
use std::f64::consts::{PI, TAU};

use super::Limits;
use super::pieces::{End, Pieces};
use super::ring::{Position, Ring, turn_rad};
use super::tangent::{Tangents, has_direction, tangent};
use super::way::Room;

/// Tunnels are not so wide: where the median range is larger, the place is a hall, and its ways on are no wider for
/// that.
const HALL_M: f64 = 4.5;
/// A gap with one beam in it is narrower than this, two steps of a lidar of 180 beams a turn.
const ONE_BEAM_RAD: f64 = 4.5 * PI / 180.0;
/// A piece without a direction belongs to a wall if it lies within this of its line, plus a share of the distance.
const OFF_LINE_M: f64 = 0.3;
const OFF_LINE_SHARE: f64 = 0.15;
/// Two pieces without direction belong together along a line of sight: a wall at grazing incidence. Share of their
/// distance that is along the beams.
const GRAZING_SHARE: f64 = 0.8;

/// Judges the gaps of one scan.
#[derive(Clone, Copy, Debug)]
pub(super) struct Judge<'a> {
    pub(super) ring: &'a Ring,
    /// Those of the same ring.
    tangents: &'a RefCell<Tangents>,
    pub(super) limits: Limits,
    /// The size of the place: the median range, or [`HALL_M`] if that is less.
    pub(super) size_m: f64,
    /// The most beams that are lost in a row where a wall clearly goes on.
    pub(super) lost_beams: u32,
    /// At how many such places several are.
    pub(super) lossy_places: u32,
}

/// How much a wall turns left at a gap: at its nearer end, at its farther one, and in all.
#[derive(Clone, Copy)]
pub(super) struct Turns {
    pub(super) near_rad: f64,
    pub(super) far_rad: f64,
    pub(super) whole_rad: f64,
}

/// What it takes to close a gap.
pub(super) struct Closing {
    /// `None` where a vehicle could pass.
    pub(super) cost: Option<f64>,
    /// `None` if a piece has no direction.
    pub(super) room: Option<Room>,
}

/// A gap between two pieces that have directions there.
pub(super) struct Gap<'p> {
    pub(super) a: &'p [usize],
    pub(super) b: &'p [usize],
    /// The last return of `a`, and the first of `b`.
    pub(super) ends: (usize, usize),
    /// The ranges of the nearer of them, and of the farther one.
    pub(super) near_m: f64,
    pub(super) far_m: f64,
    /// The direction in which the wall runs at the end of `a`: a unit vector.
    pub(super) before: Position,
    /// From the end of `a` to the start of `b`.
    pub(super) chord: Position,
    /// The direction in which it runs on at the start of `b`.
    pub(super) after: Position,
    /// The end of `a` is nearer to the sensor than that of `b`.
    pub(super) a_is_nearer: bool,
}

impl<'a> Judge<'a> {
    /// Learns the size of the place, and how many beams get lost, from the pieces of its walls.
    pub(super) fn new(ring: &'a Ring, tangents: &'a RefCell<Tangents>, pieces: &Pieces, limits: Limits) -> Self {
        tangents.borrow_mut().start(ring, limits.stretch_m);
        let mut ranges_m: Vec<f64> = pieces.returns().iter().map(|&i| ring.range_m(i)).collect();
        let middle = ranges_m.len() / 2;
        let median_m =
            if ranges_m.is_empty() { 0.0 } else { *ranges_m.select_nth_unstable_by(middle, f64::total_cmp).1 };
        let size_m = median_m.min(HALL_M);
        let mut judge = Self { ring, tangents, limits, size_m, lost_beams: 0, lossy_places: 0 };
        judge.count_lost_beams(pieces);
        judge
    }

    /// The cost at which one wall goes on from the end of piece `a` to the start of piece `b`, anticlockwise; `None`
    /// where a vehicle could pass between them.
    #[inline]
    pub(super) fn cost(&self, a: &[usize], b: &[usize]) -> Option<f64> {
        if self.is_gap(a[a.len() - 1], b[0]) { self.closing(a, b).cost } else { Some(0.0) }
    }

    /// Whether two returns that follow each other are so far from each other that the wall may end between them.
    #[inline]
    pub(super) fn is_gap(&self, p: usize, q: usize) -> bool {
        self.ring.are_apart(p, q, self.limits.passage_m)
    }

    /// What it takes to go on over a gap from the end of piece `a` to the start of piece `b`.
    pub(super) fn closing(&self, a: &[usize], b: &[usize]) -> Closing {
        let ring = self.ring;
        let (p, q) = (a[a.len() - 1], b[0]);
        let chord = ring.position_m(q) - ring.position_m(p);
        let chord_m = chord.norm();
        match self.directions(a, b) {
            [Some(before), Some(after)] => {
                let gap = Gap::new(ring, [a, b], [before, after]);
                let turns = gap.turns();
                let room = self.room(&gap, turns);
                let detour_rad = turns.near_rad.abs().min(turns.far_rad.abs());
                let far = if chord_m > 3.0 { 0.05 * chord_m } else { 0.0 };
                let cost = (!room.is_way()).then(|| 0.1 + turns.whole_rad.abs() + 0.2 * detour_rad + far);
                Closing { cost, room: Some(room) }
            }
            [None, None] => {
                let along_m = (ring.range_m(q) - ring.range_m(p)).abs();
                let grazing = along_m > GRAZING_SHARE * chord_m;
                Closing { cost: grazing.then_some(1.0 + 0.1 * chord_m), room: None }
            }
            [before, after] => {
                let cost = before.or(after).and_then(|line| {
                    let along_m = line.dot(&chord);
                    let off = line.perp(&chord).abs() / (OFF_LINE_M + OFF_LINE_SHARE * along_m);
                    (along_m > 0.0 && off < 1.0).then_some(0.3 + off + 0.05 * chord_m)
                });
                Closing { cost, room: None }
            }
        }
    }

    /// How much the wall turns left at both ends of a gap, over this stretch of either piece.
    pub(super) fn turns_over_rad(&self, a: &[usize], b: &[usize], stretch_m: f64) -> [f64; 2] {
        let directions =
            [(a, End::Last), (b, End::First)].map(|(piece, end)| tangent(self.ring, piece, end, stretch_m));
        Gap::new(self.ring, [a, b], directions).turns_rad()
    }

    /// Whether at most one beam looks into the gap, and the angle is not so wide that this means that nothing is seen in it:
    /// one that came back with nothing, from the air or from too little to be a wall, says nothing.
    pub(super) fn has_hardly_a_beam(&self, gap: &Gap<'_>) -> bool {
        let steps = self.ring.beams_from(gap.ends.0, gap.ends.1);
        steps == 1 || (steps == 2 && 2.0 * self.ring.step_rad < ONE_BEAM_RAD)
    }

    /// The gap between two pieces; `None` if one of them has no direction.
    pub(super) fn gap<'p>(&self, a: &'p [usize], b: &'p [usize]) -> Option<Gap<'p>> {
        let [before, after] = self.directions(a, b);
        Some(Gap::new(self.ring, [a, b], [before?, after?]))
    }

    /// The directions in which a wall runs at the end of piece `a` and at the start of piece `b`, if they have one.
    pub(super) fn directions(&self, a: &[usize], b: &[usize]) -> [Option<Position>; 2] {
        let of = |piece: &[usize], end| {
            has_direction(self.ring, piece).then(|| self.tangents.borrow_mut().of(self.ring, piece, end))
        };
        [of(a, End::Last), of(b, End::First)]
    }
}

impl<'p> Gap<'p> {
    fn new(ring: &Ring, [a, b]: [&'p [usize]; 2], [before, after]: [Position; 2]) -> Self {
        let (p, q) = (a[a.len() - 1], b[0]);
        let chord = ring.position_m(q) - ring.position_m(p);
        let [p_m, q_m] = [p, q].map(|end| ring.range_m(end));
        let (near_m, far_m) = (p_m.min(q_m), p_m.max(q_m));
        Self { a, b, ends: (p, q), near_m, far_m, before, chord, after, a_is_nearer: p_m < q_m }
    }

    pub(super) fn turns(&self) -> Turns {
        let turns_rad @ [before_rad, after_rad] = self.turns_rad();
        let (near_rad, far_rad) = if self.a_is_nearer { (before_rad, after_rad) } else { (after_rad, before_rad) };
        Turns { near_rad, far_rad, whole_rad: whole_turn_rad(turns_rad) }
    }

    /// The return at the nearer end, and that at the farther one.
    pub(super) fn nearer_and_farther(&self) -> (usize, usize) {
        let (p, q) = self.ends;
        if self.a_is_nearer { (p, q) } else { (q, p) }
    }

    /// The direction in which the nearer wall runs towards its end.
    pub(super) fn nearer_onward(&self) -> Position {
        if self.a_is_nearer { self.before } else { -self.after }
    }

    /// The nearer piece, and its end at the gap.
    pub(super) fn nearer(&self) -> (&'p [usize], End) {
        if self.a_is_nearer { (self.a, End::Last) } else { (self.b, End::First) }
    }

    /// The farther piece, and its end at the gap.
    pub(super) fn farther(&self) -> (&'p [usize], End) {
        if self.a_is_nearer { (self.b, End::First) } else { (self.a, End::Last) }
    }

    /// The clear width, and how far the end of the farther wall lies to the left of the line of the nearer one.
    pub(super) fn clear_and_farther_m(&self) -> [f64; 2] {
        let [of_q, of_p] = self.aside_m();
        if self.a_is_nearer { [of_p.abs(), of_q] } else { [of_q.abs(), of_p] }
    }

    /// How much the wall turns left at the one end and at the other.
    pub(super) fn turns_rad(&self) -> [f64; 2] {
        [turn_rad(self.before, self.chord), turn_rad(self.chord, self.after)]
    }

    /// How far each end lies to the left of the line of the other piece; right is behind that piece, out of sight.
    pub(super) fn aside_m(&self) -> [f64; 2] {
        [self.before.perp(&self.chord), self.after.perp(&-self.chord)]
    }
}

/// How far the wall turns at the gap, to the left; around a tip it may turn right by more than π.
pub(super) fn whole_turn_rad([before_rad, after_rad]: [f64; 2]) -> f64 {
    let turn_rad = before_rad + after_rad;
    if turn_rad < -1.15 * PI {
        turn_rad + TAU
    } else if turn_rad > 1.5 * PI {
        turn_rad - TAU
    } else {
        turn_rad
    }
}
