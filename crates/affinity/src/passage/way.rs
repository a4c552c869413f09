//! What makes a gap a way on: how much room there is, and how much it needs.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use super::gap::{Gap, Judge, Turns, whole_turn_rad};
use super::ring::{Position, Ring, turn_rad};
use super::tangent::tangent;

// Widths are shares of the place's size: so wide at least is a gap that is a way on.

/// Both walls recede from each other.
const WAY_SHARE: f64 = 0.3;
/// In the shadow of islands nothing is known.
const SHADE_SHARE: f64 = 1.5;
/// The farther wall is the far side of a branch: it is seen behind the nearer one deeper than there is room between
/// them, or both are that much;
const SEEN_INSIDE_SHARE: f64 = 0.5;
/// or, however narrow that is beside the place, deeper than a bump hides: this, and so many times the roughness of the walls,
/// fewer at a corner, in the shadow that the end of the nearer wall casts on the farther one.
const INSIDE_M: f64 = 0.3;
const INSIDE_BUMPS: f64 = 30.0;
const INSIDE_CORNER_BUMPS: f64 = 10.0;
/// The face of a corner: over so short a stretch the wall turns by so much, whatever it does over longer ones.
const FACE_M: f64 = 0.3;
const FACE_RAD: f64 = 80.0 * PI / 180.0;
const FACE_SHARE: f64 = 0.75;
/// A side passage is so many times as wide as the vehicle, which turns into it; less may be a niche.
const SIDE_TIMES: f64 = 2.0;

/// Where hardly a beam looks between two walls that turn by this much, a gap is a way on in any place if it is wider than
/// the vehicle by so many times the roughness of the walls, more where they hardly turn: no bump of theirs hides as much.
const PLAIN_RAD: f64 = 15.0 * PI / 180.0;
const PLAIN_BUMPS: f64 = 70.0;
const PLAIN_STRAIGHT_BUMPS: f64 = 100.0;

/// The nearer wall hides nothing if the next beam meets the farther one no farther behind its line than this share of the
/// angle at which that wall is seen: a beam that passes its end goes on behind the line at the whole angle.
const BEHIND_LINE_SHARE: f64 = 0.3;
/// The same of the beam after the next, where that one says nothing.
const NEXT_BEHIND_LINE_SHARE: f64 = 0.1;
/// What it meets is no farther away than so many times the spacing of so many returns before it, nor than so many times the
/// place's size.
const REACH_TIMES: f64 = 2.5;
const REACH_SPACINGS: usize = 2;
const REACH_SHARE: f64 = 6.0;
/// Its line is also taken over this length, where it strays from it by no more than so many times the roughness of the walls.
const LONG_M: f64 = 3.0;
const LONG_BUMPS: f64 = 4.0;

/// A farther wall that is seen over a wider angle than this, and turns by more than a right angle over this stretch at its
/// end, is the other side of the place itself: where it meets the line of the nearer one, the place ends in a corner.
const ACROSS_RAD: f64 = 34.0 * PI / 180.0;
const BENDING_M: f64 = 4.0;

/// Nothing is seen in a gap into which so many beams, over so wide an angle, came back with nothing.
const DARK_BEAMS: u32 = 4;
const DARK_RAD: f64 = 3.5 * PI / 180.0;
/// There is nothing if one of its ends lies farther than this share of the sensor's range,
const FAR_SHARE: f64 = 0.8;
/// or if they are so many times more than are lost in a row where a wall clearly goes on.
const LOST_TIMES: u32 = 2;
/// That is a way on at the end of the range, and nearer, where a dark surface is as likely,
const DARK_SHARE: f64 = 0.45;
const DARK_NEAR_SHARE: f64 = 0.7;
/// if the wall turns by this much.
const DARK_TURN_RAD: f64 = 15.0 * PI / 180.0;
/// Whatever is lost elsewhere, a gap in which nothing is seen is a way on if the wall turns by less than a corner, so that
/// none can be missing, and the farther wall ends so far in front of the line of the nearer one.
const CORNER_RAD: f64 = 75.0 * PI / 180.0;
const IN_FRONT_SHARE: f64 = 0.65;
/// No patch of lost beams explains that nothing is seen over more than this angle, or, far off, over so wide a patch of
/// more beams than get lost elsewhere, and no corner hides in it. The width of the gap is that between its ends.
const BLANK_RAD: f64 = 30.0 * PI / 180.0;
/// Where the wall hardly turns, such an angle is no wider than so many gaps at the end of the range: beams that slant into a
/// way on meet its sides.
const BEHIND_BLANK: f64 = 2.5;
const FAR_OFF_SHARE: f64 = 2.5;
const PATCH_SHARE: f64 = 0.78;
const BLANK_SHARE: f64 = 0.9;
/// Where several beams in a row are lost at no more places than this, a gap in which nothing is seen is a door, if it is so
/// many times as wide as the vehicle, and is seen at more than 45°. It is such a place itself, where the wall clearly goes on
/// behind it.
const LOSSY_PLACES: u32 = 1;
const DOOR_SHARE: f64 = 1.75;
const ACROSS: f64 = FRAC_1_SQRT_2;
/// Behind it, as far as the sensor sees, the place is no wider than this: about as wide as a tunnel of this size.
const BEHIND_DOOR_SHARE: f64 = 1.5;

impl Judge<'_> {
    /// How many times the room that a way on needs there is at the gap; 0 if it hides nothing.
    pub(super) fn room_ratio(&self, gap: &Gap<'_>, turns: Turns) -> f64 {
        let room = self.room_ratio_if(gap, turns);
        if room >= 1.0 && self.is_in_long_line(gap) { 0.0 } else { room }
    }

    /// The same if the wall turned as much as that, and its end did not lie on a bump.
    ///
    /// The clear width is the distance of the nearer end from the line of the farther wall. It is small at a bump, and
    /// at a corner of which only the returns are missing; at a branch it is the width of the branch. But where nothing
    /// is seen over so wide an angle that no corner can be missing, the gap is as wide as its ends are apart.
    pub(super) fn room_ratio_if(&self, gap: &Gap<'_>, turns: Turns) -> f64 {
        if self.is_in_line(gap) {
            return 0.0;
        }
        let (is_dark, is_shaded) = (self.is_dark(gap.ends), self.is_shaded(gap.ends));
        let is_clear = !is_dark && !is_shaded;
        let [clear_m, farther_aside_m] = gap.clear_and_farther_m();
        let inside_m = clear_m.min(-farther_aside_m);
        let bump_hides_m = if is_clear { self.bump_hides_m(gap, turns) } else { f64::INFINITY };
        let turns_somewhat = (self.limits.straight_rad..self.limits.way_rad).contains(&turns.whole_rad);
        let is_corner = turns_somewhat && is_clear && inside_m < bump_hides_m && self.is_inner_corner(gap);
        let turned = turns.whole_rad >= self.limits.straight_rad && !is_corner;
        let turned = turned.then_some(if is_shaded { SHADE_SHARE } else { self.limits.clear_share });
        let share = self.share_of_place(gap, turns, is_dark, turned);
        let by_width = share.map_or(0.0, |share| clear_m / (share * self.size_m));
        let seen_inside = if turns_somewhat && !is_corner {
            (-farther_aside_m / clear_m).max(inside_m / bump_hides_m.min(SEEN_INSIDE_SHARE * self.size_m))
        } else {
            0.0
        };
        let sees_face = !is_corner && (share.is_none() || is_clear);
        let before_face = if sees_face { self.room_ratio_before_face(gap) } else { 0.0 };
        let in_front = if turns.whole_rad < CORNER_RAD && is_dark {
            farther_aside_m / (IN_FRONT_SHARE * self.size_m)
        } else {
            0.0
        };
        let plain = if is_clear && !is_corner { self.room_ratio_in_plain_sight(gap, turns, clear_m) } else { 0.0 };
        let in_mouth = if is_clear { self.room_ratio_in_mouth(gap, turns, inside_m) } else { 0.0 };
        let blank_needs_m =
            self.blank_needs_m(gap.ends, || turns.whole_rad).filter(|_| turns.whole_rad > -DARK_TURN_RAD);
        let blank = blank_needs_m.map_or(0.0, |needed_m| gap.chord.norm() / needed_m);
        let room = [by_width, seen_inside, before_face, in_front, plain, in_mouth].into_iter().fold(0.0, f64::max);
        let room = room.min(clear_m / self.limits.passage_m).max(blank);
        if room >= 1.0 && is_clear && self.is_slit(gap) {
            return 0.0;
        }
        let is_deep = is_clear && !is_corner && farther_aside_m < -INSIDE_M;
        if room < 1.0 && is_deep { room.max(self.room_ratio_into_side_passage(gap)) } else { room }
    }

    /// How deep behind the nearer wall a bump at its end hides the farther one: the deeper, the farther that is behind it.
    fn bump_hides_m(&self, gap: &Gap<'_>, turns: Turns) -> f64 {
        let bumps = if turns.whole_rad < CORNER_RAD { INSIDE_BUMPS } else { INSIDE_CORNER_BUMPS };
        (INSIDE_M + bumps * self.roughness_m) * self.farther_m(gap.ends) / self.nearer_m(gap.ends)
    }

    /// How many times the room that a way on needs there is before the face of a corner, if one is seen: the far side
    /// of a side passage, seen along the wall that it leaves. Behind the corner that wall goes on as if it had only
    /// been hidden.
    fn room_ratio_before_face(&self, gap: &Gap<'_>) -> f64 {
        let room = gap.chord.norm() / (FACE_SHARE * self.size_m);
        if room >= 1.0 && self.face_turn_rad(gap) >= FACE_RAD { room } else { 0.0 }
    }

    /// The same, however narrow that is beside the place, where a vehicle fits in between the nearer wall and all that is
    /// seen of the face and behind it, and no bump hides as much; the face begins deep behind the nearer wall, as that of
    /// no corner does. The line of the farther wall says little here: it is that of the face, or of the wall behind it.
    fn room_ratio_into_side_passage(&self, gap: &Gap<'_>) -> f64 {
        let room = gap.chord.norm() / (SIDE_TIMES * self.limits.passage_m + PLAIN_BUMPS * self.roughness_m);
        let is_passage = room >= 1.0 && self.face_turn_rad(gap) >= FACE_RAD && self.fits_into_mouth(gap);
        if is_passage { room } else { 0.0 }
    }

    /// The same where it is plain to see how wide the gap is: hardly a beam looks into it.
    fn room_ratio_in_plain_sight(&self, gap: &Gap<'_>, turns: Turns, clear_m: f64) -> f64 {
        let bumps = if turns.whole_rad < self.limits.straight_rad { PLAIN_STRAIGHT_BUMPS } else { PLAIN_BUMPS };
        let turns_enough = (PLAIN_RAD..self.limits.way_rad).contains(&turns.whole_rad);
        let is_plain = turns_enough && has_hardly_a_beam(self.ring, gap);
        if is_plain { clear_m / (self.limits.passage_m + bumps * self.roughness_m) } else { 0.0 }
    }

    /// How much the wall turns over [`FACE_M`].
    fn face_turn_rad(&self, gap: &Gap<'_>) -> f64 {
        whole_turn_rad(self.turns_over_rad(gap.a, gap.b, FACE_M))
    }

    /// Whether what the next beam meets is where the line of the nearer wall goes on, or in front of it. So it is in the
    /// corner of a dead end, along whose sides returns are far apart only because they are seen at a grazing angle.
    fn is_in_line(&self, gap: &Gap<'_>) -> bool {
        has_hardly_a_beam(self.ring, gap) && self.goes_on_along(gap, gap.nearer_onward())
    }

    /// The same of the line over [`LONG_M`], if the wall is straight there: its end may lie on a bump.
    fn is_in_long_line(&self, gap: &Gap<'_>) -> bool {
        has_hardly_a_beam(self.ring, gap) && self.long_line(gap).is_some_and(|onward| self.goes_on_along(gap, onward))
    }

    /// Whether the farther wall begins about where the nearer one would go on, which runs towards its end in this direction:
    /// in front of that line by less than `straight_deg`, or behind it by less than [`BEHIND_LINE_SHARE`], or
    /// [`NEXT_BEHIND_LINE_SHARE`].
    fn goes_on_along(&self, gap: &Gap<'_>, onward: Position) -> bool {
        let (p, q) = gap.ends;
        let (end, turned_rad) =
            if gap.a_is_nearer { (p, turn_rad(onward, gap.chord)) } else { (q, turn_rad(gap.chord, -onward)) };
        let seen_at_rad = turn_rad(onward, self.ring.position_m(end)).abs();
        let share = if self.ring.beams_from(p, q) == 1 { BEHIND_LINE_SHARE } else { NEXT_BEHIND_LINE_SHARE };
        (-share * seen_at_rad..self.limits.straight_rad).contains(&turned_rad) && self.is_in_reach(gap)
    }

    /// Whether the farther wall begins about where the next beam would meet the nearer one, if that went straight on. Past
    /// the inner wall of a bend, along whose line it looks, a beam meets the outer one much farther away.
    fn is_in_reach(&self, gap: &Gap<'_>) -> bool {
        let (near, end) = gap.nearer();
        let (last, before) = (end.at(near, 0), end.at(near, REACH_SPACINGS.min(near.len() - 1)));
        let next_m = self.ring.spacing_m(last, before) * self.ring.beams_from(gap.ends.0, gap.ends.1) as f64;
        gap.chord.norm() <= (REACH_TIMES * next_m).min(REACH_SHARE * self.size_m)
    }

    /// The direction in which the nearer wall runs towards its end over [`LONG_M`], if it is straight there.
    fn long_line(&self, gap: &Gap<'_>) -> Option<Position> {
        let (near, end) = gap.nearer();
        let from_end_m = |k: usize| self.ring.position_m(end.at(near, k)) - self.ring.position_m(end.at(near, 0));
        let far = (1..near.len()).find(|&k| from_end_m(k).norm_squared() >= LONG_M * LONG_M)?;
        let onward = -from_end_m(far).normalize();
        let is_straight = (1..far).all(|k| onward.perp(&from_end_m(k)).abs() <= LONG_BUMPS * self.roughness_m);
        is_straight.then_some(onward)
    }

    /// Whether the farther wall meets the line of the nearer one in a corner.
    pub(super) fn is_inner_corner(&self, gap: &Gap<'_>) -> bool {
        let (far, end) = gap.farther();
        let direction = if gap.a_is_nearer { gap.after } else { gap.before };
        if direction.dot(&gap.chord) <= 0.0 {
            return false;
        }
        let span_rad = self.ring.beams_from(far[0], far[far.len() - 1]) as f64 * self.ring.step_rad;
        span_rad > ACROSS_RAD && tangent(self.ring, far, end, BENDING_M).dot(&gap.chord) < 0.0
    }

    /// How wide a way on is as a share of the place's size, where the wall turns like that, `turned` unless something
    /// else tells; none where it goes on whatever its width is.
    fn share_of_place(&self, gap: &Gap<'_>, turns: Turns, is_dark: bool, turned: Option<f64>) -> Option<f64> {
        if turns.whole_rad >= self.limits.way_rad {
            return Some(WAY_SHARE);
        }
        let dark = if is_dark && turns.whole_rad >= DARK_TURN_RAD { self.unlost_share(gap.ends) } else { None };
        dark.or(turned)
    }

    /// How wide a way on is as a share of the place's size, where beams into a gap with nothing seen in it came back
    /// with nothing because there is nothing, rather than being lost.
    fn unlost_share(&self, (p, q): (usize, usize)) -> Option<f64> {
        if self.is_far((p, q)) {
            return Some(DARK_SHARE);
        }
        self.is_unlost((p, q)).then_some(DARK_NEAR_SHARE)
    }

    /// Whether [`LOST_TIMES`] as many beams came back with nothing as get lost elsewhere, or more.
    fn is_unlost(&self, (p, q): (usize, usize)) -> bool {
        self.ring.dark_between(p, q) > LOST_TIMES * self.lost_beams
    }

    /// Whether the gap lies at the end of the range.
    fn is_far(&self, (p, q): (usize, usize)) -> bool {
        self.farther_m((p, q)) > FAR_SHARE * self.ring.range_max_m
    }

    /// The range of the farther end of a gap.
    fn farther_m(&self, (p, q): (usize, usize)) -> f64 {
        self.ring.range_m(p).max(self.ring.range_m(q))
    }

    /// The range of the nearer end of a gap.
    fn nearer_m(&self, (p, q): (usize, usize)) -> f64 {
        self.ring.range_m(p).min(self.ring.range_m(q))
    }

    /// The angle in which nothing is seen.
    fn dark_rad(&self, (p, q): (usize, usize)) -> f64 {
        f64::from(self.ring.dark_between(p, q)) * self.ring.step_rad
    }

    /// Whether so many beams into the gap came back with nothing that what is there is not seen.
    fn is_dark(&self, (p, q): (usize, usize)) -> bool {
        self.ring.dark_between(p, q) >= DARK_BEAMS && self.dark_rad((p, q)) > DARK_RAD
    }

    /// Whether a gap is one across the line of sight in which nothing is seen, well before the end of the range, and what
    /// lies behind it need not be wider than this place for that.
    fn is_door(&self, (p, q): (usize, usize)) -> bool {
        let (from_m, to_m) = (self.ring.position_m(p), self.ring.position_m(q));
        let (chord, middle_m) = (to_m - from_m, 0.5 * (from_m + to_m));
        let is_across = chord.perp(&middle_m).abs() > ACROSS * chord.norm() * middle_m.norm();
        let is_near = self.nearer_m((p, q)) < FAR_SHARE * self.ring.range_max_m;
        let behind_m = self.dark_rad((p, q)) * self.ring.range_max_m;
        let is_empty = self.is_dark((p, q)) && !self.is_shaded((p, q));
        is_empty && is_across && is_near && behind_m < BEHIND_DOOR_SHARE * self.size_m
    }

    /// How far apart the ends of a gap must be for it to be a way on because nothing is seen in it; `None` if that is no
    /// reason: it is neither a door, nor dark over so wide an angle, nor, far off, over so wide a patch.
    pub(super) fn blank_needs_m(&self, ends: (usize, usize), turn_rad: impl FnOnce() -> f64) -> Option<f64> {
        let is_door = self.lossy_places <= LOSSY_PLACES && self.is_door(ends);
        let door_m = is_door.then_some(DOOR_SHARE * self.limits.passage_m);
        let (dark_rad, nearer_m) = (self.dark_rad(ends), self.nearer_m(ends));
        let behind_m = dark_rad * self.ring.range_max_m;
        let is_as_of_way = || behind_m < BEHIND_BLANK * self.ring.distance_m(ends.0, ends.1);
        let is_wide = dark_rad > BLANK_RAD && (is_as_of_way() || turn_rad() > DARK_TURN_RAD);
        let patch_m = if nearer_m > FAR_OFF_SHARE * self.size_m { dark_rad * nearer_m } else { 0.0 };
        let is_blank = is_wide || (patch_m > PATCH_SHARE * self.size_m && self.is_unlost(ends));
        let blank_m = is_blank.then_some(BLANK_SHARE * self.size_m);
        [door_m, blank_m].into_iter().flatten().min_by(f64::total_cmp)
    }
}

/// Whether at most one beam looks into the gap, and the angle is not so wide that this means that nothing is seen in it: one
/// that came back with nothing, from the air or from too little to be a wall, says nothing.
fn has_hardly_a_beam(ring: &Ring, gap: &Gap<'_>) -> bool {
    let steps = ring.beams_from(gap.ends.0, gap.ends.1);
    steps == 1 || (steps == 2 && 2.0 * ring.step_rad < DARK_RAD)
}
