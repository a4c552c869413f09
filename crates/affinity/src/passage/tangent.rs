//! The direction in which a wall ends.

use super::ring::{Place, Ring};

/// A piece of fewer returns, or shorter than this, has no direction.
const LEAST_RETURNS: usize = 3;
const LEAST_LENGTH_M: f64 = 0.1;
/// The stretch is at least so many times the first spacing: far returns are metres apart.
const SPACINGS: f64 = 2.5;
/// No more returns than this are looked at.
const MOST_RETURNS: usize = 60;

/// Which end of a piece.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum End {
    First,
    Last,
}

/// Whether a piece is long enough to have a direction.
pub(super) fn has_direction(ring: &Ring, piece: &[usize]) -> bool {
    piece.len() >= LEAST_RETURNS && ring.distance_m(piece[0], piece[piece.len() - 1]) >= LEAST_LENGTH_M
}

/// The unit direction, anticlockwise around the sensor, of a piece of two returns or more at one of its ends: the
/// principal axis of its returns, weighted by exp(-(d/stretch)²) at a distance d from the end.
pub(super) fn tangent(ring: &Ring, piece: &[usize], end: End, stretch_m: f64) -> Place {
    let at = |k: usize| ring.place_m(piece[if end == End::Last { piece.len() - 1 - k } else { k }]);
    let tip = at(0);
    let stretch_m = stretch_m.max(SPACINGS * (at(1) - tip).norm()).max(f64::MIN_POSITIVE);
    let (mut walked_m, mut taken) = (0.0, 0);
    let (mut sum, mut moment, mut square) = (0.0, Place::zeros(), [0.0; 3]);
    while taken < piece.len().min(MOST_RETURNS) {
        let offset = at(taken) - tip;
        if taken > 0 {
            walked_m += (at(taken) - at(taken - 1)).norm();
        }
        if taken >= LEAST_RETURNS && offset.norm().max(0.5 * walked_m) > stretch_m {
            break;
        }
        let weight = (-(offset.norm() / stretch_m).powi(2)).exp();
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
    let angle_rad = 0.5 * (2.0 * xy).atan2(xx - yy);
    let axis = Place::new(angle_rad.cos(), angle_rad.sin());
    let inward = at(taken - 1) - tip;
    let onward = if end == End::Last { -inward } else { inward };
    if axis.dot(&onward) < 0.0 { -axis } else { axis }
}
