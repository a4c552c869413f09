//! Whether what is behind a gap is where the nearer wall goes on, so that nothing is hidden.

use super::gap::{Gap, Judge};
use super::ring::{Position, turn_rad};

/// The farther wall begins behind the line of the nearer one by at most this share of the angle at which that is seen: a beam
/// that passes the end of a wall goes on behind its line at the whole angle.
const BEHIND_LINE_SHARE: f64 = 0.3;
/// It is no farther away than so many times the spacing...
const REACH_TIMES: f64 = 2.5;
/// ...of so many returns before it...
const REACH_SPACINGS: usize = 2;
/// ...nor than so many times the place's size.
const REACH_SHARE: f64 = 6.0;
/// The line is also taken over this length...
const LONG_M: f64 = 3.0;
/// ...where returns stray from it by no more than so many times the roughness of the walls.
const LONG_BUMPS: f64 = 8.0;
impl Judge<'_> {
    /// Whether what the next beam meets is where the line of the nearer wall goes on, or in front of it. So it is in the
    /// corner of a dead end, along whose sides returns are far apart only because they are seen at a grazing angle.
    pub(super) fn is_in_line(&self, gap: &Gap<'_>) -> bool {
        self.has_hardly_a_beam(gap) && self.goes_on_along(gap, gap.nearer_onward())
    }

    /// The same of the line over [`LONG_M`], if the wall is straight there: its end may lie on a bump.
    pub(super) fn is_in_long_line(&self, gap: &Gap<'_>) -> bool {
        self.has_hardly_a_beam(gap) && self.long_line(gap).is_some_and(|onward| self.goes_on_along(gap, onward))
    }

    /// Whether the farther wall begins about where the nearer one would go on, which runs towards its end in this direction:
    /// in front of that line by less than `straight_deg`, or behind it by less than [`BEHIND_LINE_SHARE`].
    fn goes_on_along(&self, gap: &Gap<'_>, onward: Position) -> bool {
        let (p, q) = gap.ends;
        let (end, turned_rad) =
            if gap.a_is_nearer { (p, turn_rad(onward, gap.chord)) } else { (q, turn_rad(gap.chord, -onward)) };
        let seen_at_rad = turn_rad(onward, self.ring.position_m(end)).abs();
        (-BEHIND_LINE_SHARE * seen_at_rad..self.limits.straight_rad).contains(&turned_rad) && self.is_in_reach(gap)
    }

    /// Whether the farther wall begins about where the next beam would meet the nearer one, if that went straight on. Past
    /// the inner wall of a bend, along whose line it looks, a beam meets the outer one much farther away.
    fn is_in_reach(&self, gap: &Gap<'_>) -> bool {
        let (near, end) = gap.nearer();
        let (last, before) = (end.at(near, 0), end.at(near, REACH_SPACINGS.min(near.len() - 1)));
        let next_m = self.ring.spacing_m(last, before) * self.ring.beams_from(gap.ends.0, gap.ends.1) as f64;
        gap.chord.norm() <= (REACH_TIMES * next_m).min(REACH_SHARE * self.size_m)
    }

    /// The direction in which the nearer wall runs towards its end over [`LONG_M`], if it is straight there.
    fn long_line(&self, gap: &Gap<'_>) -> Option<Position> {
        let (near, end) = gap.nearer();
        let from_end_m = |k: usize| self.ring.position_m(end.at(near, k)) - self.ring.position_m(end.at(near, 0));
        let far = (1..near.len()).find(|&k| from_end_m(k).norm_squared() >= LONG_M * LONG_M)?;
        let onward = -from_end_m(far).normalize();
        let is_straight = (1..far).all(|k| onward.perp(&from_end_m(k)).abs() <= LONG_BUMPS * self.ring.roughness.off_m);
        is_straight.then_some(onward)
    }
}
