//! Whether the nearer wall of a gap continues where the farther one begins, so that the gap hides nothing.

use crosscut_scan::{Position, turn_rad};
use crosscut_stage::Measured;

use super::gap::Gap;

/// The farther wall begins behind the line of the nearer one by at most this share of the angle at which that line is
/// seen: a beam that passes the end of a wall continues behind its line at the whole angle.
const BEHIND_LINE_SHARE: f64 = 0.3;
/// The farther wall is no farther away than this many times the spacing of the nearer one.
const REACH_TIMES: f64 = 2.5;
/// The spacing of the nearer wall is the distance from its last return to the one this many returns before.
const REACH_RETURNS: usize = 2;
/// The farther wall is no farther away than this many times the place's size.
const REACH_SHARE: f64 = 6.0;
/// The length of wall over which a second line is taken, in case the end of the wall lies on a bump.
const LONG_M: f64 = 3.0;
/// Over that length a straight wall strays from its line by no more than this many times the roughness of the walls.
const LONG_BUMPS: f64 = 8.0;

impl Gap<'_> {
    /// Where it goes on, if the next beam meets the line of the nearer wall, or something in front of it. So it is in the corner of
    /// a dead end, where returns are far apart only because the sides are seen at a grazing angle.
    pub(super) fn in_line(&self) -> Option<Measured> {
        let goes_on = self.holds_one_beam_at_most() && self.goes_on_along(self.nearer_onward());
        goes_on.then(|| self.next_on_line("the next return lies on the line of the nearer wall, after"))
    }

    /// Where it goes on, if the next beam meets the line of the nearer wall over [`LONG_M`], if the wall is straight there.
    pub(super) fn in_long_line(&self) -> Option<Measured> {
        let goes_on =
            self.holds_one_beam_at_most() && self.long_line().is_some_and(|onward| self.goes_on_along(onward));
        goes_on.then(|| self.next_on_line("the next return lies on the line of the nearer wall's last 3 m, after"))
    }

    fn next_on_line(&self, what: &'static str) -> Measured {
        Measured::metres(what, self.chord_m(), "one is due within", self.reach_m())
    }

    /// Whether the farther wall begins about where the nearer one would continue if it ran on in this direction: in front
    /// of that line by less than `straight_deg`, or behind it by less than [`BEHIND_LINE_SHARE`].
    fn goes_on_along(&self, onward: Position) -> bool {
        let turned_rad =
            if self.first_is_nearer { turn_rad(onward, self.chord) } else { turn_rad(self.chord, -onward) };
        let end_m = self.context.scan.ring.position_m(self.near_and_far_end()[0]);
        let seen_at_rad = turn_rad(onward, end_m).abs();
        (-BEHIND_LINE_SHARE * seen_at_rad..self.context.thresholds.straight_rad).contains(&turned_rad)
            && self.is_in_reach()
    }

    /// Whether the farther wall begins about where the next beam would meet the nearer one. Past the inner wall of a
    /// bend, along whose line it looks, a beam meets the outer one much farther away.
    fn is_in_reach(&self) -> bool {
        self.chord_m() <= self.reach_m()
    }

    /// How far from the nearer end its wall may go on until the next beam meets it.
    fn reach_m(&self) -> f64 {
        (REACH_TIMES * self.next_m()).min(REACH_SHARE * self.context.scan.size_m)
    }

    /// How far from the nearer end the farther one would be if the nearer wall went on with the same spacing.
    pub(super) fn next_m(&self) -> f64 {
        let (ring, (near, end)) = (&self.context.scan.ring, self.nearer());
        let (last, before) = (end.at(near, 0), end.at(near, REACH_RETURNS.min(near.len() - 1)));
        ring.spacing_m(last, before) * ring.beams_from(self.ends[0], self.ends[1]) as f64
    }

    /// The direction in which the nearer wall runs towards its end over [`LONG_M`]; `None` if it is not straight there.
    fn long_line(&self) -> Option<Position> {
        let (ring, (near, end)) = (&self.context.scan.ring, self.nearer());
        let from_end_m = |k: usize| ring.position_m(end.at(near, k)) - ring.position_m(end.at(near, 0));
        let far = (1..near.len()).find(|&k| from_end_m(k).norm_squared() >= LONG_M * LONG_M)?;
        let onward = -from_end_m(far).normalize();
        let most_off_m = LONG_BUMPS * self.context.scan.roughness.sd_m;
        (1..far).all(|k| onward.perp(&from_end_m(k)).abs() <= most_off_m).then_some(onward)
    }
}
