//! Gaps beside a mouth, a doorway or a slit, through which the farther wall is seen.

use std::f64::consts::{FRAC_PI_2, PI};

use super::gap::{Gap, Judge};
use super::way::Look;

/// What is seen so far across the line of the nearer wall, and so deep behind it over as wide a gap, is seen through a mouth: it
/// is another wall, however straight it goes on from the nearer one, unless it turns back by more than a right angle.
const MOUTH_RAD: f64 = 50.0 * PI / 180.0;
const MOUTH_M: f64 = 1.5;
const MOUTH_BUMPS: f64 = 40.0;
/// Seen less far across, it could as well be the shadow of a bump, if walls are rough.
const SLANT_RAD: f64 = 20.0 * PI / 180.0;
const SLANT_BUMPS: f64 = 100.0;
/// A doorway is at most so many times as wide as the vehicle, and the nearer wall runs towards the other side of it: the
/// cosine of the angle between them is this at least. What is seen through it lies so many times that width behind it.
const DOORWAY_TIMES: f64 = 4.0;
const DOORWAY_ALONG: f64 = 0.8;
const BEHIND_DOORWAY_TIMES: f64 = 2.0;
/// What is seen through a slit ends at so many returns in a row that leave no room for a vehicle.
const SLIT_RETURNS: u32 = 2;

impl Judge<'_> {
    /// How many times the room that a way on needs there is beside a mouth or a doorway through which the farther wall is
    /// seen, so deep behind the nearer one.
    pub(super) fn room_ratio_in_mouth(&self, look: &Look<'_, '_>) -> f64 {
        let (gap, turns, deep_m) = (look.gap, look.turns, look.inside_m());
        let goes_on = (-FRAC_PI_2..self.limits.straight_rad).contains(&turns.whole_rad);
        if look.is_shaded || !goes_on || deep_m < self.limits.passage_m || self.is_other_side(gap) {
            return 0.0;
        }
        let bumps = if turns.near_rad < -MOUTH_RAD { MOUTH_BUMPS } else { SLANT_BUMPS };
        let room = deep_m / (MOUTH_M + bumps * self.ring.roughness.off_m);
        if turns.near_rad < -SLANT_RAD && room >= 1.0 && self.fits_into_mouth(gap) {
            return room;
        }
        if look.is_dark {
            return 0.0;
        }
        self.behind_doorway_m(gap).map_or(0.0, |behind_m| behind_m / (BEHIND_DOORWAY_TIMES * self.limits.passage_m))
    }

    /// Whether a vehicle fits between the end of the nearer wall and all that is seen from the end of the farther one on, as
    /// far as a quarter turn.
    pub(super) fn fits_into_mouth(&self, gap: &Gap<'_>) -> bool {
        self.leave_room(gap).all(|leaves_room| leaves_room)
    }

    /// Whether it is a slit between two pieces of a wall that no vehicle passes: a single return may be in its way and be
    /// none of a wall.
    pub(super) fn is_slit(&self, gap: &Gap<'_>) -> bool {
        let mut in_a_row = 0;
        self.leave_room(gap).any(|leaves_room| {
            in_a_row = if leaves_room { 0 } else { in_a_row + 1 };
            in_a_row == SLIT_RETURNS
        })
    }

    /// Of the returns after the farther end, whether each leaves room for a vehicle between it and the nearer end.
    fn leave_room(&self, gap: &Gap<'_>) -> impl Iterator<Item = bool> {
        let ((near, _), passage_m) = (gap.nearer_and_farther(), self.limits.passage_m);
        self.onward(gap, passage_m).map(move |other| self.ring.are_apart(near, other, passage_m))
    }

    /// How far behind a doorway all is that is seen through it, metres, if the nearer wall ends at one: beyond what is
    /// seen, the next wall is nearer again, and a vehicle could pass between the two.
    fn behind_doorway_m(&self, gap: &Gap<'_>) -> Option<f64> {
        let (near, far) = gap.nearer_and_farther();
        let widest_m = DOORWAY_TIMES * self.limits.passage_m;
        let mut last = far;
        let jamb = self.onward(gap, widest_m).find(|&other| {
            let before = std::mem::replace(&mut last, other);
            let is_nearer = self.ring.range_m(other) < self.ring.range_m(before);
            is_nearer && self.ring.are_apart(before, other, self.limits.passage_m)
        })?;
        let near_m = self.ring.position_m(near);
        let across = self.ring.position_m(jamb) - near_m;
        let width_m = across.norm();
        let is_doorway = (self.limits.passage_m..=widest_m).contains(&width_m)
            && gap.nearer_onward().dot(&across) >= DOORWAY_ALONG * width_m;
        // Behind is right of the way anticlockwise.
        let left_m = |i: usize| across.perp(&(self.ring.position_m(i) - near_m)) / width_m;
        let behind_m = |i: usize| if gap.a_is_nearer { -left_m(i) } else { left_m(i) };
        let seen = std::iter::once(far).chain(self.onward(gap, widest_m)).take_while(|&i| i != jamb);
        is_doorway.then(|| seen.map(behind_m).fold(f64::INFINITY, f64::min))
    }

    /// The returns after the farther end of a gap, away from the nearer one, as far as a quarter turn and as one can be
    /// within `reach_m` of the nearer end.
    fn onward(&self, gap: &Gap<'_>, reach_m: f64) -> impl Iterator<Item = usize> {
        let (ring, direction) = (self.ring, if gap.a_is_nearer { 1 } else { -1 });
        let (near, far) = gap.nearer_and_farther();
        let beams = |angle_rad: f64| (angle_rad / ring.step_rad) as usize;
        let quarter_turn = beams(FRAC_PI_2);
        let share = reach_m / ring.range_m(near);
        let most_from_near = if share < 1.0 { beams(share.asin()) } else { usize::MAX };
        let returns = (1..ring.len() as isize).map_while(move |steps| ring.after(far, direction * steps));
        returns.take_while(move |&other| {
            ring.beams_apart(far, other) < quarter_turn && ring.beams_apart(near, other) <= most_from_near
        })
    }
}
