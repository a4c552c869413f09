//! The geometry of one revolution.

use crosscut_stage::{Point, StageError, Sweep};

use crate::dust::Dust;
use crate::islands::Islands;
use crate::lengths::Lengths;
use crate::median;
use crate::pieces::Pieces;
use crate::ring::Ring;
use crate::roughness::Roughness;
use crate::vehicle;

/// Tunnels are not wider than this to either side. Where the median range is larger, the place is a hall, and its ways
/// on are no wider for that.
const HALL_M: f64 = 4.5;

/// The geometry of one revolution: what a sweep shows before anything is decided. It does not change once it is made;
/// its buffers are reused for the next revolution.
#[derive(Clone, Debug, Default)]
pub struct Scan {
    /// All returns.
    pub ring: Ring,
    /// The pieces of walls: the returns that neither hang in the air, nor are of the vehicle or of an island.
    pub pieces: Pieces,
    /// The pieces that stand free in front of others.
    pub islands: Islands,
    /// How rough the walls are.
    pub roughness: Roughness,
    /// The size of the place: the median range of its walls, or 4.5 m if that is less.
    pub size_m: f64,
    /// Number of returns in the air: dust, and mixed returns beside pillars.
    pub dust_returns: usize,
    /// Number of returns of the vehicle itself.
    pub self_returns: usize,
    dust: Dust,
    /// For each return.
    are_of_vehicle: Vec<bool>,
}

impl Scan {
    /// Makes the geometry of a sweep, whose points these are; nothing of an earlier one is left.
    ///
    /// # Errors
    /// When the beams do not list all points in message order.
    pub fn make(&mut self, sweep: &Sweep, points_m: &[Point], lengths: &Lengths) -> Result<(), StageError> {
        let Self { ring, pieces, islands, dust, are_of_vehicle, .. } = self;
        ring.fill(sweep, points_m)?;
        let is_dust = dust.find(ring, lengths);
        vehicle::find(ring, lengths.passage_m / 2.0, are_of_vehicle);
        pieces.fill(ring, (0..ring.len()).filter(|&i| !is_dust[i] && !are_of_vehicle[i]), lengths.passage_m);
        self.dust_returns = is_dust.iter().filter(|is_dust| **is_dust).count();
        self.self_returns = ring.len() - self.dust_returns - pieces.returns().len();
        self.roughness = Roughness::of(ring, pieces);
        islands.take(ring, &self.roughness, pieces, lengths);
        let mut ranges_m: Vec<f64> = pieces.returns().iter().map(|&i| ring.range_m(i)).collect();
        self.size_m = median(&mut ranges_m, f64::total_cmp).min(HALL_M);
        Ok(())
    }
}
