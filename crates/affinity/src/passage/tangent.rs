//! The direction in which a wall ends.

use super::pieces::End;
use super::ring::{Position, Ring};

/// A piece of fewer returns, or shorter than this, has no direction.
const LEAST_RETURNS: usize = 2;
const LEAST_LENGTH_M: f64 = 0.1;
/// Of two returns that are no farther apart than this, both may be of one prop.
const LEAST_LENGTH_OF_TWO_M: f64 = 0.3;
/// A direction is taken from so many returns, if the piece has them...
const LEAST_TAKEN: usize = 3;
/// ...and over so many times the first spacing at least: far returns are metres apart.
const SPACINGS: f64 = 2.25;
/// A prop or a beam along a wall shows its own sides, and hides the wall behind it. So the stretch is also so many times as long
/// as a gap, with no beam in it, that begins no farther from the end than this, nor than so many times the roughness of the walls:
/// at the far corner of a branch of smooth walls, what is as short is the face of that corner.
const GAPS: f64 = 1.5;
const PROP_M: f64 = 0.45;
const PROP_BUMPS: f64 = 5.0;
/// Between props, and where walls are as rough, no short stretch has the direction of its wall: the stretch is at least so many
/// times what the roughness of the walls exceeds this by.
const ROUGHNESSES: f64 = 40.0;
const ROUGH_M: f64 = 0.12;
/// And so many times as long as its returns scatter across it, by the first of them: a line through a cloud of far returns,
/// whose ranges are not exact, has a direction only where the cloud is long.
const SCATTERS: f64 = 12.0;
const SCATTER_RETURNS: usize = 14;
const SCATTER_LEAST_RETURNS: usize = 6;
/// Of returns that scatter by a standard deviation of 1, evenly spaced: the median distance of each from the line
/// through those beside it, 0.6745 √(3/2).
const MEDIAN_OFF: f64 = 0.826_1;
/// No more returns than this are looked at.
const MOST_RETURNS: usize = 60;

/// Whether a piece is long enough to have a direction.
pub(super) fn has_direction(ring: &Ring, piece: &[usize]) -> bool {
    let least_m = if piece.len() == LEAST_RETURNS { LEAST_LENGTH_OF_TWO_M } else { LEAST_LENGTH_M };
    piece.len() >= LEAST_RETURNS && ring.are_apart(piece[0], piece[piece.len() - 1], least_m)
}

/// The directions of the ends of pieces over one length of wall. Pieces are joined and cut, but their ends seldom
/// change, so the last direction at each return is kept, both ways.
#[derive(Clone, Debug, Default)]
pub(super) struct Tangents {
    stretch_m: f64,
    kept: Vec<[Option<Kept>; 2]>,
}

/// A direction, and on which returns it rests.
#[derive(Clone, Copy, Debug)]
struct Kept {
    direction: Position,
    looked_at: LookedAt,
    last: u32,
    /// The one after the last, if it or that there is none mattered.
    next: Option<u32>,
}

/// The first returns of an end.
#[derive(Clone, Copy, Debug)]
struct LookedAt {
    returns: usize,
    /// Whether it matters what comes after them: that was too far, or there was nothing.
    and_next: bool,
}

impl Tangents {
    /// Forgets what is kept of another scan; of this one, roughness is known.
    pub(super) fn start(&mut self, ring: &Ring, stretch_m: f64) {
        self.stretch_m = stretch_m.max(ROUGHNESSES * (ring.roughness.off_m - ROUGH_M));
        self.kept.clear();
        self.kept.resize(ring.len(), [None; 2]);
    }

    /// What [`tangent`] says of the piece.
    pub(super) fn of(&mut self, ring: &Ring, piece: &[usize], end: End) -> Position {
        let at = |k: usize| end.at(piece, k);
        let after = |returns: usize| (returns < piece.len()).then(|| at(returns) as u32);
        let rests_on = |kept: &Kept| {
            let LookedAt { returns, and_next } = kept.looked_at;
            let as_far = piece.len() >= returns && at(returns - 1) == kept.last as usize;
            as_far && (!and_next || after(returns) == kept.next)
        };
        let slot = &mut self.kept[at(0)][usize::from(end == End::Last)];
        if let Some(kept) = slot.filter(rests_on) {
            return kept.direction;
        }
        let (direction, looked_at) = tangent_and_looked_at(ring, piece, end, self.stretch_m);
        let returns = looked_at.returns;
        *slot = Some(Kept { direction, looked_at, last: at(returns - 1) as u32, next: after(returns) });
        direction
    }
}

/// The unit direction, anticlockwise around the sensor, of a piece of two returns or more at one of its ends: the
/// principal axis of its returns, weighted by exp(-(d/stretch)²) at a distance d from the end.
pub(super) fn tangent(ring: &Ring, piece: &[usize], end: End, stretch_m: f64) -> Position {
    tangent_and_looked_at(ring, piece, end, stretch_m).0
}

/// The same, and what it rests on.
fn tangent_and_looked_at(ring: &Ring, piece: &[usize], end: End, stretch_m: f64) -> (Position, LookedAt) {
    let at = |k: usize| ring.position_m(end.at(piece, k));
    let tip = at(0);
    let stretch_m = stretch_m.max(SPACINGS * (at(1) - tip).norm()).max(f64::MIN_POSITIVE);
    let (stretch_m, read) = past_prop_m(ring, piece, end, stretch_m);
    let stretch_m = stretch_m.max(scattered_m(ring, piece, end, stretch_m));
    let squared = stretch_m * stretch_m;
    // The tip lies at no distance from itself: its weight is 1, and it moves nothing.
    let (mut walked_m, mut taken) = (0.0, 1);
    let (mut sum, mut moment, mut square) = (1.0, Position::zeros(), [0.0; 3]);
    while taken < piece.len().min(MOST_RETURNS) {
        let offset = at(taken) - tip;
        walked_m += (at(taken) - at(taken - 1)).norm();
        if taken >= LEAST_TAKEN && (offset.norm_squared() > squared || 0.5 * walked_m > stretch_m) {
            break;
        }
        let weight = (-offset.norm_squared() / squared).exp();
        sum += weight;
        moment += offset * weight;
        square[0] += weight * offset.x * offset.x;
        square[1] += weight * offset.x * offset.y;
        square[2] += weight * offset.y * offset.y;
        taken += 1;
    }
    let mean = moment / sum;
    let (xx, xy, yy) =
        (square[0] / sum - mean.x * mean.x, square[1] / sum - mean.x * mean.y, square[2] / sum - mean.y * mean.y);
    let axis = principal_axis(xx, xy, yy);
    let inward = at(taken - 1) - tip;
    let onward = if end == End::Last { -inward } else { inward };
    let (taken, of_scatter) = (taken.max(read), piece.len().min(SCATTER_RETURNS));
    // All were too few: there may be more.
    let and_next = if taken < of_scatter { of_scatter < SCATTER_RETURNS } else { taken < MOST_RETURNS };
    let looked_at = LookedAt { returns: taken.max(of_scatter), and_next };
    (if axis.dot(&onward) < 0.0 { -axis } else { axis }, looked_at)
}

/// The stretch, or [`GAPS`] times the widest gap with no beam in it that begins near an end of a piece, if that is more; and how
/// many returns were looked at for that.
fn past_prop_m(ring: &Ring, piece: &[usize], end: End, stretch_m: f64) -> (f64, usize) {
    let prop_m = PROP_M.min(PROP_BUMPS * ring.roughness.off_m);
    let tip_m = ring.position_m(end.at(piece, 0));
    let (mut here, mut here_m, mut widest_squared, mut read) = (end.at(piece, 0), tip_m, 0.0, 1);
    while read < piece.len().min(MOST_RETURNS) {
        if (here_m - tip_m).norm_squared() >= prop_m * prop_m {
            break;
        }
        let next = end.at(piece, read);
        let next_m = ring.position_m(next);
        let squared = (next_m - here_m).norm_squared();
        if squared > widest_squared && ring.beams_apart(here, next) == 1 {
            widest_squared = squared;
        }
        (here, here_m, read) = (next, next_m, read + 1);
    }
    (stretch_m.max(GAPS * widest_squared.sqrt()), read)
}

/// [`SCATTERS`] times how far the first returns at an end of a piece scatter across it, from the median distance of each
/// from the line through those beside it; 0 if that is no longer than `least_m`, as it is nearly always.
fn scattered_m(ring: &Ring, piece: &[usize], end: End, least_m: f64) -> f64 {
    let returns = piece.len().min(SCATTER_RETURNS);
    let is_exact = |share: f64| SCATTERS * share * ring.range_m(end.at(piece, 0)) < least_m;
    if returns < SCATTER_LEAST_RETURNS || ring.roughness.inexact_share.is_none_or(is_exact) {
        return 0.0;
    }
    let off_chord = |k: usize| ring.off_chord([k - 1, k, k + 1].map(|k| end.at(piece, k)));
    let (count, least_off_m) = (returns - 2, least_m * MEDIAN_OFF / SCATTERS);
    let is_less = |&(off, squared): &(f64, f64)| off * off <= least_off_m * least_off_m * squared;
    if (1..returns - 1).map(off_chord).filter(is_less).nth(count / 2).is_some() {
        return 0.0; // the median is one of those
    }
    let mut offs_m = [0.0; SCATTER_RETURNS - 2];
    for (off_m, k) in offs_m.iter_mut().zip(1..returns - 1) {
        let (off, squared) = off_chord(k);
        *off_m = off / squared.sqrt().max(f64::MIN_POSITIVE);
    }
    SCATTERS / MEDIAN_OFF * *offs_m[..count].select_nth_unstable_by(count / 2, f64::total_cmp).1
}

/// The unit eigenvector of the larger eigenvalue of a covariance: it halves the angle of (xx - yy, 2 xy).
fn principal_axis(xx: f64, xy: f64, yy: f64) -> Position {
    let (along, across) = (xx - yy, 2.0 * xy);
    let length = Position::new(along, across).norm();
    // The half is taken on the side on which nothing cancels.
    let half = if along >= 0.0 {
        Position::new(length + along, across)
    } else {
        Position::new(across.abs(), (length - along).copysign(across))
    };
    if length > 0.0 { half.normalize() } else { Position::x() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_principal_axis_of_every_direction_is_that_direction() {
        for deg in -89..=90 {
            let (y, x) = f64::from(deg).to_radians().sin_cos();
            for thickness in [0.0, 0.5] {
                let axis =
                    principal_axis(x * x + thickness * y * y, (1.0 - thickness) * x * y, y * y + thickness * x * x);
                assert!((axis - Position::new(x, y)).norm() < 1e-14, "{deg}°: {axis}");
            }
        }
        assert_eq!(principal_axis(1.0, 0.0, 1.0), Position::x(), "round: any");
    }
}
