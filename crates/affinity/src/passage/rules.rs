//! The rules at a gap: how much room there is for an opening, divided by how much one needs.

use std::f64::consts::PI;

use crosscut_stage::Measured;

use super::gap::{CORNER_RAD, Gap, STRAIGHT_RAD, WAY_RAD};

/// An opening where a wall turns like a branch is at least this share of the place's size wide.
const CLEAR_SHARE: f64 = 1.15;
/// An opening between two walls that recede is at least this share of the place's size wide.
const OPENING_SHARE: f64 = 0.3;
/// An opening in the shadow of islands, where nothing is known, is at least this share of the place's size wide.
const SHADE_SHARE: f64 = 1.5;
/// An opening whose inside is seen need not be wider or deeper than this share of the place's size.
const SEEN_INSIDE_SHARE: f64 = 0.5;
/// A gap before the face of a corner is at least this share of the place's size long.
const FACE_SHARE: f64 = 0.75;
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

/// The words for the clear width.
const LINES: &str = "the nearer end is off the line of the farther wall by";
/// The words for the step.
const STEP: &str = "a wall here would need, behind the nearer end, a step of";
/// The words for the depth.
const DEPTH: &str = "the farther wall is seen behind the line of the nearer one by";

impl Gap<'_> {
    /// The clear width beside the width of the vehicle.
    pub(super) fn clear_width(&self) -> Measured {
        Measured::metres(LINES, self.clear_m, "the vehicle needs", self.context.passage_m())
    }

    /// How wide an opening is at least, as a share of the place's size, where the wall turns like this; `None` where the
    /// wall continues whatever the width is.
    pub(super) fn opening_share(&self) -> Option<f64> {
        if self.turns.whole_rad >= WAY_RAD {
            return Some(OPENING_SHARE);
        }
        let turned = if self.is_shaded { SHADE_SHARE } else { CLEAR_SHARE };
        self.dark_opening_share().or(self.turns_like_branch().then_some(turned))
    }
}

/// The clear width is enough for how much the walls turn.
pub(super) fn room_in_width(gap: &Gap<'_>) -> Option<Measured> {
    let needed_m = gap.opening_share()? * gap.context.scan.size_m;
    Some(Measured::metres(LINES, gap.clear_m, "where walls turn like this an opening needs", needed_m))
}

/// The farther wall, the far side of a branch, is seen deep behind the nearer one: deeper than the clear width; or
/// width and depth are both more than a bump hides, or large beside the place.
pub(super) fn room_inside(gap: &Gap<'_>) -> Option<Measured> {
    if !gap.turns_like_branch() {
        return None;
    }
    let bump_m = if gap.is_clear() { gap.bump_hides_m() } else { f64::INFINITY };
    let hidden_m = bump_m.min(SEEN_INSIDE_SHARE * gap.context.scan.size_m);
    let step = Measured::metres(STEP, gap.step_m(), "these walls hide steps of up to", hidden_m);
    let deep = Measured::metres(
        DEPTH,
        gap.depth_m,
        "one that is deeper than the gap's clear width is another wall; that width is",
        gap.clear_m,
    );
    Some(if deep.ratio() > step.ratio() { deep } else { step })
}

/// The face of a corner is seen, the far side of a side passage, along the wall that it leaves. Behind the corner that
/// wall continues as if it had only been hidden. Where nothing is seen, the width decides, if an opening there has one.
pub(super) fn room_before_face(gap: &Gap<'_>) -> Option<Measured> {
    let room = Measured::metres(
        "the face of a corner is seen beyond a gap of",
        gap.chord_m(),
        "a wall that goes on hides no more than",
        FACE_SHARE * gap.context.scan.size_m,
    );
    let may_show_face = gap.is_clear() || gap.opening_share().is_none();
    (room.ratio() >= 1.0 && may_show_face && gap.turns_to_face()).then_some(room)
}

/// The farther wall of a dark gap begins so far in front of the nearer one that it is another wall.
pub(super) fn room_behind_wall_in_front(gap: &Gap<'_>) -> Option<Measured> {
    let room = || {
        Measured::metres(
            "the farther wall ends in front of the nearer one's line by",
            -gap.depth_m,
            "another wall does so by at least",
            IN_FRONT_SHARE * gap.context.scan.size_m,
        )
    };
    (gap.is_dark && gap.turns.whole_rad < CORNER_RAD).then(room)
}

/// Hardly a beam looks into the gap, so that its width is plain to see.
pub(super) fn room_in_plain_sight(gap: &Gap<'_>) -> Option<Measured> {
    let (context, turn_rad) = (gap.context, gap.turns.whole_rad);
    let turns_enough = (PLAIN_RAD..WAY_RAD).contains(&turn_rad);
    if !turns_enough || !gap.is_clear() || !gap.holds_one_beam_at_most() {
        return None;
    }
    let needed_m = if turn_rad < STRAIGHT_RAD {
        context.with_bumps_m(context.passage_m(), PLAIN_STRAIGHT_BUMPS).min(PLAIN_STRAIGHT_SHARE * context.scan.size_m)
    } else {
        context.with_bumps_m(context.passage_m(), PLAIN_BUMPS)
    };
    Some(Measured::metres(LINES, gap.clear_m, "in plain sight an opening needs", needed_m))
}
