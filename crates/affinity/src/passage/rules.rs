//! The rules at a gap: how much room there is for a way on, divided by how much one needs.

use std::f64::consts::PI;

use super::dark::room_in_blank;
use super::gap::{BUMP_HIDES_M, CORNER_RAD, Gap};
use super::mouth::room_behind_mouth;
use super::verdict::{Decision, Reason};

/// A way on between two walls that recede is at least this share of the place's size wide.
const WAY_SHARE: f64 = 0.3;
/// A way on in the shadow of islands, where nothing is known, is at least this share of the place's size wide.
const SHADE_SHARE: f64 = 1.5;
/// A way on whose inside is seen need not be wider or deeper than this share of the place's size.
const SEEN_INSIDE_SHARE: f64 = 0.5;
/// A gap before the face of a corner is at least this share of the place's size long.
const FACE_SHARE: f64 = 0.75;
/// A gap before the face of a side passage is this many times as long as the vehicle is wide, which turns into it; a
/// shorter one may be a niche.
const SIDE_TIMES: f64 = 2.0;
/// A farther wall that is another one ends in front of the line of the nearer one by at least this share of the place's
/// size.
const IN_FRONT_SHARE: f64 = 0.65;
/// Walls beside a gap in plain sight turn by at least this.
const PLAIN_RAD: f64 = 15.0 * PI / 180.0;
/// A gap in plain sight is wider than the vehicle by this many times the roughness of the walls: no bump hides as much.
const PLAIN_BUMPS: f64 = 70.0;
/// Where the walls hardly turn, a gap in plain sight is wider by this many times the roughness of the walls.
const PLAIN_STRAIGHT_BUMPS: f64 = 100.0;
/// Where the walls hardly turn, a gap in plain sight need not be wider than this share of the place's size.
const PLAIN_STRAIGHT_SHARE: f64 = 1.4;

/// A way to find room at a gap.
struct Rule {
    reason: Reason,
    /// The room that there is, divided by the room that a way on needs; 0 where the rule does not apply.
    room_ratio: fn(&Gap<'_>) -> f64,
}

/// The rules that count only where the clear width is that of a vehicle. The one that finds the most room decides; of
/// equal ones, the first.
const RULES: [Rule; 6] = [
    Rule { reason: Reason::Width, room_ratio: room_in_width },
    Rule { reason: Reason::SeenInside, room_ratio: room_inside },
    Rule { reason: Reason::Face, room_ratio: room_before_face },
    Rule { reason: Reason::InFront, room_ratio: room_behind_wall_in_front },
    Rule { reason: Reason::PlainSight, room_ratio: room_in_plain_sight },
    Rule { reason: Reason::Mouth, room_ratio: room_behind_mouth },
];

impl Gap<'_> {
    /// How much room there is.
    pub(super) fn decide(&self) -> Decision {
        let decision = self.decide_by_end();
        if decision.is_way() && self.is_in_long_line() { Decision::no_room(Reason::LongLine) } else { decision }
    }

    /// How much room there is if the end of the nearer wall does not lie on a bump.
    pub(super) fn decide_by_end(&self) -> Decision {
        if self.is_in_line() {
            return Decision::no_room(Reason::Line);
        }
        let none = Decision::no_room(match self.way_share() {
            Some(_) => Reason::Width,
            None if self.is_corner => Reason::InnerCorner,
            None => Reason::Straight,
        });
        let most = RULES.iter().fold(none, |most, rule| most.or(rule.reason, (rule.room_ratio)(self)));
        let clear = Decision { room_ratio: most.room_ratio.min(self.clear_m / self.site.passage_m()), ..most };
        let decision = clear.or(Reason::Blank, room_in_blank(self));
        if !decision.is_way() {
            decision.or(Reason::SidePassage, room_into_side_passage(self))
        } else if self.is_clear() && self.is_slit() {
            Decision::no_room(Reason::Slit)
        } else {
            decision
        }
    }

    /// How wide a way on is at least, as a share of the place's size, where the wall turns like this; `None` where the
    /// wall goes on whatever the width is.
    fn way_share(&self) -> Option<f64> {
        if self.turns.whole_rad >= self.site.thresholds.way_rad {
            return Some(WAY_SHARE);
        }
        let turned = if self.is_shaded { SHADE_SHARE } else { self.site.thresholds.clear_share };
        self.dark_way_share().or((self.turns_like_branch() && !self.is_corner).then_some(turned))
    }
}

/// The clear width is enough for how much the walls turn.
fn room_in_width(gap: &Gap<'_>) -> f64 {
    gap.way_share().map_or(0.0, |share| gap.clear_m / (share * gap.site.scan.size_m))
}

/// The farther wall, the far side of a branch, is seen deep behind the nearer one: deeper than the clear width; or
/// width and depth are both more than a bump hides, or large beside the place.
fn room_inside(gap: &Gap<'_>) -> f64 {
    if !gap.turns_like_branch() || gap.is_corner {
        return 0.0;
    }
    let needed_m = gap.bump_hides_m.min(SEEN_INSIDE_SHARE * gap.site.scan.size_m);
    (gap.depth_m / gap.clear_m).max(gap.room_m() / needed_m)
}

/// The face of a corner is seen, the far side of a side passage, along the wall that it leaves. Behind the corner that
/// wall goes on as if it had only been hidden. Where nothing is seen, the width decides, if a way on there has one.
fn room_before_face(gap: &Gap<'_>) -> f64 {
    let room_ratio = gap.chord_m() / (FACE_SHARE * gap.site.scan.size_m);
    let may_show_face = !gap.is_corner && (gap.is_clear() || gap.way_share().is_none());
    if room_ratio >= 1.0 && may_show_face && gap.turns_to_face() { room_ratio } else { 0.0 }
}

/// A vehicle fits between the nearer wall and a face that begins deep behind it, as that of no corner does, and no bump
/// hides as much. The line of the farther wall shows little: it is that of the face, or of the wall behind it.
fn room_into_side_passage(gap: &Gap<'_>) -> f64 {
    let is_deep = gap.is_clear() && !gap.is_corner && gap.depth_m > BUMP_HIDES_M;
    let room_ratio = gap.chord_m() / gap.site.with_bumps_m(SIDE_TIMES * gap.site.passage_m(), PLAIN_BUMPS);
    let is_passage = is_deep && room_ratio >= 1.0 && gap.turns_to_face() && gap.fits_vehicle();
    if is_passage { room_ratio } else { 0.0 }
}

/// The farther wall of a dark gap begins so far in front of the nearer one that it is another wall.
fn room_behind_wall_in_front(gap: &Gap<'_>) -> f64 {
    let is_straight_and_dark = gap.is_dark && gap.turns.whole_rad < CORNER_RAD;
    if is_straight_and_dark { -gap.depth_m / (IN_FRONT_SHARE * gap.site.scan.size_m) } else { 0.0 }
}

/// Hardly a beam looks into the gap, so that its width is plain to see.
fn room_in_plain_sight(gap: &Gap<'_>) -> f64 {
    let (site, turn_rad) = (gap.site, gap.turns.whole_rad);
    let turns_enough = (PLAIN_RAD..site.thresholds.way_rad).contains(&turn_rad);
    if !turns_enough || !gap.is_clear() || gap.is_corner || !gap.holds_one_beam_at_most() {
        return 0.0;
    }
    let needed_m = if turn_rad < site.thresholds.straight_rad {
        site.with_bumps_m(site.passage_m(), PLAIN_STRAIGHT_BUMPS).min(PLAIN_STRAIGHT_SHARE * site.scan.size_m)
    } else {
        site.with_bumps_m(site.passage_m(), PLAIN_BUMPS)
    };
    gap.clear_m / needed_m
}
