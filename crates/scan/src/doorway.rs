//! Doorways: narrow gaps in a wall, through which a farther wall is seen, or nothing.

use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2};

use crate::ring::{Position, Ring};

/// A doorway is at most this many times as wide as the vehicle.
pub const DOORWAY_TIMES: f64 = 4.0;
/// The nearer wall runs towards the other side of a doorway: the cosine of the angle between the two is at least this.
const ALONG: f64 = 0.8;
/// A dark door lies across the line of sight: the sine of the angle between the two is more than this.
const ACROSS: f64 = FRAC_1_SQRT_2;

/// A doorway through which a farther wall is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Doorway {
    /// From the end of the nearer wall to the other side, metres.
    pub width_m: f64,
    /// How far behind the line between the two everything lies that is seen through it, metres; negative in front.
    pub behind_m: f64,
}

impl Doorway {
    /// The doorway between the end `near` of the nearer wall, which runs in the unit direction `onward` towards it, and
    /// the wall on its other side. Through it, from the return `far` on, a farther wall is seen, `anticlockwise` of
    /// `near` or clockwise. Beyond that wall the other side is nearer again, and a vehicle of width `passage_m` fits
    /// between the two. `None` if there is no such wall, or it is too near, too far or off the line of the nearer one.
    pub fn beside(
        ring: &Ring,
        [near, far]: [usize; 2],
        anticlockwise: bool,
        onward: Position,
        passage_m: f64,
    ) -> Option<Self> {
        let widest_m = DOORWAY_TIMES * passage_m;
        // Dust in front of the far wall is no side of a doorway.
        let step = if anticlockwise { 1 } else { -1 };
        let is_alone = |other: usize| ring.after(other, step).is_none_or(|next| ring.are_apart(other, next, widest_m));
        let mut last = far;
        let jamb = beyond(ring, [near, far], anticlockwise, widest_m).find(|&other| {
            let before = std::mem::replace(&mut last, other);
            let is_nearer = ring.range_m(other) < ring.range_m(before);
            is_nearer && ring.are_apart(before, other, passage_m) && !is_alone(other)
        })?;
        let seen =
            std::iter::once(far).chain(beyond(ring, [near, far], anticlockwise, widest_m)).take_while(|&i| i != jamb);
        Self::between(ring, [near, jamb], anticlockwise, onward, seen)
            .filter(|doorway| (passage_m..=widest_m).contains(&doorway.width_m))
    }

    /// The doorway between the end `near` of a wall, which runs in the unit direction `onward` towards it, and the return
    /// `other`, `anticlockwise` of it or clockwise, through which the returns `seen` are seen. `None` if `other` is off the
    /// line of the wall.
    pub fn between(
        ring: &Ring,
        [near, other]: [usize; 2],
        anticlockwise: bool,
        onward: Position,
        seen: impl Iterator<Item = usize>,
    ) -> Option<Self> {
        let near_m = ring.position_m(near);
        let across = ring.position_m(other) - near_m;
        let width_m = across.norm();
        // Seen anticlockwise along the doorway, right is behind it.
        let left_m = |i: usize| across.perp(&(ring.position_m(i) - near_m)) / width_m;
        let behind_m = |i: usize| if anticlockwise { -left_m(i) } else { left_m(i) };
        let is_in_line = onward.dot(&across) >= ALONG * width_m;
        is_in_line.then(|| Self { width_m, behind_m: seen.map(behind_m).fold(f64::INFINITY, f64::min) })
    }
}

/// The returns after the farther end of a gap, away from the nearer one, as far as a quarter turn, and as far as a
/// return can be within `reach_m` of the nearer end.
pub fn beyond(
    ring: &Ring,
    [near, far]: [usize; 2],
    anticlockwise: bool,
    reach_m: f64,
) -> impl Iterator<Item = usize> + use<'_> {
    let direction = if anticlockwise { 1 } else { -1 };
    let beams = |angle_rad: f64| (angle_rad / ring.step_rad) as usize;
    let quarter_turn = beams(FRAC_PI_2);
    let share = reach_m / ring.range_m(near);
    let most_from_near = if share < 1.0 { beams(share.asin()) } else { usize::MAX };
    let returns = (1..ring.len() as isize).map_while(move |steps| ring.after(far, direction * steps));
    returns.take_while(move |&other| {
        ring.beams_apart(far, other) < quarter_turn && ring.beams_apart(near, other) <= most_from_near
    })
}

/// Whether the gap between two returns lies across the line of sight, as a door does in which nothing is seen.
pub fn lies_across(ring: &Ring, [from, to]: [usize; 2]) -> bool {
    let chord = ring.position_m(to) - ring.position_m(from);
    let middle_m = ring.position_m(from) + 0.5 * chord;
    chord.perp(&middle_m).abs() > ACROSS * chord.norm() * middle_m.norm()
}
