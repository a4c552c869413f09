//! What makes a gap a way on: how much room there is, how much it needs, and by which rule.

use std::f64::consts::PI;

use super::gap::{Gap, Judge, Turns, whole_turn_rad};
use super::tangent::tangent;

/// Walls that turn by less do not make a corner whose returns could be missing.
const CORNER_RAD: f64 = 75.0 * PI / 180.0;

/// [`Rule::Width`], where both walls recede: so wide, as a share of the place's size.
const WAY_SHARE: f64 = 0.3;
/// [`Rule::Width`] in the shadow of islands, where nothing is known.
const SHADE_SHARE: f64 = 1.5;

/// [`Rule::SeenInside`]: clear width and depth, as shares of the place's size.
const SEEN_INSIDE_SHARE: f64 = 0.5;
/// What a bump of smooth walls hides: the shadow that the end of the nearer wall casts on the farther one...
const BUMP_HIDES_M: f64 = 0.3;
/// ...and what one of rough walls hides more, in times their roughness...
const BUMP_HIDES_BUMPS: f64 = 30.0;
/// ...and at a corner.
const BUMP_HIDES_BUMPS_AT_CORNER: f64 = 10.0;

/// [`Rule::Face`]: over so short a stretch...
const FACE_M: f64 = 0.3;
/// ...the wall turns by so much, whatever it does over longer ones...
const FACE_RAD: f64 = 80.0 * PI / 180.0;
/// ...at a gap so wide, as a share of the place's size...
const FACE_SHARE: f64 = 0.75;
/// ...or, in [`Rule::SidePassage`], so many times as wide as the vehicle, which turns into it; less may be a niche.
const SIDE_TIMES: f64 = 2.0;

/// [`Rule::InFront`]: the farther wall ends so far in front of the line of the nearer one, as a share of the place's size.
const IN_FRONT_SHARE: f64 = 0.65;

/// [`Rule::PlainSight`]: the walls turn by so much...
const PLAIN_RAD: f64 = 15.0 * PI / 180.0;
/// ...and the gap is wider than the vehicle by so many times their roughness, as no bump of theirs hides as much...
const PLAIN_BUMPS: f64 = 70.0;
/// ...or by so many where they hardly turn...
const PLAIN_STRAIGHT_BUMPS: f64 = 100.0;
/// ...or if it is so wide, as a share of the place's size.
const PLAIN_STRAIGHT_SHARE: f64 = 1.4;

/// An inner corner hides no more behind it than this...
const INNER_CORNER_HIDES_M: f64 = 0.1;
/// ...and so many times the roughness of the walls: what is seen deeper behind the nearer wall leads on.
const INNER_CORNER_HIDES_BUMPS: f64 = 15.0;
/// Nor is the gap before it wider than this share of the place's size.
const INNER_CORNER_SHARE: f64 = 1.4;
/// A farther wall that is seen over a wider angle than this...
const ACROSS_RAD: f64 = 34.0 * PI / 180.0;
/// ...and turns by more than a right angle over this stretch at its end, is the other side of the place itself.
const BENDING_M: f64 = 4.0;

/// Turns are known to within this much.
const DOUBT_RAD: f64 = 5.0 * PI / 180.0;
/// How decided a verdict is at least, and one on pieces without directions.
const LEAST_DECIDED: f64 = 1.05;
const WITHOUT_DIRECTION: f64 = 3.0;

/// What decides at a gap: why it is a way on, or why none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rule {
    /// Walls without directions.
    NoDirection,
    /// None: the line of the nearer wall goes on.
    Line,
    /// None: the same of its line over a longer stretch.
    LongLine,
    /// None: no vehicle passes before what is seen.
    Slit,
    /// None: the wall turns too little.
    Straight,
    /// None by the rules that a corner rules out: the place ends in one.
    InnerCorner,
    /// The clear width for how much the walls turn.
    Width,
    /// How deep behind the nearer wall the farther one is seen.
    SeenInside,
    /// The face of a corner is seen.
    Face,
    /// A face deep behind the nearer wall, with room for a vehicle.
    SidePassage,
    /// The farther wall is in front, in the dark.
    InFront,
    /// Hardly a beam looks into the gap.
    PlainSight,
    /// The farther wall is seen through a mouth or a door.
    Mouth,
    /// Nothing is seen.
    Blank,
}

impl Rule {
    /// In a few words, as what made it a way on, or might have.
    pub(super) fn words(self) -> &'static str {
        match self {
            Self::NoDirection => "too little is seen for a direction",
            Self::Line => "the line of the nearer wall goes on",
            Self::LongLine => "the line of the nearer wall over 3 m goes on",
            Self::Slit => "a slit",
            Self::Straight => "the wall turns too little",
            Self::InnerCorner => "an inner corner",
            Self::Width => "width for the turn",
            Self::SeenInside => "depth behind the nearer wall",
            Self::Face => "the face of a corner",
            Self::SidePassage => "the face of a side passage",
            Self::InFront => "a wall in front",
            Self::PlainSight => "width in plain sight",
            Self::Mouth => "depth behind a mouth or a door",
            Self::Blank => "nothing is seen",
        }
    }
}

/// How much room there is at a gap, by the rule that finds the most.
#[derive(Clone, Copy, Debug)]
pub(super) struct Room {
    /// How many times the room that a way on needs; 0 if the gap hides nothing.
    pub(super) ratio: f64,
    pub(super) rule: Rule,
}

impl Room {
    fn none(rule: Rule) -> Self {
        Self { ratio: 0.0, rule }
    }

    pub(super) fn is_way(self) -> bool {
        self.ratio >= 1.0
    }

    fn or(self, (rule, ratio): (Rule, f64)) -> Self {
        if ratio > self.ratio { Self { ratio, rule } } else { self }
    }
}

/// What several rules ask of a gap whose walls turn like this.
pub(super) struct Look<'g, 'p> {
    pub(super) gap: &'g Gap<'p>,
    pub(super) turns: Turns,
    /// Nothing is seen in it.
    pub(super) is_dark: bool,
    /// Islands hide what is in it.
    pub(super) is_shaded: bool,
    /// The distance of the nearer end from the line of the farther wall. It is small at a bump, and at a corner of which only
    /// the returns are missing; at a branch it is the width of the branch.
    clear_m: f64,
    /// How far behind the line of the nearer wall the farther one begins; negative in front.
    depth_m: f64,
    /// The walls turn as they do at a branch, neither straight on nor back.
    turns_somewhat: bool,
    /// How deep a bump at the end of the nearer wall hides the farther one.
    bump_hides_m: f64,
    /// The farther wall meets the line of the nearer one in a corner.
    is_corner: bool,
}

impl Look<'_, '_> {
    /// Something is seen in it.
    pub(super) fn is_clear(&self) -> bool {
        !self.is_dark && !self.is_shaded
    }

    /// A vehicle has as much room to both sides.
    pub(super) fn inside_m(&self) -> f64 {
        self.clear_m.min(self.depth_m)
    }
}

impl Judge<'_> {
    /// How many times the room that a way on needs there is between two walls with directions, if that is enough for
    /// one.
    pub(super) fn room_ratio_of_way(&self, a: &[usize], b: &[usize]) -> Option<f64> {
        let gap = self.gap(a, b)?;
        Some(self.room(&gap, gap.turns())).filter(|room| room.is_way()).map(|room| room.ratio)
    }

    /// How decided it is that the gap is a way on: how many times the room that one needs there is, or would be if the
    /// wall turned by [`DOUBT_RAD`] less or more in all; at least [`LEAST_DECIDED`].
    pub(super) fn least_room(&self, a: &[usize], b: &[usize]) -> Room {
        let Some(gap) = self.gap(a, b) else { return Room { ratio: WITHOUT_DIRECTION, rule: Rule::NoDirection } };
        let turns = gap.turns();
        let rooms @ [_, Room { rule, .. }, _] = [-DOUBT_RAD, 0.0, DOUBT_RAD]
            .map(|more_rad| self.room_if(&gap, Turns { whole_rad: turns.whole_rad + more_rad, ..turns }));
        let least = rooms.into_iter().map(|room| room.ratio).fold(f64::INFINITY, f64::min);
        Room { ratio: least.max(LEAST_DECIDED), rule }
    }

    /// How much room there is at the gap.
    pub(super) fn room(&self, gap: &Gap<'_>, turns: Turns) -> Room {
        let room = self.room_if(gap, turns);
        if room.is_way() && self.is_in_long_line(gap) { Room::none(Rule::LongLine) } else { room }
    }

    /// The same if the wall turned as much as that, and its end did not lie on a bump.
    pub(super) fn room_if(&self, gap: &Gap<'_>, turns: Turns) -> Room {
        if self.is_in_line(gap) {
            return Room::none(Rule::Line);
        }
        let look = self.look(gap, turns);
        let share = self.share_of_place(&look);
        let otherwise = match share {
            Some(_) => Rule::Width,
            None if look.is_corner => Rule::InnerCorner,
            None => Rule::Straight,
        };
        let room = Room::none(otherwise)
            .or((Rule::Width, share.map_or(0.0, |share| look.clear_m / (share * self.size_m))))
            .or((Rule::SeenInside, self.room_ratio_seen_inside(&look)))
            .or((Rule::Face, self.room_ratio_before_face(&look, share)))
            .or((Rule::InFront, self.room_ratio_behind_wall_in_front(&look)))
            .or((Rule::PlainSight, self.room_ratio_in_plain_sight(&look)))
            .or((Rule::Mouth, self.room_ratio_in_mouth(&look)));
        let room = Room { ratio: room.ratio.min(look.clear_m / self.limits.passage_m), ..room };
        let room = room.or((Rule::Blank, self.room_ratio_of_blank(gap, turns)));
        if room.is_way() {
            return if look.is_clear() && self.is_slit(gap) { Room::none(Rule::Slit) } else { room };
        }
        room.or((Rule::SidePassage, self.room_ratio_into_side_passage(&look)))
    }

    fn look<'g, 'p>(&self, gap: &'g Gap<'p>, turns: Turns) -> Look<'g, 'p> {
        let [clear_m, farther_aside_m] = gap.clear_and_farther_m();
        let mut look = Look {
            gap,
            turns,
            is_dark: self.is_dark(gap),
            is_shaded: self.is_shaded(gap),
            clear_m,
            depth_m: -farther_aside_m,
            turns_somewhat: (self.limits.straight_rad..self.limits.way_rad).contains(&turns.whole_rad),
            bump_hides_m: f64::INFINITY,
            is_corner: false,
        };
        if look.is_clear() {
            let bumps = if turns.whole_rad < CORNER_RAD { BUMP_HIDES_BUMPS } else { BUMP_HIDES_BUMPS_AT_CORNER };
            look.bump_hides_m = self.shadow_m(gap, BUMP_HIDES_M, bumps);
            let can_hide = look.clear_m < INNER_CORNER_SHARE * self.size_m
                && look.inside_m() < self.shadow_m(gap, INNER_CORNER_HIDES_M, INNER_CORNER_HIDES_BUMPS);
            look.is_corner = look.turns_somewhat && can_hide && self.is_other_side(gap);
        }
        look
    }

    /// How deep behind the nearer wall a bump at its end hides the farther one, so high and so many times the roughness of the
    /// walls: the deeper, the farther that is behind it.
    fn shadow_m(&self, gap: &Gap<'_>, bump_m: f64, bumps: f64) -> f64 {
        (bump_m + bumps * self.ring.roughness.off_m) * gap.far_m / gap.near_m
    }

    /// Whether the farther wall is the other side of the place, which meets the line of the nearer one in a corner.
    pub(super) fn is_other_side(&self, gap: &Gap<'_>) -> bool {
        let (far, end) = gap.farther();
        let direction = if gap.a_is_nearer { gap.after } else { gap.before };
        if direction.dot(&gap.chord) <= 0.0 {
            return false;
        }
        let span_rad = self.ring.beams_from(far[0], far[far.len() - 1]) as f64 * self.ring.step_rad;
        span_rad > ACROSS_RAD && tangent(self.ring, far, end, BENDING_M).dot(&gap.chord) < 0.0
    }

    /// How wide a way on is as a share of the place's size, where the wall turns like that; none where it goes on whatever its
    /// width is.
    fn share_of_place(&self, look: &Look<'_, '_>) -> Option<f64> {
        if look.turns.whole_rad >= self.limits.way_rad {
            return Some(WAY_SHARE);
        }
        let dark = if look.is_dark { self.share_in_the_dark(look.gap, look.turns) } else { None };
        let turned = if look.is_shaded { SHADE_SHARE } else { self.limits.clear_share };
        dark.or((look.turns_somewhat && !look.is_corner).then_some(turned))
    }

    /// How many times the room that a way on needs there is where the farther wall, the far side of a branch, is seen deeper
    /// behind the nearer one than there is room between them, or both are as much as that, or more than a bump hides.
    fn room_ratio_seen_inside(&self, look: &Look<'_, '_>) -> f64 {
        if !look.turns_somewhat || look.is_corner {
            return 0.0;
        }
        let needed_m = look.bump_hides_m.min(SEEN_INSIDE_SHARE * self.size_m);
        (look.depth_m / look.clear_m).max(look.inside_m() / needed_m)
    }

    /// The same before the face of a corner, if one is seen: the far side of a side passage, seen along the wall that it
    /// leaves. Behind the corner that wall goes on as if it had only been hidden. Where nothing is seen, the width of such a
    /// gap tells more, if there is a `share` of the place for it.
    fn room_ratio_before_face(&self, look: &Look<'_, '_>, share: Option<f64>) -> f64 {
        let room = look.gap.chord.norm() / (FACE_SHARE * self.size_m);
        let can_be = !look.is_corner && (share.is_none() || look.is_clear());
        if room >= 1.0 && can_be && self.turns_to_face(look.gap) { room } else { 0.0 }
    }

    /// The same, however narrow that is beside the place, where a vehicle fits in between the nearer wall and all that is
    /// seen of the face and behind it, and no bump hides as much; the face begins deep behind the nearer wall, as that of
    /// no corner does. The line of the farther wall says little here: it is that of the face, or of the wall behind it.
    fn room_ratio_into_side_passage(&self, look: &Look<'_, '_>) -> f64 {
        let is_deep = look.is_clear() && !look.is_corner && look.depth_m > BUMP_HIDES_M;
        let room =
            look.gap.chord.norm() / (SIDE_TIMES * self.limits.passage_m + PLAIN_BUMPS * self.ring.roughness.off_m);
        let is_passage = is_deep && room >= 1.0 && self.turns_to_face(look.gap) && self.fits_into_mouth(look.gap);
        if is_passage { room } else { 0.0 }
    }

    /// Whether the wall turns by [`FACE_RAD`] over [`FACE_M`].
    fn turns_to_face(&self, gap: &Gap<'_>) -> bool {
        whole_turn_rad(self.turns_over_rad(gap.a, gap.b, FACE_M)) >= FACE_RAD
    }

    /// The same at a dark gap whose farther wall is in front of the nearer one, so that it is no wall that goes on.
    fn room_ratio_behind_wall_in_front(&self, look: &Look<'_, '_>) -> f64 {
        let can_be = look.is_dark && look.turns.whole_rad < CORNER_RAD;
        if can_be { -look.depth_m / (IN_FRONT_SHARE * self.size_m) } else { 0.0 }
    }

    /// The same where it is plain to see how wide the gap is: hardly a beam looks into it.
    fn room_ratio_in_plain_sight(&self, look: &Look<'_, '_>) -> f64 {
        let turn_rad = look.turns.whole_rad;
        let turns_enough = (PLAIN_RAD..self.limits.way_rad).contains(&turn_rad);
        if !turns_enough || !look.is_clear() || look.is_corner || !self.has_hardly_a_beam(look.gap) {
            return 0.0;
        }
        let needed_m = |bumps: f64| self.limits.passage_m + bumps * self.ring.roughness.off_m;
        let needed_m = if turn_rad < self.limits.straight_rad {
            needed_m(PLAIN_STRAIGHT_BUMPS).min(PLAIN_STRAIGHT_SHARE * self.size_m)
        } else {
            needed_m(PLAIN_BUMPS)
        };
        look.clear_m / needed_m
    }
}
