//! The direction in which a wall ends.

use crate::median;
use crate::pieces::End;
use crate::ring::{Position, Ring};
use crate::roughness::Roughness;

/// A piece of fewer returns has no direction.
const LEAST_RETURNS: usize = 2;
/// A piece whose ends are nearer to each other has no direction.
const LEAST_LENGTH_M: f64 = 0.1;
/// A piece of two returns needs this length: nearer ones may lie on one prop.
const LEAST_LENGTH_OF_TWO_M: f64 = 0.3;

/// A direction is taken from at least this many returns, if the piece has them.
const LEAST_TAKEN: usize = 3;
/// No direction is taken from more returns than this.
const MOST_RETURNS: usize = 60;
/// The stretch is at least this many times the distance of the first two returns: far returns are metres apart.
const SPACINGS: f64 = 2.25;

/// The stretch is at least this many times as long as a gap between two neighbouring beams near the end of the piece: a
/// prop or a beam along a wall shows its own sides there, and hides the wall behind it.
const GAPS: f64 = 1.5;
/// A gap beside a prop begins no farther than this from the end of the piece.
const PROP_M: f64 = 0.45;
/// A gap beside a prop begins no farther than this many times the roughness of the walls from the end: at the far corner of a branch of smooth
/// walls, a stretch this short is the face of that corner.
const PROP_BUMPS: f64 = 5.0;

/// The stretch is at least this many times what the roughness of the walls exceeds [`ROUGH_M`] by: a shorter one has
/// the direction of a prop or a bump.
const ROUGHNESSES: f64 = 40.0;
/// Walls up to this roughness need no longer stretch.
const ROUGH_M: f64 = 0.12;

/// The stretch is at least this many times as long as its returns scatter across it: where ranges are inexact, far
/// returns form a cloud that has a direction only where it is long.
const SCATTERS: f64 = 12.0;
/// The scatter is taken from this many returns at the end of a piece, or from all if it has fewer.
const SCATTER_RETURNS: usize = 14;
/// A piece of fewer returns has no known scatter.
const SCATTER_LEAST_RETURNS: usize = 6;
/// The median distance of a return from the line through its two neighbours, 0.6745 √(3/2), for evenly spaced returns
/// that scatter by a standard deviation of 1.
const MEDIAN_OFF: f64 = 0.826_1;

/// Whether a piece is long enough to have a direction.
fn has_direction(ring: &Ring, piece: &[usize]) -> bool {
    let least_m = if piece.len() == LEAST_RETURNS { LEAST_LENGTH_OF_TWO_M } else { LEAST_LENGTH_M };
    piece.len() >= LEAST_RETURNS && ring.are_apart(piece[0], piece[piece.len() - 1], least_m)
}

/// The directions at the ends of pieces, over one length of wall. Pieces are joined and cut, but their ends seldom
/// change, so the last direction at each return is kept, for either end.
#[derive(Clone, Debug, Default)]
pub struct Directions {
    stretch_m: f64,
    kept: Vec<[Option<Kept>; 2]>,
}

/// A direction, and the returns that it depends on.
#[derive(Clone, Copy, Debug)]
struct Kept {
    direction: Position,
    basis: Basis,
    /// The last return of the basis.
    last: u32,
    /// The return behind the basis, if there is one.
    next: Option<u32>,
}

/// The first returns of an end, which its direction depends on.
#[derive(Clone, Copy, Debug)]
struct Basis {
    returns: usize,
    /// The return behind them, or that there is none, ended the stretch.
    and_next: bool,
}

impl Directions {
    /// Starts a new revolution: forgets all directions. The next ones are of `ring`, over `stretch_m` of wall, or
    /// more if the walls are rough.
    pub fn start(&mut self, ring: &Ring, roughness: &Roughness, stretch_m: f64) {
        self.stretch_m = stretch_m.max(ROUGHNESSES * (roughness.sd_m - ROUGH_M));
        self.kept.clear();
        self.kept.resize(ring.len(), [None; 2]);
    }

    /// The [`direction`] of a piece at one end; `None` if it is too short to have one.
    pub fn of(&mut self, ring: &Ring, roughness: &Roughness, piece: &[usize], end: End) -> Option<Position> {
        if !has_direction(ring, piece) {
            return None;
        }
        let at = |k: usize| end.at(piece, k);
        let after = |returns: usize| (returns < piece.len()).then(|| at(returns) as u32);
        let has_same_basis = |kept: &Kept| {
            let Basis { returns, and_next } = kept.basis;
            let has_returns = piece.len() >= returns && at(returns - 1) == kept.last as usize;
            has_returns && (!and_next || after(returns) == kept.next)
        };
        let slot = &mut self.kept[at(0)][usize::from(end == End::Last)];
        if let Some(kept) = slot.filter(has_same_basis) {
            return Some(kept.direction);
        }
        let (direction, basis) = direction_and_basis(ring, roughness, piece, end, self.stretch_m);
        *slot = Some(Kept { direction, basis, last: at(basis.returns - 1) as u32, next: after(basis.returns) });
        Some(direction)
    }
}

/// The unit direction, anticlockwise around the sensor, of a piece of two returns or more at one of its ends: the
/// principal axis of its returns, weighted by exp(-(d/stretch)²) at a distance d from the end.
///
/// The stretch is `stretch_m`, or longer where returns are far apart, where a prop stands at the end, and where ranges
/// are inexact.
pub fn direction(ring: &Ring, roughness: &Roughness, piece: &[usize], end: End, stretch_m: f64) -> Position {
    direction_and_basis(ring, roughness, piece, end, stretch_m).0
}

fn direction_and_basis(
    ring: &Ring,
    roughness: &Roughness,
    piece: &[usize],
    end: End,
    stretch_m: f64,
) -> (Position, Basis) {
    let at = |k: usize| ring.position_m(end.at(piece, k));
    let tip = at(0);
    let stretch_m = stretch_m.max(SPACINGS * (at(1) - tip).norm()).max(f64::MIN_POSITIVE);
    let (stretch_m, read) = past_prop_m(ring, roughness, piece, end, stretch_m);
    let stretch_m = stretch_m.max(past_scatter_m(ring, roughness, piece, end, stretch_m));
    let squared = stretch_m * stretch_m;
    // The tip has weight 1 and no offset.
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
    let (taken, for_scatter) = (taken.max(read), piece.len().min(SCATTER_RETURNS));
    // A longer piece would have another direction only if all returns of this one were read.
    let and_next = if taken < for_scatter { for_scatter < SCATTER_RETURNS } else { taken < MOST_RETURNS };
    let basis = Basis { returns: taken.max(for_scatter), and_next };
    (if axis.dot(&onward) < 0.0 { -axis } else { axis }, basis)
}

/// The stretch that reaches past a prop at the end of a piece, at least `stretch_m`, and how many returns were read for
/// it.
fn past_prop_m(ring: &Ring, roughness: &Roughness, piece: &[usize], end: End, stretch_m: f64) -> (f64, usize) {
    let prop_m = PROP_M.min(PROP_BUMPS * roughness.sd_m);
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

/// [`SCATTERS`] times the scatter of the returns at an end of a piece, which the median of their distances from the
/// line through their neighbours gives; 0 if that is no longer than `least_m`, the most common case.
fn past_scatter_m(ring: &Ring, roughness: &Roughness, piece: &[usize], end: End, least_m: f64) -> f64 {
    let returns = piece.len().min(SCATTER_RETURNS);
    let is_exact = |share: f64| SCATTERS * share * ring.range_m(end.at(piece, 0)) < least_m;
    if returns < SCATTER_LEAST_RETURNS || roughness.range_error.is_none_or(is_exact) {
        return 0.0;
    }
    let off_chord = |k: usize| ring.off_chord([k - 1, k, k + 1].map(|k| end.at(piece, k)));
    let (count, least_off_m) = (returns - 2, least_m * MEDIAN_OFF / SCATTERS);
    let is_less = |&(off, squared): &(f64, f64)| off * off <= least_off_m * least_off_m * squared;
    if (1..returns - 1).map(off_chord).filter(is_less).nth(count / 2).is_some() {
        return 0.0; // The median is one of those.
    }
    let mut offs_m = [0.0; SCATTER_RETURNS - 2];
    for (off_m, k) in offs_m.iter_mut().zip(1..returns - 1) {
        let (off, squared) = off_chord(k);
        *off_m = off / squared.sqrt().max(f64::MIN_POSITIVE);
    }
    SCATTERS / MEDIAN_OFF * median(&mut offs_m[..count], f64::total_cmp)
}

/// The unit eigenvector of the larger eigenvalue of a covariance. It halves the angle of (xx - yy, 2 xy).
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
