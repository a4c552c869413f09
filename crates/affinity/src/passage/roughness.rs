//! How rough the walls are.

use super::pieces::Pieces;
use super::ring::{Position, Ring};

/// Roughness is taken over stretches of so much wall, of so many returns or more.
const STRETCH_M: f64 = 2.2;
const LEAST_RETURNS: u32 = 4;

/// Returns that are spaced like this or closer lie on one line with those beside them, on any wall: what is off it says how
/// inexact ranges are, if there are so many of them.
const DENSE_M: f64 = 0.05;
const LEAST_DENSE: u32 = 20;
/// So much of what inexact ranges make of the mean square is taken off.
const INEXACT_SHARE: f64 = 0.8;
/// Of evenly spaced returns that scatter by a standard deviation of 1: the mean square distance of each from the line
/// through those beside it.
const MEAN_SQUARE_OFF: f64 = 1.5;

/// A return of a wall.
#[derive(Clone, Copy)]
struct Return {
    position_m: Position,
    range_squared: f64,
    /// Square of its distance from the line through those beside it.
    off_squared: f64,
}

/// What single returns tell of the walls and of the lidar.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Roughness {
    /// How far the returns of a wall lie off its line, in metres: the root of their mean square over a stretch, and of all
    /// stretches the median, so that corners do not count. 0 if no piece is so long. Stretches are taken from either end
    /// of a piece, as the mirror image of a scan is as rough.
    ///
    /// What inexact ranges make of it is taken off, or a lidar would make walls rough: no more than single returns lie
    /// off the line of their neighbours, nor than they would if ranges were as inexact everywhere as they are near by,
    /// where neighbours are so dense that no bump parts them.
    pub(super) off_m: f64,
    /// The standard deviation of ranges as a share of them, by the dense returns; `None` if they are few.
    pub(super) inexact_share: Option<f64>,
}

impl Roughness {
    pub(super) fn of(ring: &Ring, pieces: &Pieces) -> Self {
        let n = pieces.returns().len();
        let (mut returns, mut ends) = (Vec::with_capacity(n), Vec::with_capacity(pieces.len()));
        let (mut dense, mut share_squared) = (0, 0.0);
        for piece in pieces.iter() {
            for (k, &i) in piece.iter().enumerate() {
                let range_squared = ring.range_m(i) * ring.range_m(i);
                let mut next = Return { position_m: ring.position_m(i), range_squared, off_squared: 0.0 };
                if let (Some(&before), Some(&after)) = (piece.get(k.wrapping_sub(1)), piece.get(k + 1)) {
                    let (off, squared) = ring.off_chord([before, i, after]);
                    next.off_squared = off * off / squared.max(f64::MIN_POSITIVE);
                    if squared < 4.0 * DENSE_M * DENSE_M {
                        dense += 1;
                        share_squared += next.off_squared / range_squared.max(f64::MIN_POSITIVE);
                    }
                }
                returns.push(next);
            }
            ends.push(returns.len());
        }
        let inexact_squared = (dense >= LEAST_DENSE).then(|| share_squared / f64::from(dense) / MEAN_SQUARE_OFF);
        let mut offs_m: Vec<f64> = Vec::with_capacity(2 * n / LEAST_RETURNS as usize);
        let mut start = 0;
        for end in ends {
            let wall = &returns[start..end];
            take_stretches(wall.iter(), inexact_squared.unwrap_or(0.0), &mut offs_m);
            take_stretches(wall.iter().rev(), inexact_squared.unwrap_or(0.0), &mut offs_m);
            start = end;
        }
        let middle = offs_m.len() / 2;
        let off_m = if offs_m.is_empty() { 0.0 } else { *offs_m.select_nth_unstable_by(middle, f64::total_cmp).1 };
        Self { off_m, inexact_share: inexact_squared.map(f64::sqrt) }
    }
}

/// Adds how rough the stretches are that these returns fill one after the other. What does not fill one may be anything.
fn take_stretches<'a>(mut returns: impl Iterator<Item = &'a Return>, inexact_squared: f64, offs_m: &mut Vec<f64>) {
    let Some(first) = returns.next() else { return };
    let mut stretch = Stretch::from(first);
    for next in returns {
        let offset_m = next.position_m - stretch.start_m;
        if offset_m.norm_squared() < STRETCH_M * STRETCH_M {
            stretch.add(offset_m, next);
        } else {
            if stretch.returns >= LEAST_RETURNS {
                offs_m.push(stretch.off_line_m(inexact_squared));
            }
            stretch = Stretch::from(next);
        }
    }
}

/// Some returns, by the sums of their offsets from the first and of the products of those.
struct Stretch {
    start_m: Position,
    returns: u32,
    sum: Position,
    products: [f64; 3],
    off_squared: f64,
    range_squared: f64,
}

impl Stretch {
    fn from(first: &Return) -> Self {
        Self {
            start_m: first.position_m,
            returns: 1,
            sum: Position::zeros(),
            products: [0.0; 3],
            off_squared: first.off_squared,
            range_squared: first.range_squared,
        }
    }

    fn add(&mut self, offset_m: Position, next: &Return) {
        self.returns += 1;
        self.off_squared += next.off_squared;
        self.range_squared += next.range_squared;
        self.sum += offset_m;
        let [xx, xy, yy] = &mut self.products;
        *xx += offset_m.x * offset_m.x;
        *xy += offset_m.x * offset_m.y;
        *yy += offset_m.y * offset_m.y;
    }

    /// Root of the mean square distance of the returns from their principal axis, whose square is the lesser eigenvalue
    /// of their covariance, less what inexact ranges make of it.
    fn off_line_m(&self, inexact_squared: f64) -> f64 {
        let n = f64::from(self.returns);
        let (mean, [xx, xy, yy]) = (self.sum / n, self.products.map(|sum| sum / n));
        let [xx, xy, yy] = [xx - mean.x * mean.x, xy - mean.x * mean.y, yy - mean.y * mean.y];
        let off_squared = 0.5 * (xx + yy) - Position::new(0.5 * (xx - yy), xy).norm();
        let inexact = (self.off_squared / MEAN_SQUARE_OFF).min(inexact_squared * self.range_squared) / n;
        (off_squared - INEXACT_SHARE * inexact).max(0.0).sqrt()
    }
}
