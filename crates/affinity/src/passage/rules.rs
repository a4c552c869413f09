//! The rules at a gap: how much room there is for an opening, divided by how much one needs.

use std::f64::consts::PI;

use super::gap::{BUMP_HIDES_M, CORNER_RAD, Gap};
use super::verdict::{Decision, RuleGroup, VetoPhase, WIDTH};

/// An opening between two walls that recede is at least this share of the place's size wide.
const OPENING_SHARE: f64 = 0.3;
/// An opening in the shadow of islands, where nothing is known, is at least this share of the place's size wide.
const SHADE_SHARE: f64 = 1.5;
/// An opening whose inside is seen need not be wider or deeper than this share of the place's size.
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
pub(super) const PLAIN_BUMPS: f64 = 70.0;
/// Where the walls hardly turn, a gap in plain sight is wider by this many times the roughness of the walls.
const PLAIN_STRAIGHT_BUMPS: f64 = 100.0;
/// Where the walls hardly turn, a gap in plain sight need not be wider than this share of the place's size.
const PLAIN_STRAIGHT_SHARE: f64 = 1.4;

impl Gap<'_> {
    /// How much room there is, by the rules and vetoes that are left, and by the odds.
    pub(super) fn decide(&self) -> Decision {
        self.limited_by_odds(self.decide_by_rules())
    }

    /// How much room there is, by the rules and vetoes of the table.
    pub(super) fn decide_by_rules(&self) -> Decision {
        let disabled = self.context.thresholds.disabled;
        if let Some(reason) = disabled.veto(VetoPhase::BeforeRules, self) {
            return Decision::no_room(reason);
        }
        let clear = match disabled.veto(VetoPhase::OfClearRules, self) {
            Some(reason) => Decision::no_room(reason),
            None => {
                let none = if self.opening_share().is_some() { WIDTH } else { "the wall turns too little" };
                let most = Decision::no_room(none).or_by(disabled.rules(RuleGroup::Clear), self);
                Decision { room_ratio: most.room_ratio.min(self.clear_m / self.context.passage_m()), ..most }
            }
        };
        let mut decision = clear.or_by(disabled.rules(RuleGroup::Dark), self);
        if !decision.is_opening() {
            decision = decision.or_by(disabled.rules(RuleGroup::Last), self);
        }
        let veto = if decision.is_opening() { disabled.veto(VetoPhase::OfOpenings, self) } else { None };
        veto.map_or(decision, Decision::no_room)
    }

    /// How wide an opening is at least, as a share of the place's size, where the wall turns like this; `None` where the
    /// wall continues whatever the width is.
    fn opening_share(&self) -> Option<f64> {
        if self.turns.whole_rad >= self.context.thresholds.way_rad {
            return Some(OPENING_SHARE);
        }
        let turned = if self.is_shaded { SHADE_SHARE } else { self.context.thresholds.clear_share };
        self.dark_opening_share().or(self.turns_like_branch().then_some(turned))
    }
}

/// The clear width is enough for how much the walls turn.
pub(super) fn room_in_width(gap: &Gap<'_>) -> f64 {
    gap.opening_share().map_or(0.0, |share| gap.clear_m / (share * gap.context.scan.size_m))
}

/// The farther wall, the far side of a branch, is seen deep behind the nearer one: deeper than the clear width; or
/// width and depth are both more than a bump hides, or large beside the place.
pub(super) fn room_inside(gap: &Gap<'_>) -> f64 {
    if !gap.turns_like_branch() {
        return 0.0;
    }
    let needed_m = gap.bump_hides_m.min(SEEN_INSIDE_SHARE * gap.context.scan.size_m);
    (gap.depth_m / gap.clear_m).max(gap.step_m() / needed_m)
}

/// The face of a corner is seen, the far side of a side passage, along the wall that it leaves. Behind the corner that
/// wall continues as if it had only been hidden. Where nothing is seen, the width decides, if an opening there has one.
pub(super) fn room_before_face(gap: &Gap<'_>) -> f64 {
    let room_ratio = gap.chord_m() / (FACE_SHARE * gap.context.scan.size_m);
    let may_show_face = gap.is_clear() || gap.opening_share().is_none();
    if room_ratio >= 1.0 && may_show_face && gap.turns_to_face() { room_ratio } else { 0.0 }
}

/// A vehicle fits between the nearer wall and a face that begins deep behind it, deeper than the face of a corner, and no bump
/// hides as much. The line of the farther wall shows little: it is the line of the face, or of the wall behind it.
pub(super) fn room_into_side_passage(gap: &Gap<'_>) -> f64 {
    let is_deep = gap.is_clear() && !gap.is_corner && gap.depth_m > BUMP_HIDES_M;
    let room_ratio = gap.chord_m() / gap.context.with_bumps_m(SIDE_TIMES * gap.context.passage_m(), PLAIN_BUMPS);
    let is_passage = is_deep && room_ratio >= 1.0 && gap.turns_to_face() && gap.fits_vehicle();
    if is_passage { room_ratio } else { 0.0 }
}

/// The farther wall of a dark gap begins so far in front of the nearer one that it is another wall.
pub(super) fn room_behind_wall_in_front(gap: &Gap<'_>) -> f64 {
    let is_straight_and_dark = gap.is_dark && gap.turns.whole_rad < CORNER_RAD;
    if is_straight_and_dark { -gap.depth_m / (IN_FRONT_SHARE * gap.context.scan.size_m) } else { 0.0 }
}

/// Hardly a beam looks into the gap, so that its width is plain to see.
pub(super) fn room_in_plain_sight(gap: &Gap<'_>) -> f64 {
    let (context, turn_rad) = (gap.context, gap.turns.whole_rad);
    let turns_enough = (PLAIN_RAD..context.thresholds.way_rad).contains(&turn_rad);
    if !turns_enough || !gap.is_clear() || !gap.holds_one_beam_at_most() {
        return 0.0;
    }
    let needed_m = if turn_rad < context.thresholds.straight_rad {
        context.with_bumps_m(context.passage_m(), PLAIN_STRAIGHT_BUMPS).min(PLAIN_STRAIGHT_SHARE * context.scan.size_m)
    } else {
        context.with_bumps_m(context.passage_m(), PLAIN_BUMPS)
    };
    gap.clear_m / needed_m
}
