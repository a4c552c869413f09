//! Gaps in which nothing is seen: a way on, a door, or lost beams.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use super::gap::{Gap, Judge, Turns};

/// Nothing is seen in a gap into which so many beams came back with nothing...
const DARK_BEAMS: u32 = 4;
/// ...over so wide an angle.
const DARK_RAD: f64 = 3.5 * PI / 180.0;
/// There is nothing if one of its ends lies farther than this share of the sensor's range...
const FAR_SHARE: f64 = 0.8;
/// ...or if more came back with nothing than so many times those that are lost in a row where a wall clearly goes on.
const LOST_TIMES: u32 = 2;
/// Then it is a way on if it is so wide, as a share of the place's size, at the end of the range; so far apart its ends, if both
/// lie there, as hardly a return shows how the farther wall runs...
const DARK_SHARE: f64 = 0.45;
/// ...so wide nearer, where a dark surface is as likely...
const DARK_NEAR_SHARE: f64 = 0.7;
/// ...and the wall turns by so much.
const DARK_TURN_RAD: f64 = 15.0 * PI / 180.0;

/// No patch of lost beams explains that nothing is seen over more than this angle...
const BLANK_RAD: f64 = 30.0 * PI / 180.0;
/// ...which, where the wall hardly turns, is no wider than so many gaps at the end of the range, as beams that slant into a way
/// on meet its sides.
const BEHIND_BLANK: f64 = 2.5;
/// Nor does one so many times the place's size away...
const FAR_OFF_SHARE: f64 = 2.5;
/// ...over so wide a patch, as a share of that size.
const PATCH_SHARE: f64 = 0.78;
/// The ends of such a gap are so far apart, as a share of the place's size: no corner hides in it.
const BLANK_SHARE: f64 = 0.9;

/// A dark gap is a door where several beams in a row are lost at no more places than this. It is such a place itself, where the
/// wall clearly goes on behind it.
const LOSSY_PLACES: u32 = 1;
/// It is so many times as wide as the vehicle...
const DOOR_TIMES: f64 = 1.75;
/// ...it lies across the line of sight, by the sine of this angle...
const ACROSS: f64 = FRAC_1_SQRT_2;
/// ...and behind it, as far as the sensor sees, the place is no wider than this share of its size: about a tunnel.
const BEHIND_DOOR_SHARE: f64 = 1.5;

impl Judge<'_> {
    /// How wide a way on is as a share of the place's size, where beams into a dark gap came back with nothing because there is
    /// nothing; `None` if they may have been lost.
    pub(super) fn share_in_the_dark(&self, ends: (usize, usize), turns: Turns) -> Option<f64> {
        if turns.whole_rad < DARK_TURN_RAD {
            return None;
        }
        if self.is_far(ends) { Some(DARK_SHARE) } else { self.is_unlost(ends).then_some(DARK_NEAR_SHARE) }
    }

    /// Whether so many beams into the gap came back with nothing that what is there is not seen.
    pub(super) fn is_dark(&self, (p, q): (usize, usize)) -> bool {
        self.ring.dark_between(p, q) >= DARK_BEAMS && self.dark_rad((p, q)) > DARK_RAD
    }

    /// How many times the room that a way on needs there is, if nothing else than one explains that nothing is seen. No corner
    /// can be missing there, so the gap is as wide as its ends are apart.
    pub(super) fn room_ratio_of_blank(&self, gap: &Gap<'_>, turns: Turns) -> f64 {
        let needed_m = self.blank_needs_m(gap.ends, || turns.whole_rad).filter(|_| turns.whole_rad > -DARK_TURN_RAD);
        needed_m.map_or(0.0, |needed_m| gap.chord.norm() / needed_m)
    }

    /// How far apart the ends of a gap must be for it to be a way on because nothing is seen in it; `None` if that is no
    /// reason: it is neither a door, nor dark over so wide an angle, nor, far off, over so wide a patch, nor the dark
    /// end of a tunnel.
    pub(super) fn blank_needs_m(&self, ends: (usize, usize), turn_rad: impl FnOnce() -> f64) -> Option<f64> {
        let is_door = self.lossy_places <= LOSSY_PLACES && self.is_door(ends);
        let door_m = is_door.then_some(DOOR_TIMES * self.limits.passage_m);
        let (dark_rad, nearer_m) = (self.dark_rad(ends), self.nearer_m(ends));
        let behind_m = dark_rad * self.ring.range_max_m;
        let is_as_of_way = || behind_m < BEHIND_BLANK * self.ring.distance_m(ends.0, ends.1);
        let is_wide = dark_rad > BLANK_RAD && (is_as_of_way() || turn_rad() > DARK_TURN_RAD);
        let patch_m = if nearer_m > FAR_OFF_SHARE * self.size_m { dark_rad * nearer_m } else { 0.0 };
        let is_blank = is_wide || (patch_m > PATCH_SHARE * self.size_m && self.is_unlost(ends));
        let blank_m = is_blank.then_some(BLANK_SHARE * self.size_m);
        let far_m = self.is_dark_end(ends).then_some(DARK_SHARE * self.size_m);
        [door_m, blank_m, far_m].into_iter().flatten().min_by(f64::total_cmp)
    }

    /// Whether both ends of a gap lie at the end of the range, and so many beams came back with nothing that none are lost.
    fn is_dark_end(&self, ends: (usize, usize)) -> bool {
        let are_far = self.nearer_m(ends) > FAR_SHARE * self.ring.range_max_m;
        are_far && self.is_dark(ends) && !self.is_shaded(ends) && self.is_unlost(ends)
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

    /// Whether more beams came back with nothing than [`LOST_TIMES`] those that get lost elsewhere.
    fn is_unlost(&self, (p, q): (usize, usize)) -> bool {
        self.ring.dark_between(p, q) > LOST_TIMES * self.lost_beams
    }

    /// Whether the gap lies at the end of the range.
    fn is_far(&self, ends: (usize, usize)) -> bool {
        self.farther_m(ends) > FAR_SHARE * self.ring.range_max_m
    }

    /// The angle in which nothing is seen.
    fn dark_rad(&self, (p, q): (usize, usize)) -> f64 {
        f64::from(self.ring.dark_between(p, q)) * self.ring.step_rad
    }
}
