//! The measurements at a gap between two pieces of wall.

use std::f64::consts::{PI, TAU};

use crosscut_scan::{Clearance, Directions, End, Position, direction, turn_rad};

use super::context::ScanContext;

/// A gap with one beam in it is narrower than this, two steps of a lidar of 180 beams a turn.
const ONE_BEAM_RAD: f64 = 4.5 * PI / 180.0;

/// A gap is dark if at least this many beams into it came back with nothing.
const DARK_BEAMS: u32 = 4;
/// The beams into a dark gap that came back with nothing span more than this angle.
const DARK_RAD: f64 = 3.5 * PI / 180.0;

/// A wall that turns left by less at a gap goes on behind it. Branches turn by 54° and more.
pub(super) const STRAIGHT_RAD: f64 = 36.0_f64.to_radians();
/// A wall that turns left by more at a gap ends there, unless the gap is narrow. The corner of a dead end turns by 90°.
pub(super) const WAY_RAD: f64 = 115.0_f64.to_radians();
/// Walls that turn by less do not make a corner whose returns could be missing.
pub(super) const CORNER_RAD: f64 = 75.0 * PI / 180.0;

/// A bump at the end of a smooth wall hides the farther wall as deep as if it were this high.
pub(super) const BUMP_HIDES_M: f64 = 0.3;
/// A bump at the end of a rough wall is higher by this many times the roughness of the walls.
const BUMP_HIDES_BUMPS: f64 = 30.0;
/// A bump at a corner of rough walls is higher by this many times their roughness.
pub(super) const BUMP_HIDES_BUMPS_AT_CORNER: f64 = 10.0;

/// The other side of the place is seen over a wider angle than this.
const OTHER_SIDE_RAD: f64 = 34.0 * PI / 180.0;
/// The direction of the other side of the place is taken over this stretch.
const OTHER_SIDE_M: f64 = 4.0;

/// The face of a corner is as short as this stretch.
const FACE_M: f64 = 0.3;
/// Over the stretch of a face, the wall turns by at least this, whatever it does over longer ones.
const FACE_RAD: f64 = 80.0 * PI / 180.0;

/// Left turns beyond 270° are right turns around a tip.
const MOST_LEFT_RAD: f64 = 1.5 * PI;
/// A wall turns right by no more than this around a tip.
const MOST_RIGHT_RAD: f64 = 1.15 * PI;

/// How much a wall turns left at a gap.
#[derive(Clone, Copy)]
pub(super) struct Turns {
    /// At the end that is nearer to the sensor.
    pub(super) near_rad: f64,
    /// At the other end.
    pub(super) far_rad: f64,
    /// In all.
    pub(super) whole_rad: f64,
}

/// A gap between two pieces that have directions there. The nearer wall is the one whose end is nearer to the
/// sensor.
#[derive(Clone, Copy)]
pub(super) struct Gap<'p> {
    pub(super) context: &'p ScanContext<'p>,
    /// The pieces clockwise and anticlockwise of it.
    pub(super) pieces: [&'p [usize]; 2],
    /// The last return of the first piece, and the first of the second.
    pub(super) ends: [usize; 2],
    /// The first piece is the nearer wall.
    pub(super) first_is_nearer: bool,
    /// The ranges of the nearer and of the farther end.
    pub(super) near_m: f64,
    pub(super) far_m: f64,
    /// The unit directions in which the wall runs at the first end, and on from the second.
    directions: [Position; 2],
    /// From the first end to the second.
    pub(super) chord: Position,
    pub(super) turns: Turns,
    /// The two lengths of its [`Clearance`].
    pub(super) clear_m: f64,
    pub(super) depth_m: f64,
    /// How many beams into it came back with nothing.
    pub(super) dark_beams: u32,
    /// Nothing is seen in it: an opening, a door, or lost beams.
    pub(super) is_dark: bool,
    /// Islands hide what is in it.
    pub(super) is_shaded: bool,
}

impl<'p> Gap<'p> {
    /// The gap between two pieces, anticlockwise; `None` if one of them has no direction.
    pub(super) fn between(
        context: &'p ScanContext<'p>,
        a: &'p [usize],
        b: &'p [usize],
        directions: &mut Directions,
    ) -> Option<Self> {
        let [before, after] = ends_run(context, a, b, directions);
        Some(Self::measure(context, [a, b], [before?, after?]))
    }

    /// Measures the gap between two pieces whose ends run in these directions.
    pub(super) fn measure(context: &'p ScanContext<'p>, pieces: [&'p [usize]; 2], directions: [Position; 2]) -> Self {
        let [p_m, q_m] = [pieces[0][pieces[0].len() - 1], pieces[1][0]].map(|end| context.scan.ring.range_m(end));
        Self::measure_from(context, pieces, directions, p_m < q_m)
    }

    /// The gap with the other wall as the nearer one, if its two ends are equally near.
    pub(super) fn by_other_end(&self) -> Option<Self> {
        let other = || Self::measure_from(self.context, self.pieces, self.directions, !self.first_is_nearer);
        (self.near_m == self.far_m).then(other)
    }

    fn measure_from(
        context: &'p ScanContext<'p>,
        pieces: [&'p [usize]; 2],
        directions: [Position; 2],
        first_is_nearer: bool,
    ) -> Self {
        let ring = &context.scan.ring;
        let ends @ [p, q] = [pieces[0][pieces[0].len() - 1], pieces[1][0]];
        let chord = ring.position_m(q) - ring.position_m(p);
        let [p_m, q_m] = ends.map(|end| ring.range_m(end));
        let turns_rad @ [first_rad, second_rad] = turns_rad(directions, chord);
        let [near_rad, far_rad] = if first_is_nearer { turns_rad } else { [second_rad, first_rad] };
        let Clearance { clear_m, depth_m } = Clearance::at(chord, directions, first_is_nearer);
        let dark_beams = ring.dark_between(p, q);
        Self {
            context,
            pieces,
            ends,
            first_is_nearer,
            near_m: p_m.min(q_m),
            far_m: p_m.max(q_m),
            directions,
            chord,
            turns: Turns { near_rad, far_rad, whole_rad: whole_turn_rad(turns_rad, ring.span_rad(p, q)) },
            clear_m,
            depth_m,
            dark_beams,
            is_dark: dark_beams >= DARK_BEAMS && f64::from(dark_beams) * ring.step_rad > DARK_RAD,
            is_shaded: context.scan.islands.shade(ring, p, q),
        }
    }

    /// The gap as it would be if the wall turned left by this much more in all.
    pub(super) fn turned_by(&self, more_rad: f64) -> Self {
        let mut gap = *self;
        gap.turns.whole_rad += more_rad;
        gap
    }

    /// How deep behind the end of the nearer wall a bump hides the farther one.
    pub(super) fn bump_hides_m(&self) -> f64 {
        let bumps = if self.turns.whole_rad < CORNER_RAD { BUMP_HIDES_BUMPS } else { BUMP_HIDES_BUMPS_AT_CORNER };
        self.shadow_m(BUMP_HIDES_M, bumps)
    }

    /// How deep a bump at the end of the nearer wall hides the farther one: the deeper, the farther that is behind it.
    /// The bump is `height_m` high, and by `bumps` times the roughness of the walls higher.
    pub(super) fn shadow_m(&self, height_m: f64, bumps: f64) -> f64 {
        self.context.with_bumps_m(height_m, bumps) * self.far_m / self.near_m
    }

    /// Something is seen in it.
    pub(super) fn is_clear(&self) -> bool {
        !self.is_dark && !self.is_shaded
    }

    /// The wall turns as it does at a branch, neither straight on nor back.
    pub(super) fn turns_like_branch(&self) -> bool {
        (STRAIGHT_RAD..WAY_RAD).contains(&self.turns.whole_rad)
    }

    /// The smallest step of a wall that closes the gap: the clear width or the depth, whichever is less.
    pub(super) fn step_m(&self) -> f64 {
        self.clear_m.min(self.depth_m)
    }

    /// The distance between the two ends.
    pub(super) fn chord_m(&self) -> f64 {
        self.chord.norm()
    }

    /// The angle in which nothing is seen.
    pub(super) fn dark_rad(&self) -> f64 {
        f64::from(self.dark_beams) * self.context.scan.ring.step_rad
    }

    /// Whether the farther wall is the other side of the place, which runs back towards the line of the nearer one.
    pub(super) fn shows_other_side(&self) -> bool {
        let run = self.directions[usize::from(self.first_is_nearer)];
        if run.dot(&self.chord) <= 0.0 {
            return false;
        }
        let (scan, (far, end)) = (self.context.scan, self.farther());
        let span_rad = scan.ring.span_rad(far[0], far[far.len() - 1]);
        span_rad > OTHER_SIDE_RAD
            && direction(&scan.ring, &scan.roughness, far, end, OTHER_SIDE_M).dot(&self.chord) < 0.0
    }

    /// Whether the wall turns to the face of a corner: over a short stretch, by nearly a right angle.
    pub(super) fn turns_to_face(&self) -> bool {
        self.face_turn_rad() >= FACE_RAD
    }

    /// How much the wall turns in all by the directions of its ends over the stretch of a face.
    pub(super) fn face_turn_rad(&self) -> f64 {
        let (scan, [a, b], [p, q]) = (self.context.scan, self.pieces, self.ends);
        let directions = [(a, End::Last), (b, End::First)]
            .map(|(piece, end)| direction(&scan.ring, &scan.roughness, piece, end, FACE_M));
        whole_turn_rad(turns_rad(directions, self.chord), scan.ring.span_rad(p, q))
    }

    /// Whether at most one beam looks into the gap, over an angle so narrow that this does not mean that nothing is
    /// seen: a beam that came back with nothing, from dust or from a small piece, shows nothing.
    pub(super) fn holds_one_beam_at_most(&self) -> bool {
        let ring = &self.context.scan.ring;
        let steps = ring.beams_from(self.ends[0], self.ends[1]);
        steps == 1 || (steps == 2 && 2.0 * ring.step_rad < ONE_BEAM_RAD)
    }

    /// The return at the nearer end, and that at the farther one.
    pub(super) fn near_and_far_end(&self) -> [usize; 2] {
        let [p, q] = self.ends;
        if self.first_is_nearer { [p, q] } else { [q, p] }
    }

    /// The angle over which the nearer wall is seen.
    pub(super) fn near_span_rad(&self) -> f64 {
        let (near, _) = self.nearer();
        self.context.scan.ring.span_rad(near[0], near[near.len() - 1])
    }

    /// The direction in which the nearer wall runs towards its end.
    pub(super) fn nearer_onward(&self) -> Position {
        if self.first_is_nearer { self.directions[0] } else { -self.directions[1] }
    }

    /// The nearer piece, and its end at the gap.
    pub(super) fn nearer(&self) -> (&'p [usize], End) {
        if self.first_is_nearer { (self.pieces[0], End::Last) } else { (self.pieces[1], End::First) }
    }

    /// The farther piece, and its end at the gap.
    fn farther(&self) -> (&'p [usize], End) {
        if self.first_is_nearer { (self.pieces[1], End::First) } else { (self.pieces[0], End::Last) }
    }
}

/// The directions in which a wall runs at the end of piece `a` and on from the start of piece `b`, if they have one.
pub(super) fn ends_run(
    context: &ScanContext<'_>,
    a: &[usize],
    b: &[usize],
    directions: &mut Directions,
) -> [Option<Position>; 2] {
    let (ring, roughness) = (&context.scan.ring, &context.scan.roughness);
    [(a, End::Last), (b, End::First)].map(|(piece, end)| directions.of(ring, roughness, piece, end))
}

/// How much a wall turns left at the one end of a gap and at the other.
fn turns_rad([before, after]: [Position; 2], chord: Position) -> [f64; 2] {
    [turn_rad(before, chord), turn_rad(chord, after)]
}

/// How far the wall turns left in all; around a tip it may turn right by more than π. A wall across more than half of what
/// is around the sensor goes around the sensor, and not along the chord: it turns by as much as its bearing does, to within π.
fn whole_turn_rad([first_rad, second_rad]: [f64; 2], span_rad: f64) -> f64 {
    let turn_rad = first_rad + second_rad;
    if span_rad > PI {
        span_rad - PI + (turn_rad - span_rad + PI).rem_euclid(TAU)
    } else if turn_rad < -MOST_RIGHT_RAD {
        turn_rad + TAU
    } else if turn_rad > MOST_LEFT_RAD {
        turn_rad - TAU
    } else {
        turn_rad
    }
}
