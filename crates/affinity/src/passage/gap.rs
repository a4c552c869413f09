//! Whether a wall goes on across a gap, or a vehicle can pass.

use std::cell::RefCell;
use std::f64::consts::{PI, TAU};

use super::pieces::Pieces;
use super::ring::{Position, Ring, turn_rad};
use super::tangent::{End, Tangents, has_direction, tangent};

/// Tunnels are not so wide: where the median range is larger, the place is a hall, and its ways on are no wider for
/// that.
const HALL_M: f64 = 6.0;
/// A gap whose walls recede from each other is a way on if it is at least so wide, as a share of the place's size.
const WAY_SHARE: f64 = 0.3;
/// A gap in which the view ends with nothing seen, likewise: at the end of the range, and nearer, where a dark surface
/// is as likely.
const DARK_SHARE: f64 = 0.45;
const DARK_NEAR_SHARE: f64 = 0.7;
/// Beams without return over so many beams and so wide an angle are such a view;
const DARK_BEAMS: u32 = 4;
const DARK_RAD: f64 = 3.5 * PI / 180.0;
/// if one of its ends lies farther than this share of the sensor's range,
const FAR_SHARE: f64 = 0.8;
/// or if they are so many times more than are lost in a row where a wall clearly goes on.
const LOST_TIMES: u32 = 2;
/// Over more than this angle, nothing seen is a way on even where the wall turns less or to the right, as long as it
/// turns by less than a corner that could be missing; from this share of the place's size.
const WIDE_DARK_RAD: f64 = 11.5 * PI / 180.0;
const WIDE_DARK_SHARE: f64 = 0.5;
const CORNER_RAD: f64 = 75.0 * PI / 180.0;
/// The nearer wall turns away from the line to the farther one by this much, the farther one by less than that: two
/// walls that recede, with nothing seen between them. It is a way on from this share of the place's size.
const RECEDING_RAD: f64 = 40.0 * PI / 180.0;
const GOING_ON_RAD: f64 = 20.0 * PI / 180.0;
const RECEDING_SHARE: f64 = 0.25;
/// There, a farther wall that ends so far in front of the line of the nearer one, as a share of the place's size, is
/// another one if no corner could be missing.
const IN_FRONT_SHARE: f64 = 0.65;
/// A gap that neither a patch of lost beams nor a hidden corner explains: nothing is seen over more than this angle.
/// Its width is that between its ends, and it is a way on from this share of the place's size.
const BLANK_RAD: f64 = 30.0 * PI / 180.0;
const BLANK_SHARE: f64 = 0.9;
/// It clearly goes on where it turns by less, and is off its line by no more than this share of the place's size.
const LOST_TURN_RAD: f64 = 30.0 * PI / 180.0;
const LOST_OFF_SHARE: f64 = 0.3;
/// The farther wall is the far side of a branch if it is seen behind the nearer one deeper than there is room between
/// them, or if both are at least this share of the place's size.
const SEEN_INSIDE_SHARE: f64 = 0.5;
/// The face of a corner: over so short a stretch the wall turns by so much, whatever it does over longer ones. The gap
/// before it is a way on from this share of the place's size.
const FACE_M: f64 = 0.3;
const FACE_RAD: f64 = 70.0 * PI / 180.0;
const FACE_SHARE: f64 = 0.9;
/// At a gap with nothing seen in it, a wall that turns by a corner and more, and over that short a stretch by this much,
/// ends there.
const DARK_FACE_RAD: f64 = 110.0 * PI / 180.0;
/// The farther wall comes back from behind the nearer one, turned by this much or more: what is between them leads
/// there. It is a way on from this share of the place's size.
const BEHIND_RAD: f64 = 130.0 * PI / 180.0;
const BEHIND_SHARE: f64 = 0.5;
/// A wall that is seen over a wider angle is the other side of the place itself; where it turns to meet the line of the
/// nearer one, the place ends in a corner.
const AROUND_RAD: f64 = 100.0 * PI / 180.0;
/// So does one that is seen over less, if it bends there: less than a right angle off at its end, more over this stretch.
const ACROSS_RAD: f64 = 34.0 * PI / 180.0;
const BENDING_M: f64 = 4.0;
/// Two walls are apart where one turns around if the clear width is this share of the place's size.
const PEAK_SHARE: f64 = 0.15;
/// In the shadow of islands nothing is known: a way on is wider than this share of the place's size.
const SHADE_SHARE: f64 = 1.5;
/// Nothing seen is a way on even where the wall turns as little as this.
const DARK_TURN_RAD: f64 = 15.0 * PI / 180.0;
/// Turns are known to within this much.
const DOUBT_RAD: f64 = 5.0 * PI / 180.0;
/// How decided a verdict is at least, and one on pieces without directions.
const LEAST_DECIDED: f64 = 1.05;
const WITHOUT_DIRECTION: f64 = 3.0;
/// A piece without a direction belongs to a wall if it lies within this of its line, plus a share of the distance.
const OFF_LINE_M: f64 = 0.3;
const OFF_LINE_SHARE: f64 = 0.15;
/// Two pieces without direction belong together along a line of sight: a wall at grazing incidence. Share of their
/// distance that is along the beams, and the largest distance.
const GRAZING_SHARE: f64 = 0.8;
const GRAZING_M: f64 = 3.0;

/// What is asked of a gap; see the parameters of the stage.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    pub(super) passage_m: f64,
    pub(super) stretch_m: f64,
    pub(super) straight_rad: f64,
    pub(super) way_rad: f64,
    pub(super) clear_share: f64,
}

/// Judges the gaps of one scan.
#[derive(Clone, Copy, Debug)]
pub(super) struct Judge<'a> {
    ring: &'a Ring,
    /// Those of the same ring.
    tangents: &'a RefCell<Tangents>,
    islands: &'a Pieces,
    limits: Limits,
    /// The size of the place: the median range, or [`HALL_M`] if that is less.
    size_m: f64,
    /// The most beams that are lost in a row where a wall clearly goes on.
    lost_beams: u32,
}

/// How much a wall turns left at a gap: at its nearer end, at its farther one, and in all.
#[derive(Clone, Copy)]
struct Turns {
    near_rad: f64,
    far_rad: f64,
    whole_rad: f64,
}

/// A gap between two pieces that have directions.
struct Bend {
    before: Position,
    /// From the end of the one piece to the start of the other.
    chord: Position,
    after: Position,
}

impl<'a> Judge<'a> {
    /// Learns the size of the place, and how many beams get lost, from the pieces of its walls.
    pub(super) fn new(
        ring: &'a Ring,
        tangents: &'a RefCell<Tangents>,
        pieces: &Pieces,
        islands: &'a Pieces,
        limits: Limits,
    ) -> Self {
        tangents.borrow_mut().start(ring, limits.stretch_m);
        let mut ranges_m: Vec<f64> = pieces.returns().iter().map(|&i| ring.range_m(i)).collect();
        let middle = ranges_m.len() / 2;
        let median_m =
            if ranges_m.is_empty() { 0.0 } else { *ranges_m.select_nth_unstable_by(middle, f64::total_cmp).1 };
        let size_m = median_m.min(HALL_M);
        let mut judge = Self { ring, tangents, islands, limits, size_m, lost_beams: 0 };
        for pair in pieces.iter().flat_map(|piece| piece.windows(2)) {
            judge.lost_beams = judge.lost_beams.max(ring.dark_between(pair[0], pair[1]));
        }
        let gaps = if ring.full_turn { pieces.len() } else { pieces.len().saturating_sub(1) };
        for at in 0..gaps {
            let (a, b) = (&pieces[at], &pieces[(at + 1) % pieces.len()]);
            let lost_beams = ring.dark_between(a[a.len() - 1], b[0]);
            if lost_beams > judge.lost_beams && judge.clearly_goes_on(a, b) {
                judge.lost_beams = lost_beams;
            }
        }
        judge
    }

    fn clearly_goes_on(&self, a: &[usize], b: &[usize]) -> bool {
        let [Some(before), Some(after)] = self.directions(a, b) else { return false };
        let bend = self.bend(a, b, [before, after]);
        let [of_q, of_p] = bend.aside_m();
        let off_m = of_q.abs().max(of_p.abs());
        off_m < LOST_OFF_SHARE * self.size_m && whole_turn_rad(bend.turns_rad()) < LOST_TURN_RAD
    }

    /// The cost at which one wall goes on from the end of piece `a` to the start of piece `b`, anticlockwise; `None`
    /// where a vehicle could pass between them.
    #[inline]
    pub(super) fn cost(&self, a: &[usize], b: &[usize]) -> Option<f64> {
        if self.is_gap(a[a.len() - 1], b[0]) { self.cost_of_gap(a, b) } else { Some(0.0) }
    }

    /// Whether two returns that follow each other are so far from each other that the wall may end between them.
    #[inline]
    pub(super) fn is_gap(&self, p: usize, q: usize) -> bool {
        self.ring.are_apart(p, q, self.limits.passage_m)
    }

    fn cost_of_gap(&self, a: &[usize], b: &[usize]) -> Option<f64> {
        let ring = self.ring;
        let (p, q) = (a[a.len() - 1], b[0]);
        let chord = ring.position_m(q) - ring.position_m(p);
        let chord_m = chord.norm();
        match self.directions(a, b) {
            [Some(before), Some(after)] => {
                let bend = Bend { before, chord, after };
                let turns = self.turns(&bend, (p, q));
                // Whether there is room between the two walls, and the wall turns enough for that to be a way on.
                let is_way = self.room(&bend, (a, b), turns) >= 1.0;
                let detour_rad = turns.near_rad.abs().min(turns.far_rad.abs());
                let far = if chord_m > 3.0 { 0.05 * chord_m } else { 0.0 };
                (!is_way).then(|| 0.1 + turns.whole_rad.abs() + 0.2 * detour_rad + far)
            }
            [None, None] => {
                let along_m = (ring.range_m(q) - ring.range_m(p)).abs();
                let grazing = along_m > GRAZING_SHARE * chord_m && chord_m < GRAZING_M;
                grazing.then_some(1.0 + 0.1 * chord_m)
            }
            [before, after] => {
                let line = before.or(after)?;
                let along_m = line.dot(&chord);
                let off = line.perp(&chord).abs() / (OFF_LINE_M + OFF_LINE_SHARE * along_m);
                (along_m > 0.0 && off < 1.0).then_some(0.3 + off + 0.05 * chord_m)
            }
        }
    }

    /// Whether two walls are apart where they end, or so far away that the clear width may be small: at the end of the
    /// range the sides of a tunnel seem to meet.
    pub(super) fn are_apart(&self, a: &[usize], b: &[usize]) -> bool {
        let (p, q) = (a[a.len() - 1], b[0]);
        let [Some(before), Some(after)] = self.directions(a, b) else { return true };
        let [clear_m, _] = self.clear_and_farther_m(&self.bend(a, b, [before, after]), (p, q));
        clear_m >= PEAK_SHARE * self.size_m || self.is_far(p, q)
    }

    /// How many times the room that a way on needs there is between two walls with directions, if that is enough for
    /// one.
    pub(super) fn way_room(&self, a: &[usize], b: &[usize]) -> Option<f64> {
        let [before, after] = self.directions(a, b);
        let (bend, ends) = (self.bend(a, b, [before?, after?]), (a[a.len() - 1], b[0]));
        let [clear_m, _] = self.clear_and_farther_m(&bend, ends);
        // Where no vehicle fits in, how far the wall turns does not matter.
        if clear_m < self.limits.passage_m && !self.is_blank(ends.0, ends.1) {
            return None;
        }
        Some(self.room(&bend, (a, b), self.turns(&bend, ends))).filter(|&room| room >= 1.0)
    }

    /// How many times the room that a way on needs there is at the gap, if the wall turned as much as that.
    ///
    /// The clear width is the distance of the nearer end from the line of the farther wall. It is small at a bump, and
    /// at a corner of which only the returns are missing; at a branch it is the width of the branch. But where nothing
    /// is seen over so wide an angle that no corner can be missing, the gap is as wide as its ends are apart.
    fn room(&self, bend: &Bend, (a, b): (&[usize], &[usize]), turns: Turns) -> f64 {
        let (p, q) = (a[a.len() - 1], b[0]);
        let [clear_m, farther_aside_m] = self.clear_and_farther_m(bend, (p, q));
        let turns_somewhat = (self.limits.straight_rad..self.limits.way_rad).contains(&turns.whole_rad);
        let is_corner = turns_somewhat && self.is_inner_corner(bend, (a, b));
        let room = match self.share_of_place((a, b), turns, is_corner) {
            None => self.room_before_face(a, b),
            Some(share) => {
                let deep_m = if turns_somewhat && !is_corner { -farther_aside_m } else { 0.0 };
                let seen_inside = (deep_m / clear_m).max(deep_m.min(clear_m) / (SEEN_INSIDE_SHARE * self.size_m));
                seen_inside.max(clear_m / (share * self.size_m))
            }
        };
        let in_front = if turns.whole_rad < CORNER_RAD && self.is_dark(p, q) {
            farther_aside_m / (IN_FRONT_SHARE * self.size_m)
        } else {
            0.0
        };
        let blank = if turns.whole_rad > -DARK_TURN_RAD && self.is_blank(p, q) {
            self.ring.distance_m(p, q) / (BLANK_SHARE * self.size_m)
        } else {
            0.0
        };
        room.max(in_front).min(clear_m / self.limits.passage_m).max(blank)
    }

    /// How many times the room that a way on needs there is before the face of a corner, if one is seen: the far side
    /// of a side passage, seen along the wall that it leaves. Behind the corner that wall goes on as if it had only
    /// been hidden.
    fn room_before_face(&self, a: &[usize], b: &[usize]) -> f64 {
        let (p, q) = (a[a.len() - 1], b[0]);
        let room = self.ring.distance_m(p, q) / (FACE_SHARE * self.size_m);
        if room < 1.0 {
            return 0.0;
        }
        if self.face_turn_rad(a, b) >= FACE_RAD { room } else { 0.0 }
    }

    /// How much the wall turns over [`FACE_M`].
    fn face_turn_rad(&self, a: &[usize], b: &[usize]) -> f64 {
        let ends = [(a, End::Last), (b, End::First)].map(|(piece, end)| tangent(self.ring, piece, end, FACE_M));
        whole_turn_rad(self.bend(a, b, ends).turns_rad())
    }

    /// The angle over which a piece is seen.
    fn span_rad(&self, piece: &[usize]) -> f64 {
        self.ring.beams_from(piece[0], piece[piece.len() - 1]) as f64 * self.ring.step_rad
    }

    /// Whether the farther wall, the other side of the place, meets the line of the nearer one in a corner, with next to
    /// no beam lost before it.
    fn is_inner_corner(&self, bend: &Bend, (a, b): (&[usize], &[usize])) -> bool {
        let ring = self.ring;
        let (p, q) = (a[a.len() - 1], b[0]);
        let (far, end, direction) =
            if ring.range_m(p) < ring.range_m(q) { (b, End::First, bend.after) } else { (a, End::Last, bend.before) };
        if direction.dot(&bend.chord) <= 0.0 || self.is_dark(p, q) || self.is_shaded(p, q) {
            return false;
        }
        let span_rad = self.span_rad(far);
        let bends = || tangent(ring, far, end, BENDING_M).dot(&bend.chord) < 0.0;
        span_rad > AROUND_RAD || (span_rad > ACROSS_RAD && bends())
    }

    /// The clear width of a gap, and how far the end of the farther wall lies to the left of the line of the nearer
    /// one.
    fn clear_and_farther_m(&self, bend: &Bend, (p, q): (usize, usize)) -> [f64; 2] {
        let [of_q, of_p] = bend.aside_m();
        if self.ring.range_m(p) < self.ring.range_m(q) { [of_p.abs(), of_q] } else { [of_q.abs(), of_p] }
    }

    /// How wide a way on is as a share of the place's size, where the wall turns like that; none where it goes on
    /// whatever its width is.
    fn share_of_place(&self, (a, b): (&[usize], &[usize]), turns: Turns, is_corner: bool) -> Option<f64> {
        let (p, q) = (a[a.len() - 1], b[0]);
        if turns.whole_rad >= self.limits.way_rad {
            return Some(WAY_SHARE);
        }
        let behind = (turns.far_rad >= BEHIND_RAD).then_some(BEHIND_SHARE);
        let dark = if self.is_dark(p, q) { self.dark_share((a, b), turns) } else { None };
        let turned = turns.whole_rad >= self.limits.straight_rad && !is_corner && dark.is_none();
        let turned = turned.then(|| if self.is_shaded(p, q) { SHADE_SHARE } else { self.limits.clear_share });
        [behind, dark, turned].into_iter().flatten().min_by(f64::total_cmp)
    }

    /// The same of a gap in which nothing is seen.
    fn dark_share(&self, (a, b): (&[usize], &[usize]), turns: Turns) -> Option<f64> {
        let (p, q) = (a[a.len() - 1], b[0]);
        if turns.near_rad >= RECEDING_RAD && turns.far_rad < GOING_ON_RAD {
            return Some(RECEDING_SHARE);
        }
        if turns.whole_rad >= CORNER_RAD && self.face_turn_rad(a, b) >= DARK_FACE_RAD {
            return Some(WAY_SHARE);
        }
        let share = self.unlost_share(p, q)?;
        if turns.whole_rad >= DARK_TURN_RAD {
            return Some(share);
        }
        (turns.whole_rad > -CORNER_RAD && self.dark_rad(p, q) > WIDE_DARK_RAD).then_some(WIDE_DARK_SHARE)
    }

    /// How decided it is that the gap is a way on: how many times the room that one needs there is, or would be if the
    /// wall turned by [`DOUBT_RAD`] less or more; at least [`LEAST_DECIDED`].
    pub(super) fn decidedness(&self, a: &[usize], b: &[usize]) -> f64 {
        let [Some(before), Some(after)] = self.directions(a, b) else { return WITHOUT_DIRECTION };
        let bend = self.bend(a, b, [before, after]);
        let turns = self.turns(&bend, (a[a.len() - 1], b[0]));
        let rooms = [-DOUBT_RAD, 0.0, DOUBT_RAD].map(|more_rad| {
            let whole_rad = turns.whole_rad + more_rad;
            self.room(&bend, (a, b), Turns { whole_rad, ..turns })
        });
        rooms.into_iter().fold(f64::INFINITY, f64::min).max(LEAST_DECIDED)
    }

    /// How wide a way on is as a share of the place's size, where beams into a gap with nothing seen in it came back
    /// with nothing because there is nothing, rather than being lost.
    fn unlost_share(&self, p: usize, q: usize) -> Option<f64> {
        if self.is_far(p, q) {
            return Some(DARK_SHARE);
        }
        (self.ring.dark_between(p, q) > LOST_TIMES * self.lost_beams).then_some(DARK_NEAR_SHARE)
    }

    /// Whether the gap lies at the end of the range.
    fn is_far(&self, p: usize, q: usize) -> bool {
        self.ring.range_m(p).max(self.ring.range_m(q)) > FAR_SHARE * self.ring.range_max_m
    }

    /// The angle in which nothing is seen.
    fn dark_rad(&self, p: usize, q: usize) -> f64 {
        f64::from(self.ring.dark_between(p, q)) * self.ring.step_rad
    }

    /// Whether nothing is seen in the gap, or most of it.
    fn is_dark(&self, p: usize, q: usize) -> bool {
        self.ring.dark_between(p, q) >= DARK_BEAMS && self.dark_rad(p, q) > DARK_RAD
    }

    /// Whether nothing is seen over so wide an angle that there is nothing, whatever gets lost elsewhere.
    fn is_blank(&self, p: usize, q: usize) -> bool {
        self.dark_rad(p, q) > BLANK_RAD
    }

    /// Whether what is in the gap cannot be seen: half of the beams into it, or more, end at islands, or were lost.
    pub(super) fn is_hidden(&self, p: usize, q: usize) -> bool {
        let dark = self.ring.dark_between(p, q) as usize;
        let is_lost = || !self.is_dark(p, q) || self.unlost_share(p, q).is_none();
        self.is_shaded(p, q) || (2 * dark >= self.ring.beams_from(p, q) && is_lost())
    }

    /// Whether islands hide what is in the gap.
    fn is_shaded(&self, p: usize, q: usize) -> bool {
        self.ring.is_shaded(self.islands.returns(), p, q)
    }

    fn directions(&self, a: &[usize], b: &[usize]) -> [Option<Position>; 2] {
        let of = |piece: &[usize], end| {
            has_direction(self.ring, piece).then(|| self.tangents.borrow_mut().of(self.ring, piece, end))
        };
        [of(a, End::Last), of(b, End::First)]
    }

    fn bend(&self, a: &[usize], b: &[usize], [before, after]: [Position; 2]) -> Bend {
        let chord = self.ring.position_m(b[0]) - self.ring.position_m(a[a.len() - 1]);
        Bend { before, chord, after }
    }

    fn turns(&self, bend: &Bend, (p, q): (usize, usize)) -> Turns {
        let turns_rad @ [before_rad, after_rad] = bend.turns_rad();
        let p_is_nearer = self.ring.range_m(p) < self.ring.range_m(q);
        let (near_rad, far_rad) = if p_is_nearer { (before_rad, after_rad) } else { (after_rad, before_rad) };
        Turns { near_rad, far_rad, whole_rad: whole_turn_rad(turns_rad) }
    }
}

impl Bend {
    /// How much the wall turns left at the one end and at the other.
    fn turns_rad(&self) -> [f64; 2] {
        [turn_rad(self.before, self.chord), turn_rad(self.chord, self.after)]
    }

    /// How far each end lies to the left of the line of the other piece; right is behind that piece, out of sight.
    fn aside_m(&self) -> [f64; 2] {
        [self.before.perp(&self.chord), self.after.perp(&-self.chord)]
    }
}

/// How far the wall turns at the gap, to the left; around a tip it may turn right by more than π.
fn whole_turn_rad([before_rad, after_rad]: [f64; 2]) -> f64 {
    let turn_rad = before_rad + after_rad;
    if turn_rad < -1.15 * PI {
        turn_rad + TAU
    } else if turn_rad > 1.5 * PI {
        turn_rad - TAU
    } else {
        turn_rad
    }
}
