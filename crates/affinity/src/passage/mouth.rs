//! Gaps beside a mouth, a doorway or a slit, through which the farther wall is seen.

use std::f64::consts::{FRAC_PI_2, PI};

use crosscut_scan::{Doorway, beyond};
use crosscut_stage::Measured;

use super::gap::{Gap, STRAIGHT_RAD};

/// A farther wall is seen through a mouth where the wall turns right at its nearer end by more than this.
const MOUTH_RAD: f64 = 50.0 * PI / 180.0;
/// A wall seen through a mouth of smooth walls lies at least this deep behind the nearer wall, and the gap is as wide.
const MOUTH_M: f64 = 1.5;
/// A wall seen through a mouth of rough walls lies deeper by this many times their roughness.
const MOUTH_BUMPS: f64 = 40.0;
/// A farther wall is seen through a slanting mouth, or in the shadow of a bump, where the wall turns right by more than this.
const SLANT_RAD: f64 = 20.0 * PI / 180.0;
/// A wall seen through a slanting mouth of rough walls lies deeper by this many times their roughness.
const SLANT_BUMPS: f64 = 100.0;

/// All returns seen through a doorway lie behind it by at least this many times the width of the vehicle.
const BEHIND_DOORWAY_TIMES: f64 = 2.0;

/// A slit ends at this many returns in a row that leave no room for a vehicle: a single one may be of no wall.
const SLIT_RETURNS: u32 = 2;

/// How much room there is where the farther wall is seen deep behind the nearer one, through a mouth or a doorway. It
/// is another wall, however straight it continues. Past a mouth it is none if it turns back by more than a right angle, or is the
/// other side of the place, which meets the nearer wall in a corner. Behind a doorway neither can be.
pub(super) fn room_behind_mouth(gap: &Gap<'_>) -> Option<Measured> {
    let (context, deep_m) = (gap.context, gap.step_m());
    if gap.is_shaded || gap.turns.whole_rad >= STRAIGHT_RAD || deep_m < context.passage_m() {
        return None;
    }
    let turns_back = gap.turns.whole_rad < -FRAC_PI_2;
    let bumps = if gap.turns.near_rad < -MOUTH_RAD { MOUTH_BUMPS } else { SLANT_BUMPS };
    let room = Measured::metres(
        "a wall that closes this mouth would need a step of",
        deep_m,
        "bumps hide steps of up to",
        context.with_bumps_m(MOUTH_M, bumps),
    );
    let is_mouth = !turns_back && gap.turns.near_rad < -SLANT_RAD && room.ratio() >= 1.0;
    if is_mouth && !gap.shows_other_side() && gap.fits_vehicle() {
        return Some(room);
    }
    let behind_m = if gap.is_dark { None } else { gap.behind_doorway_m() };
    behind_m.map(|behind_m| {
        let needed_m = BEHIND_DOORWAY_TIMES * context.passage_m();
        Measured::metres("all that is seen through a door lies behind it by", behind_m, "a way on needs", needed_m)
    })
}

impl Gap<'_> {
    /// Whether a vehicle fits between the end of the nearer wall and all that is seen from the end of the farther one
    /// on, as far as a quarter turn.
    pub(super) fn fits_vehicle(&self) -> bool {
        self.near_beyond().all(|(_, fits)| fits)
    }

    /// The room, if no vehicle passes between what is seen on the one side of it and on the other: beside the end of the
    /// nearer wall, or where the way to it narrows. In the shadow of islands these are what stands beside it.
    pub(super) fn in_slit(&self) -> Option<Measured> {
        let width_m = if self.is_shaded { None } else { self.beside_end_m().or_else(|| self.in_neck_m()) };
        let passage_m = self.context.passage_m();
        width_m.map(|m| Measured::metres("what is seen on its two sides leaves", m, "the vehicle needs", passage_m))
    }

    /// The distance of the nearer end from the returns beyond the farther one, if [`SLIT_RETURNS`] of them in a row leave
    /// no room for a vehicle.
    fn beside_end_m(&self) -> Option<f64> {
        let ring = &self.context.scan.ring;
        let [end, _] = self.near_and_far_end();
        let (mut in_a_row, mut least_m) = (0, f64::INFINITY);
        self.near_beyond().find_map(|(other, fits)| {
            in_a_row = if fits { 0 } else { in_a_row + 1 };
            least_m = if fits { f64::INFINITY } else { least_m.min(ring.distance_m(end, other)) };
            (in_a_row == SLIT_RETURNS).then_some(least_m)
        })
    }

    /// The distance between the two walls, if two returns of each, as far as a quarter turn from the gap, leave no room
    /// for a vehicle between them.
    fn in_neck_m(&self) -> Option<f64> {
        let (ring, passage_m) = (&self.context.scan.ring, self.context.passage_m());
        let ([before, after], [p, q]) = (self.pieces, self.ends);
        let beams = |angle_rad: f64| (angle_rad / ring.step_rad) as usize;
        let quarter_turn = beams(FRAC_PI_2);
        let mut first: Option<[usize; 2]> = None;
        let (mut are_others, mut least_m) = ([false; 2], f64::INFINITY);
        for &a in before.iter().rev().take_while(|&&a| ring.beams_from(a, p) < quarter_turn) {
            // What is within a length of a return is seen within this angle of it.
            let share = passage_m / ring.range_m(a);
            let most = if share < 1.0 { beams(share.asin()) } else { 2 * quarter_turn };
            let on_other_side = after.iter().take_while(|&&b| ring.beams_from(q, b) < quarter_turn);
            for &b in on_other_side.take_while(|&&b| ring.beams_from(a, b) <= most) {
                if !ring.are_apart(a, b, passage_m) {
                    let [a_of_first, b_of_first] = *first.get_or_insert([a, b]);
                    are_others = [are_others[0] || a != a_of_first, are_others[1] || b != b_of_first];
                    least_m = least_m.min(ring.distance_m(a, b));
                }
            }
        }
        (are_others == [true; 2]).then_some(least_m)
    }

    /// Each return after the farther end, and whether a vehicle fits between it and the nearer end.
    fn near_beyond(&self) -> impl Iterator<Item = (usize, bool)> {
        let (ring, ends, passage_m) = (&self.context.scan.ring, self.near_and_far_end(), self.context.passage_m());
        let onward = beyond(ring, ends, self.first_is_nearer, passage_m);
        onward.map(move |other| (other, ring.are_apart(ends[0], other, passage_m)))
    }

    /// How far behind a doorway everything lies that is seen through it, metres; `None` if the nearer wall does not end
    /// at one.
    pub(super) fn behind_doorway_m(&self) -> Option<f64> {
        let (ring, ends) = (&self.context.scan.ring, self.near_and_far_end());
        let doorway = Doorway::beside(ring, ends, self.first_is_nearer, self.nearer_onward(), self.context.passage_m());
        doorway.map(|doorway| doorway.behind_m)
    }
}
