//! How rough the walls are.

use super::pieces::Pieces;
use super::ring::{Position, Ring};

/// Roughness is taken over stretches of so much wall, of so many returns or more.
const STRETCH_M: f64 = 2.0;
const LEAST_RETURNS: usize = 4;

/// How far the returns of a wall lie off its line, in metres: the root of their mean square over a stretch, and of all
/// stretches the median, so that corners do not count. 0 if no piece is so long. Stretches are taken from either end of
/// a piece, as the mirror image of a scan is as rough.
pub(super) fn roughness_m(ring: &Ring, pieces: &Pieces) -> f64 {
    let mut offs_m: Vec<f64> = Vec::with_capacity(pieces.returns().len() / LEAST_RETURNS);
    let from_either_end = pieces.iter().flat_map(|piece| [(piece, false), (piece, true)]);
    for (mut rest, from_last) in from_either_end {
        // What does not fill a stretch may be anything.
        while let Some((stretch, others)) = split_stretch(ring, rest, from_last) {
            if stretch.len() >= LEAST_RETURNS {
                offs_m.push(off_line_m(ring, stretch));
            }
            rest = others;
        }
    }
    let middle = offs_m.len() / 2;
    if offs_m.is_empty() { 0.0 } else { *offs_m.select_nth_unstable_by(middle, f64::total_cmp).1 }
}

/// The first stretch of a piece, or the last one, and what is left.
fn split_stretch<'a>(ring: &Ring, piece: &'a [usize], from_last: bool) -> Option<(&'a [usize], &'a [usize])> {
    if from_last {
        let last = *piece.last()?;
        let before = piece.iter().rposition(|&i| ring.are_apart(last, i, STRETCH_M))?;
        let (others, stretch) = piece.split_at(before + 1);
        Some((stretch, others))
    } else {
        let first = *piece.first()?;
        let end = piece.iter().position(|&i| ring.are_apart(first, i, STRETCH_M))?;
        Some(piece.split_at(end))
    }
}

/// Root of the mean square distance of returns from their principal axis, whose square is the lesser eigenvalue of
/// their covariance.
fn off_line_m(ring: &Ring, stretch: &[usize]) -> f64 {
    let n = stretch.len() as f64;
    let mean = stretch.iter().fold(Position::zeros(), |sum, &i| sum + ring.position_m(i)) / n;
    let offsets = || stretch.iter().map(|&i| ring.position_m(i) - mean);
    let [xx, xy, yy] = offsets().fold([0.0; 3], |[xx, xy, yy], o| [xx + o.x * o.x, xy + o.x * o.y, yy + o.y * o.y]);
    ((0.5 * (xx + yy) - Position::new(0.5 * (xx - yy), xy).norm()) / n).max(0.0).sqrt()
}
