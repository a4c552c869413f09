//! Gaps beside a mouth, a doorway or a slit, through which the farther wall is seen.

use std::f64::consts::{FRAC_PI_2, PI};

use crosscut_scan::{Doorway, beyond};

use super::gap::Gap;

/// What is seen across the line of the nearer wall at more than this angle, is seen through a mouth.
const MOUTH_RAD: f64 = 50.0 * PI / 180.0;
/// What is seen through a mouth of smooth walls lies at least this deep behind the nearer wall, over as wide a gap.
const MOUTH_M: f64 = 1.5;
/// What is seen through a mouth of rough walls lies deeper by this many times their roughness.
const MOUTH_BUMPS: f64 = 40.0;
/// What is seen at more than this angle, is seen through a slanting mouth, or in the shadow of a bump.
const SLANT_RAD: f64 = 20.0 * PI / 180.0;
/// What is seen through a slanting mouth of rough walls lies deeper by this many times their roughness.
const SLANT_BUMPS: f64 = 100.0;

/// What is seen through a doorway lies behind it by at least this many times the width of the vehicle.
const BEHIND_DOORWAY_TIMES: f64 = 2.0;

/// A slit ends at this many returns in a row that leave no room for a vehicle: a single one may be of no wall.
const SLIT_RETURNS: u32 = 2;

/// How much room there is where the farther wall is seen deep behind the nearer one, through a mouth or a doorway. It
/// is another wall, however straight it continues, unless the wall turns back by more than a right angle.
pub(super) fn room_behind_mouth(gap: &Gap<'_>) -> f64 {
    let (context, deep_m) = (gap.context, gap.step_m());
    let goes_on = (-FRAC_PI_2..context.thresholds.straight_rad).contains(&gap.turns.whole_rad);
    if gap.is_shaded || !goes_on || deep_m < context.passage_m() || gap.shows_other_side() {
        return 0.0;
    }
    let bumps = if gap.turns.near_rad < -MOUTH_RAD { MOUTH_BUMPS } else { SLANT_BUMPS };
    let room_ratio = deep_m / context.with_bumps_m(MOUTH_M, bumps);
    if gap.turns.near_rad < -SLANT_RAD && room_ratio >= 1.0 && gap.fits_vehicle() {
        return room_ratio;
    }
    if gap.is_dark {
        return 0.0;
    }
    gap.behind_doorway_m().map_or(0.0, |behind_m| behind_m / (BEHIND_DOORWAY_TIMES * context.passage_m()))
}

impl Gap<'_> {
    /// Whether a vehicle fits between the end of the nearer wall and all that is seen from the end of the farther one
    /// on, as far as a quarter turn.
    pub(super) fn fits_vehicle(&self) -> bool {
        self.fits_beyond().all(|fits| fits)
    }

    /// Whether no vehicle passes between what is seen on the one side of it and on the other: beside the end of the nearer
    /// wall, or where the way to it narrows.
    pub(super) fn is_slit(&self) -> bool {
        let mut in_a_row = 0;
        let is_beside_end = self.fits_beyond().any(|fits| {
            in_a_row = if fits { 0 } else { in_a_row + 1 };
            in_a_row == SLIT_RETURNS
        });
        is_beside_end || self.is_behind_neck()
    }

    /// Whether two returns of each wall, as far as a quarter turn from the gap, leave no room for a vehicle between them.
    fn is_behind_neck(&self) -> bool {
        let (ring, passage_m) = (&self.context.scan.ring, self.context.passage_m());
        let ([before, after], [p, q]) = (self.pieces, self.ends);
        let beams = |angle_rad: f64| (angle_rad / ring.step_rad) as usize;
        let quarter_turn = beams(FRAC_PI_2);
        let mut first: Option<[usize; 2]> = None;
        let mut are_others = [false; 2];
        for &a in before.iter().rev().take_while(|&&a| ring.beams_from(a, p) < quarter_turn) {
            // What is within a length of a return is seen within this angle of it.
            let share = passage_m / ring.range_m(a);
            let most = if share < 1.0 { beams(share.asin()) } else { 2 * quarter_turn };
            let on_other_side = after.iter().take_while(|&&b| ring.beams_from(q, b) < quarter_turn);
            for &b in on_other_side.take_while(|&&b| ring.beams_from(a, b) <= most) {
                if !ring.are_apart(a, b, passage_m) {
                    let [a_of_first, b_of_first] = *first.get_or_insert([a, b]);
                    are_others = [are_others[0] || a != a_of_first, are_others[1] || b != b_of_first];
                }
            }
            if are_others == [true; 2] {
                return true;
            }
        }
        false
    }

    /// For each return after the farther end, whether a vehicle fits between it and the nearer end.
    fn fits_beyond(&self) -> impl Iterator<Item = bool> {
        let (ring, ends, passage_m) = (&self.context.scan.ring, self.near_and_far_end(), self.context.passage_m());
        let onward = beyond(ring, ends, self.first_is_nearer, passage_m);
        onward.map(move |other| ring.are_apart(ends[0], other, passage_m))
    }

    /// How far behind a doorway everything lies that is seen through it, metres; `None` if the nearer wall does not end
    /// at one.
    pub(super) fn behind_doorway_m(&self) -> Option<f64> {
        let (ring, ends) = (&self.context.scan.ring, self.near_and_far_end());
        let doorway = Doorway::beside(ring, ends, self.first_is_nearer, self.nearer_onward(), self.context.passage_m());
        doorway.map(|doorway| doorway.behind_m)
    }
}
