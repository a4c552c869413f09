//! How rough the walls are, and how inexact the ranges.

use crate::median;
use crate::pieces::Pieces;
use crate::ring::{Position, Ring};

/// Roughness is taken over stretches of wall of this length.
const STRETCH_M: f64 = 2.2;
/// A stretch of fewer returns is left out.
const LEAST_RETURNS: u32 = 4;

/// Returns with this spacing or less lie on one line with their neighbours on any wall, so that what they lie off it
/// shows how inexact ranges are.
const DENSE_M: f64 = 0.05;
/// With fewer dense returns, how inexact ranges are is unknown.
const LEAST_DENSE: u32 = 20;
/// The share of the mean square added by inexact ranges that is taken off.
const INEXACT_SHARE: f64 = 0.8;
/// The mean square distance of a return from the line through its two neighbours, for evenly spaced returns that
/// scatter by a standard deviation of 1.
const MEAN_SQUARE_OFF: f64 = 1.5;

/// A return of a wall.
#[derive(Clone, Copy)]
struct WallReturn {
    position_m: Position,
    range_squared: f64,
    /// Square of its distance from the line through its two neighbours.
    off_squared: f64,
}

/// The roughness of the walls, and the error of the ranges.
#[derive(Clone, Copy, Debug, Default)]
pub struct Roughness {
    /// The roughness ρ of the walls, metres: the root mean square distance of returns from the line of their stretch of
    /// wall, of which the median over all stretches is taken, so that corners do not count. 0 if no piece is as long as
    /// a stretch. Stretches are taken from either end of a piece, so that the mirror image of a scan is as rough.
    ///
    /// What inexact ranges add is taken off. That is at most what single returns lie off the line of their neighbours,
    /// and at most what ranges add that are as inexact everywhere as those of dense returns.
    pub sd_m: f64,
    /// The standard deviation of a range as a share of the range, from the dense returns; `None` if these are few.
    pub range_error: Option<f64>,
}

impl Roughness {
    /// Measures the walls that these pieces of `ring` show.
    pub(crate) fn of(ring: &Ring, pieces: &Pieces) -> Self {
        let n = pieces.returns().len();
        let mut returns = Vec::with_capacity(n);
        let (mut dense, mut share_squared) = (0, 0.0);
        for piece in pieces.iter() {
            for (k, &i) in piece.iter().enumerate() {
                let range_squared = ring.range_m(i) * ring.range_m(i);
                let mut next = WallReturn { position_m: ring.position_m(i), range_squared, off_squared: 0.0 };
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
        }
        let inexact_squared = (dense >= LEAST_DENSE).then(|| share_squared / f64::from(dense) / MEAN_SQUARE_OFF);
        let mut offs_m: Vec<f64> = Vec::with_capacity(2 * n / LEAST_RETURNS as usize);
        let mut rest = &returns[..];
        for piece in pieces.iter() {
            let (wall, later) = rest.split_at(piece.len());
            take_stretches(wall.iter(), inexact_squared.unwrap_or(0.0), &mut offs_m);
            take_stretches(wall.iter().rev(), inexact_squared.unwrap_or(0.0), &mut offs_m);
            rest = later;
        }
        Self { sd_m: median(&mut offs_m, f64::total_cmp), range_error: inexact_squared.map(f64::sqrt) }
    }
}

/// Adds the roughness of each stretch that these returns fill, one after the other. A rest that fills none is left out.
fn take_stretches<'a>(mut returns: impl Iterator<Item = &'a WallReturn>, inexact_squared: f64, offs_m: &mut Vec<f64>) {
    let Some(first) = returns.next() else { return };
    let mut stretch = WallStretch::from(first);
    for next in returns {
        let offset_m = next.position_m - stretch.start_m;
        if offset_m.norm_squared() < STRETCH_M * STRETCH_M {
            stretch.add(offset_m, next);
        } else {
            if stretch.returns >= LEAST_RETURNS {
                offs_m.push(stretch.off_line_m(inexact_squared));
            }
            stretch = WallStretch::from(next);
        }
    }
}

/// The sums over the returns of a stretch: of their offsets from the first, and of the products of those.
struct WallStretch {
    start_m: Position,
    returns: u32,
    sum: Position,
    products: [f64; 3],
    off_squared: f64,
    range_squared: f64,
}

impl WallStretch {
    fn from(first: &WallReturn) -> Self {
        Self {
            start_m: first.position_m,
            returns: 1,
            sum: Position::zeros(),
            products: [0.0; 3],
            off_squared: first.off_squared,
            range_squared: first.range_squared,
        }
    }

    fn add(&mut self, offset_m: Position, next: &WallReturn) {
        self.returns += 1;
        self.off_squared += next.off_squared;
        self.range_squared += next.range_squared;
        self.sum += offset_m;
        let [xx, xy, yy] = &mut self.products;
        *xx += offset_m.x * offset_m.x;
        *xy += offset_m.x * offset_m.y;
        *yy += offset_m.y * offset_m.y;
    }

    /// The root mean square distance of the returns from their principal axis, less what inexact ranges add. Its square
    /// is the smaller eigenvalue of their covariance.
    fn off_line_m(&self, inexact_squared: f64) -> f64 {
        let n = f64::from(self.returns);
        let (mean, [xx, xy, yy]) = (self.sum / n, self.products.map(|sum| sum / n));
        let [xx, xy, yy] = [xx - mean.x * mean.x, xy - mean.x * mean.y, yy - mean.y * mean.y];
        let off_squared = 0.5 * (xx + yy) - Position::new(0.5 * (xx - yy), xy).norm();
        let inexact = (self.off_squared / MEAN_SQUARE_OFF).min(inexact_squared * self.range_squared) / n;
        (off_squared - INEXACT_SHARE * inexact).max(0.0).sqrt()
    }
}
