//! Whether the nearer wall of a gap continues where the farther one begins, so that the gap hides nothing.

use crosscut_scan::turn_rad;
use crosscut_stage::Measured;

use super::gap::{Gap, STRAIGHT_RAD};

/// The farther wall begins behind the line of the nearer one by at most this share of the angle at which that line is
/// seen: a beam that passes the end of a wall continues behind its line at the whole angle.
const BEHIND_LINE_SHARE: f64 = 0.3;
/// The farther wall is no farther away than this many times the spacing of the nearer one.
const REACH_TIMES: f64 = 2.5;
/// The spacing of the nearer wall is the distance from its last return to the one this many returns before.
const REACH_RETURNS: usize = 2;
/// The farther wall is no farther away than this many times the place's size.
const REACH_SHARE: f64 = 6.0;

impl Gap<'_> {
    /// Where it goes on, if the next beam meets the line of the nearer wall, or something in front of it. So it is in the corner of
    /// a dead end, where returns are far apart only because the sides are seen at a grazing angle.
    pub(super) fn in_line(&self) -> Option<Measured> {
        let goes_on = self.holds_one_beam_at_most() && self.is_on_line() && self.chord_m() <= self.reach_m();
        let next = "the next return lies on the line of the nearer wall, after";
        goes_on.then(|| Measured::metres(next, self.chord_m(), "one is due within", self.reach_m()))
    }

    /// Whether the farther wall begins about on the line of the nearer one: in front of it by less than [`STRAIGHT_RAD`], or
    /// behind it by less than [`BEHIND_LINE_SHARE`].
    fn is_on_line(&self) -> bool {
        let onward = self.nearer_onward();
        let turned_rad =
            if self.first_is_nearer { turn_rad(onward, self.chord) } else { turn_rad(self.chord, -onward) };
        let end_m = self.context.scan.ring.position_m(self.near_and_far_end()[0]);
        let seen_at_rad = turn_rad(onward, end_m).abs();
        (-BEHIND_LINE_SHARE * seen_at_rad..STRAIGHT_RAD).contains(&turned_rad)
    }

    /// How far from the nearer end its wall may go on until the next beam meets it. Past the inner wall of a bend, along whose
    /// line it looks, a beam meets the outer one much farther away.
    fn reach_m(&self) -> f64 {
        (REACH_TIMES * self.next_m()).min(REACH_SHARE * self.context.scan.size_m)
    }

    /// How far from the nearer end the farther one would be if the nearer wall went on with the same spacing.
    pub(super) fn next_m(&self) -> f64 {
        let (ring, (near, end)) = (&self.context.scan.ring, self.nearer());
        let (last, before) = (end.at(near, 0), end.at(near, REACH_RETURNS.min(near.len() - 1)));
        ring.spacing_m(last, before) * ring.beams_from(self.ends[0], self.ends[1]) as f64
    }
}
