//! The direction in which a wall ends.

use super::ring::{Position, Ring};

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
    piece.len() >= LEAST_RETURNS && ring.are_apart(piece[0], piece[piece.len() - 1], LEAST_LENGTH_M)
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
    taken: u32,
    last: u32,
    /// The one after the last, which was too far; `None` if there was none, or it was not looked at.
    next: Option<u32>,
}

impl Tangents {
    /// Forgets what is kept of another scan.
    pub(super) fn start(&mut self, ring: &Ring, stretch_m: f64) {
        self.stretch_m = stretch_m;
        self.kept.clear();
        self.kept.resize(ring.len(), [None; 2]);
    }

    /// What [`tangent`] says of the piece.
    pub(super) fn of(&mut self, ring: &Ring, piece: &[usize], end: End) -> Position {
        let at = |k: usize| end.at(piece, k);
        let rests_on = |kept: &Kept| {
            let (taken, next) = (kept.taken as usize, kept.next.map(|next| next as usize));
            let as_far = piece.len() >= taken && at(taken - 1) == kept.last as usize;
            as_far && (taken == MOST_RETURNS || piece.len() == taken || next == Some(at(taken)))
        };
        let slot = &mut self.kept[at(0)][usize::from(end == End::Last)];
        if let Some(kept) = slot.filter(rests_on) {
            return kept.direction;
        }
        let (direction, taken) = tangent_and_taken(ring, piece, end, self.stretch_m);
        let next = (taken < piece.len()).then(|| at(taken) as u32);
        *slot = Some(Kept { direction, taken: taken as u32, last: at(taken - 1) as u32, next });
        direction
    }
}

impl End {
    /// The k-th return of a piece from this end on.
    pub(super) fn at(self, piece: &[usize], k: usize) -> usize {
        piece[if self == Self::Last { piece.len() - 1 - k } else { k }]
    }
}

/// The unit direction, anticlockwise around the sensor, of a piece of two returns or more at one of its ends: the
/// principal axis of its returns, weighted by exp(-(d/stretch)²) at a distance d from the end.
pub(super) fn tangent(ring: &Ring, piece: &[usize], end: End, stretch_m: f64) -> Position {
    tangent_and_taken(ring, piece, end, stretch_m).0
}

/// The same, and on how many returns it rests.
fn tangent_and_taken(ring: &Ring, piece: &[usize], end: End, stretch_m: f64) -> (Position, usize) {
    let at = |k: usize| ring.position_m(end.at(piece, k));
    let tip = at(0);
    let stretch_m = stretch_m.max(SPACINGS * (at(1) - tip).norm()).max(f64::MIN_POSITIVE);
    let squared = stretch_m * stretch_m;
    // The tip lies at no distance from itself: its weight is 1, and it moves nothing.
    let (mut walked_m, mut taken) = (0.0, 1);
    let (mut sum, mut moment, mut square) = (1.0, Position::zeros(), [0.0; 3]);
    while taken < piece.len().min(MOST_RETURNS) {
        let offset = at(taken) - tip;
        walked_m += (at(taken) - at(taken - 1)).norm();
        if taken >= LEAST_RETURNS && (offset.norm_squared() > squared || 0.5 * walked_m > stretch_m) {
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
    (if axis.dot(&onward) < 0.0 { -axis } else { axis }, taken)
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
