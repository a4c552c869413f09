//! How rough the walls are.

use super::pieces::Pieces;
use super::ring::{Position, Ring};

/// Roughness is taken over stretches of so much wall, of so many returns or more.
const STRETCH_M: f64 = 2.0;
const LEAST_RETURNS: u32 = 4;

/// How far the returns of a wall lie off its line, in metres: the root of their mean square over a stretch, and of all
/// stretches the median, so that corners do not count. 0 if no piece is so long. Stretches are taken from either end of
/// a piece, as the mirror image of a scan is as rough.
pub(super) fn roughness_m(ring: &Ring, pieces: &Pieces) -> f64 {
    let mut offs_m: Vec<f64> = Vec::with_capacity(2 * pieces.returns().len() / LEAST_RETURNS as usize);
    for piece in pieces.iter() {
        take_stretches(piece.iter().map(|&i| ring.position_m(i)), &mut offs_m);
        take_stretches(piece.iter().rev().map(|&i| ring.position_m(i)), &mut offs_m);
    }
    let middle = offs_m.len() / 2;
    if offs_m.is_empty() { 0.0 } else { *offs_m.select_nth_unstable_by(middle, f64::total_cmp).1 }
}

/// Adds how rough the stretches are that these returns fill one after the other. What does not fill one may be anything.
fn take_stretches(mut positions_m: impl Iterator<Item = Position>, offs_m: &mut Vec<f64>) {
    let Some(first_m) = positions_m.next() else { return };
    let mut stretch = Stretch::from(first_m);
    for position_m in positions_m {
        let offset_m = position_m - stretch.start_m;
        if offset_m.norm_squared() < STRETCH_M * STRETCH_M {
            stretch.add(offset_m);
        } else {
            if stretch.returns >= LEAST_RETURNS {
                offs_m.push(stretch.off_line_m());
            }
            stretch = Stretch::from(position_m);
        }
    }
}

/// Some returns, by the sums of their offsets from the first and of the products of those.
struct Stretch {
    start_m: Position,
    returns: u32,
    sum: Position,
    products: [f64; 3],
}

impl Stretch {
    fn from(start_m: Position) -> Self {
        Self { start_m, returns: 1, sum: Position::zeros(), products: [0.0; 3] }
    }

    fn add(&mut self, offset_m: Position) {
        self.returns += 1;
        self.sum += offset_m;
        let [xx, xy, yy] = &mut self.products;
        *xx += offset_m.x * offset_m.x;
        *xy += offset_m.x * offset_m.y;
        *yy += offset_m.y * offset_m.y;
    }

    /// Root of the mean square distance of the returns from their principal axis, whose square is the lesser eigenvalue
    /// of their covariance.
    fn off_line_m(&self) -> f64 {
        let n = f64::from(self.returns);
        let (mean, [xx, xy, yy]) = (self.sum / n, self.products.map(|sum| sum / n));
        let [xx, xy, yy] = [xx - mean.x * mean.x, xy - mean.x * mean.y, yy - mean.y * mean.y];
        (0.5 * (xx + yy) - Position::new(0.5 * (xx - yy), xy).norm()).max(0.0).sqrt()
    }
}
