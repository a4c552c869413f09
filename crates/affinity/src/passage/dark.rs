//! Gaps in which nothing is seen: a way on, a door, or lost beams.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use super::gap::{Gap, Judge, Turns, whole_turn_rad};
use super::pieces::Pieces;

/// A wall clearly goes on where it turns by less, and is off its line by no more than this share of the place's size.
const LOST_TURN_RAD: f64 = 30.0 * PI / 180.0;
const LOST_OFF_SHARE: f64 = 0.3;

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
    /// Learns how many beams get lost where a wall clearly goes on, within its pieces and between them.
    pub(super) fn count_lost_beams(&mut self, pieces: &Pieces) {
        for pair in pieces.iter().flat_map(|piece| piece.windows(2)) {
            self.lose(self.ring.dark_between(pair[0], pair[1]));
        }
        let gaps = if self.ring.full_turn { pieces.len() } else { pieces.len().saturating_sub(1) };
        for at in 0..gaps {
            let (a, b) = (&pieces[at], &pieces[(at + 1) % pieces.len()]);
            let lost_beams = self.ring.dark_between(a[a.len() - 1], b[0]);
            if lost_beams > 0 && self.clearly_goes_on(a, b) {
                self.lose(lost_beams);
            }
        }
    }

    /// So many beams are lost at a place where a wall clearly goes on.
    fn lose(&mut self, beams: u32) {
        self.lost_beams = self.lost_beams.max(beams);
        self.lossy_places += u32::from(beams > 1);
    }

    fn clearly_goes_on(&self, a: &[usize], b: &[usize]) -> bool {
        let Some(gap) = self.gap(a, b) else { return false };
        let [of_q, of_p] = gap.aside_m();
        let off_m = of_q.abs().max(of_p.abs());
        off_m < LOST_OFF_SHARE * self.size_m && whole_turn_rad(gap.turns_rad()) < LOST_TURN_RAD
    }

    /// How wide a way on is as a share of the place's size, where beams into a dark gap came back with nothing because there is
    /// nothing; `None` if they may have been lost.
    pub(super) fn share_in_the_dark(&self, gap: &Gap<'_>, turns: Turns) -> Option<f64> {
        if turns.whole_rad < DARK_TURN_RAD {
            return None;
        }
        if self.is_far(gap.far_m) { Some(DARK_SHARE) } else { self.is_unlost(gap).then_some(DARK_NEAR_SHARE) }
    }

    /// Whether so many beams into the gap came back with nothing that what is there is not seen.
    pub(super) fn is_dark(&self, gap: &Gap<'_>) -> bool {
        self.dark_beams(gap) >= DARK_BEAMS && self.dark_rad(gap) > DARK_RAD
    }

    /// Whether islands hide what is in the gap.
    pub(super) fn is_shaded(&self, gap: &Gap<'_>) -> bool {
        self.ring.is_shaded(gap.ends.0, gap.ends.1)
    }

    /// How many times the room that a way on needs there is, if nothing else than one explains that nothing is seen; 0 if that
    /// is no reason: it is neither a door, nor dark over so wide an angle, nor, far off, over so wide a patch, nor the dark end
    /// of a tunnel. No corner can be missing there, so the gap is as wide as its ends are apart.
    pub(super) fn room_ratio_of_blank(&self, gap: &Gap<'_>, turns: Turns) -> f64 {
        if turns.whole_rad <= -DARK_TURN_RAD {
            return 0.0;
        }
        let (chord_m, dark_rad) = (gap.chord.norm(), self.dark_rad(gap));
        let is_door = self.lossy_places <= LOSSY_PLACES && self.is_door(gap);
        let door_m = is_door.then_some(DOOR_TIMES * self.limits.passage_m);
        let is_as_of_way = dark_rad * self.ring.range_max_m < BEHIND_BLANK * chord_m;
        let is_wide = dark_rad > BLANK_RAD && (is_as_of_way || turns.whole_rad > DARK_TURN_RAD);
        let patch_m = if gap.near_m > FAR_OFF_SHARE * self.size_m { dark_rad * gap.near_m } else { 0.0 };
        let is_blank = is_wide || (patch_m > PATCH_SHARE * self.size_m && self.is_unlost(gap));
        let blank_m = is_blank.then_some(BLANK_SHARE * self.size_m);
        let far_m = self.is_dark_end(gap).then_some(DARK_SHARE * self.size_m);
        let needed_m = [door_m, blank_m, far_m].into_iter().flatten().min_by(f64::total_cmp);
        needed_m.map_or(0.0, |needed_m| chord_m / needed_m)
    }

    /// Whether both ends of a gap lie at the end of the range, and so many beams came back with nothing that none are lost.
    fn is_dark_end(&self, gap: &Gap<'_>) -> bool {
        self.is_far(gap.near_m) && self.is_dark(gap) && !self.is_shaded(gap) && self.is_unlost(gap)
    }

    /// Whether a gap is one across the line of sight in which nothing is seen, well before the end of the range, and what
    /// lies behind it need not be wider than this place for that.
    fn is_door(&self, gap: &Gap<'_>) -> bool {
        let middle_m = self.ring.position_m(gap.ends.0) + 0.5 * gap.chord;
        let is_across = gap.chord.perp(&middle_m).abs() > ACROSS * gap.chord.norm() * middle_m.norm();
        let behind_m = self.dark_rad(gap) * self.ring.range_max_m;
        let is_empty = self.is_dark(gap) && !self.is_shaded(gap);
        is_empty && is_across && !self.is_far(gap.near_m) && behind_m < BEHIND_DOOR_SHARE * self.size_m
    }

    /// Whether more beams came back with nothing than [`LOST_TIMES`] those that get lost elsewhere.
    fn is_unlost(&self, gap: &Gap<'_>) -> bool {
        self.dark_beams(gap) > LOST_TIMES * self.lost_beams
    }

    /// Whether so much is about the sensor's range.
    fn is_far(&self, range_m: f64) -> bool {
        range_m > FAR_SHARE * self.ring.range_max_m
    }

    /// How many beams into the gap came back with nothing.
    fn dark_beams(&self, gap: &Gap<'_>) -> u32 {
        self.ring.dark_between(gap.ends.0, gap.ends.1)
    }

    /// The angle in which nothing is seen.
    fn dark_rad(&self, gap: &Gap<'_>) -> f64 {
        f64::from(self.dark_beams(gap)) * self.ring.step_rad
    }
}
