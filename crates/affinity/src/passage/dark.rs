//! Gaps in which nothing is seen: an opening, a door, or lost beams.

use std::f64::consts::PI;

use crosscut_scan::lies_across;
use crosscut_stage::Measured;

use super::gap::Gap;

/// A return is about at the end of the sensor's range if it lies beyond this share of it.
const FAR_SHARE: f64 = 0.8;

/// A dark gap is an opening if the wall turns by at least this.
const DARK_TURN_RAD: f64 = 15.0 * PI / 180.0;
/// A dark opening that ends at the end of the range is at least this share of the place's size wide. Between two such
/// ends the chord counts: hardly a return shows how the farther wall runs.
const DARK_SHARE: f64 = 0.45;
/// A dark opening that ends nearer is at least this share of the place's size wide: a dark surface is as likely there.
const DARK_NEAR_SHARE: f64 = 0.7;

/// No patch of lost beams is wider than this angle.
const BLANK_RAD: f64 = 30.0 * PI / 180.0;
/// Where the wall hardly turns, a blank angle is no wider than this many gaps at the end of the range: beams that slant
/// into an opening meet its sides.
const BEHIND_BLANK: f64 = 2.5;
/// Beyond this many times the place's size, patches of lost beams are small.
const FAR_OFF_SHARE: f64 = 2.5;
/// A patch of lost beams beyond [`FAR_OFF_SHARE`] is no wider than this share of the place's size.
const PATCH_SHARE: f64 = 0.78;
/// The ends of a blank opening are at least this share of the place's size apart: no corner hides in it.
const BLANK_SHARE: f64 = 0.9;

/// A door is at least this many times as wide as the vehicle.
const DOOR_TIMES: f64 = 1.75;
/// Behind a door, as far as the sensor sees, the dark is no wider than this share of the place's size, about a tunnel.
const BEHIND_DOOR_SHARE: f64 = 1.5;

/// The words for the distance of the ends of a dark gap.
const DARK: &str = "nothing is seen from end to end over";

/// How much room there is in a dark door. No corner can be missing in the dark, so the gap is as wide as its ends are
/// apart. The door is itself a place where beams are lost if the wall clearly continues behind it.
pub(super) fn room_in_door(gap: &Gap<'_>) -> Option<Measured> {
    let is_door = !gap.turns_back() && !gap.context.lost.are_anywhere() && gap.is_door();
    let room = || {
        let needed_m = DOOR_TIMES * gap.context.passage_m();
        Measured::metres("nothing is seen across a gap of", gap.chord_m(), "a door has at least", needed_m)
    };
    is_door.then(room)
}

/// How much room there is where nothing is seen over an angle, or far off over a patch, that no lost beams explain.
pub(super) fn room_in_blank(gap: &Gap<'_>) -> Option<Measured> {
    if gap.turns_back() {
        return None;
    }
    let (ring, size_m) = (&gap.context.scan.ring, gap.context.scan.size_m);
    let (chord_m, dark_rad) = (gap.chord_m(), gap.dark_rad());
    let is_as_of_opening = dark_rad * ring.range_max_m < BEHIND_BLANK * chord_m;
    let is_wide = dark_rad > BLANK_RAD && (is_as_of_opening || gap.turns.whole_rad > DARK_TURN_RAD);
    let patch_m = if gap.near_m > FAR_OFF_SHARE * size_m { dark_rad * gap.near_m } else { 0.0 };
    let is_blank = is_wide || (patch_m > PATCH_SHARE * size_m && gap.is_not_lost());
    let room = || Measured::metres(DARK, chord_m, "where beams get lost an opening needs", BLANK_SHARE * size_m);
    is_blank.then(room)
}

/// How much room there is at the dark end of a tunnel.
pub(super) fn room_at_dark_end(gap: &Gap<'_>) -> Option<Measured> {
    let is_end = !gap.turns_back() && gap.is_dark_end();
    let needed_m = DARK_SHARE * gap.context.scan.size_m;
    is_end.then(|| Measured::metres(DARK, gap.chord_m(), "at the end of the range an opening needs", needed_m))
}

impl Gap<'_> {
    /// How wide a dark opening is at least, as a share of the place's size; `None` if the gap is none.
    pub(super) fn dark_opening_share(&self) -> Option<f64> {
        if !self.is_dark || self.turns.whole_rad < DARK_TURN_RAD {
            return None;
        }
        if self.is_far(self.far_m) { Some(DARK_SHARE) } else { self.is_not_lost().then_some(DARK_NEAR_SHARE) }
    }

    /// Whether the wall turns right, so that a patch of it may be dark.
    fn turns_back(&self) -> bool {
        self.turns.whole_rad <= -DARK_TURN_RAD
    }

    /// Whether both ends lie at the end of the range, and nothing between them was lost.
    fn is_dark_end(&self) -> bool {
        self.is_far(self.near_m) && self.is_dark && !self.is_shaded && self.is_not_lost()
    }

    /// Whether nothing is seen across the line of sight, well before the end of the range, and the place behind need
    /// not be wider than this one for that.
    fn is_door(&self) -> bool {
        let ring = &self.context.scan.ring;
        let behind_m = self.dark_rad() * ring.range_max_m;
        let is_empty = self.is_dark && !self.is_shaded;
        is_empty
            && lies_across(ring, self.ends)
            && !self.is_far(self.near_m)
            && behind_m < BEHIND_DOOR_SHARE * self.context.scan.size_m
    }

    /// Whether more beams came back with nothing than lost beams explain.
    fn is_not_lost(&self) -> bool {
        !self.context.lost.explain(self.dark_beams)
    }

    fn is_far(&self, range_m: f64) -> bool {
        range_m > FAR_SHARE * self.context.scan.ring.range_max_m
    }
}
