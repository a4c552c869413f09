//! `breakpoint`: the adaptive breakpoint detector, a baseline (Borges and Aldon 2004).
//!
//! W_ij = 1 between neighbouring returns, an angle Δφ apart, unless their distance shows that a wall ends between them:
//!
//! ‖x_i - x_j‖ <= r sin Δφ / sin(λ - Δφ) + 3 σ_r, where r is the nearer range of the two.
//!
//! The right side is the farthest that a wall can reach which a beam meets at an angle of λ or more. The paper takes the
//! range of the return before; its drawing shows the nearer one, which gives the same answer in both directions of
//! turning. Neighbours are successive returns with at most `missing_beams` beams between them (nothing in range, masked
//! or unreadable, all alike); Δφ is the angle between the two, and they break if it reaches λ. In a full turn the last
//! return is a neighbour of the first; across a blind sector of more than 30° none are neighbours. Points without beams have no neighbours, so a sweep is needed.

use crosscut_scan::Ring;
use crosscut_stage::{Affinity, AffinityStage, Count, Invariance, Kind, Notes, Number, Revolution, StageError};
use nalgebra::distance;

use crate::edges::Neighbours;

const LAMBDA_DEG: Number = Number::new("lambda_deg", "°", 4.0)
    .above(0.0)
    .to(90.0)
    .doc("λ, the smallest angle between a beam and the wall that it hits");

const RANGE_NOISE_M: Number =
    Number::new("range_noise_m", "m", 0.02).from(0.0).to(10.0).doc("σ_r, the standard deviation of a range");

const MISSING_BEAMS: Count = Count::new("missing_beams", "beams", 3)
    .to(10_000)
    .doc("beams without a return that may lie between two neighbours; more break the wall");

/// Adaptive breakpoints.
pub const KIND: Kind<dyn AffinityStage> = Kind::affinity(
    "breakpoint",
    "a 0/1 graph: an edge between neighbouring returns unless their distance jumps (adaptive breakpoints, baseline)",
    |params| {
        Box::new(Breakpoint {
            lambda_rad: params.get(LAMBDA_DEG).to_radians(),
            range_noise_m: params.get(RANGE_NOISE_M),
            missing_beams: params.get(MISSING_BEAMS),
            ring: Ring::default(),
            neighbours: Neighbours::default(),
        })
    },
)
.params(&[LAMBDA_DEG.spec, RANGE_NOISE_M.spec, MISSING_BEAMS.spec])
.needs_beams()
// It sees ranges, distances and the order of the beams.
.blind_to(&[Invariance::Turn, Invariance::Mirror]);

struct Breakpoint {
    lambda_rad: f64,
    range_noise_m: f64,
    missing_beams: usize,
    ring: Ring,
    neighbours: Neighbours,
}

impl Breakpoint {
    /// Whether the wall of a return of the ring continues at the next one.
    fn continues(&self, revolution: &Revolution, at: usize, next: usize) -> bool {
        let steps = self.ring.beams_from(at, next);
        let angle_rad = steps as f64 * self.ring.step_rad;
        if steps > self.missing_beams + 1 || angle_rad >= self.lambda_rad {
            return false;
        }
        let [i, j] = [at, next].map(|at| self.ring.returns[at].number as usize);
        let nearer_m = revolution.range_m(i).min(revolution.range_m(j));
        let reach_m = nearer_m * angle_rad.sin() / (self.lambda_rad - angle_rad).sin() + 3.0 * self.range_noise_m;
        distance(&revolution.points_m[i], &revolution.points_m[j]) <= reach_m
    }
}

impl AffinityStage for Breakpoint {
    fn weigh(&mut self, revolution: &Revolution, out: &mut Affinity, _: &mut Notes) -> Result<(), StageError> {
        let Some(sweep) = revolution.beams() else { return Err(StageError::without_beams("breakpoint")) };
        self.ring.fill(sweep, &revolution.points_m)?;
        self.neighbours.reset(self.ring.len());
        for at in 0..self.ring.len() {
            let next = self.ring.after(at, 1).filter(|&next| next != at);
            if let Some(next) = next.filter(|&next| self.continues(revolution, at, next)) {
                let [i, j] = [at, next].map(|at| self.ring.returns[at].number);
                self.neighbours.connect(i, j);
            }
        }
        self.neighbours.write(out);
        Ok(())
    }
}
