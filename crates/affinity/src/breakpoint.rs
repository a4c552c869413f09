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
//! return is a neighbour of the first. Points without beams have no neighbours, so a sweep is needed.

use crosscut_stage::{
    Affinity, AffinityStage, Beam, Count, Invariance, Kind, Notes, Number, Revolution, StageError, Sweep,
};
use nalgebra::distance;

use crate::edges::write_edges;

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
            beam_of_return: Vec::new(),
            tied_to_next: Vec::new(),
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
    /// The beam of each return.
    beam_of_return: Vec<usize>,
    /// Whether a return has an edge to the next one; the last one's next is the first.
    tied_to_next: Vec<bool>,
}

impl Breakpoint {
    /// Fills `beam_of_return`.
    fn read_beams(&mut self, sweep: &Sweep, n: usize) -> Result<(), StageError> {
        self.beam_of_return.clear();
        for (number, beam) in sweep.beams.iter().enumerate() {
            if let Beam::Return(index) = beam {
                if *index as usize != self.beam_of_return.len() {
                    return Err(StageError::Mismatch(format!("beam {number} has return {index}: not in beam order")));
                }
                self.beam_of_return.push(number);
            }
        }
        match self.beam_of_return.len() {
            returns if returns == n => Ok(()),
            returns => Err(StageError::Mismatch(format!("beams with a return: {returns}, returns: {n}"))),
        }
    }

    /// Whether return j, `steps` beams after return i, continues the wall of i.
    fn continues(&self, revolution: &Revolution, i: usize, j: usize, steps: usize, step_rad: f64) -> bool {
        let angle_rad = steps as f64 * step_rad;
        if steps > self.missing_beams + 1 || angle_rad >= self.lambda_rad {
            return false;
        }
        let nearer_m = revolution.range_m(i).min(revolution.range_m(j));
        let reach_m = nearer_m * angle_rad.sin() / (self.lambda_rad - angle_rad).sin() + 3.0 * self.range_noise_m;
        distance(&revolution.points_m[i], &revolution.points_m[j]) <= reach_m
    }
}

impl AffinityStage for Breakpoint {
    fn weigh(&mut self, revolution: &Revolution, out: &mut Affinity, _: &mut Notes) -> Result<(), StageError> {
        let n = revolution.len();
        let Some(sweep) = revolution.beams() else { return Err(StageError::without_beams("breakpoint")) };
        self.read_beams(sweep, n)?;
        self.tied_to_next.clear();
        for i in 0..n {
            let (j, beam) = ((i + 1) % n, self.beam_of_return[i]);
            let wraps = i + 1 == n;
            // For the last return: through the last beam, and those that a turn is short of, to the first.
            let steps = self.beam_of_return[j] + if wraps { sweep.len() + sweep.missing } else { 0 } - beam;
            let neighbours = i != j && (!wraps || sweep.full_turn);
            self.tied_to_next.push(neighbours && self.continues(revolution, i, j, steps, sweep.step_rad));
        }
        if let [first, last] = self.tied_to_next.as_mut_slice() {
            // Two returns have one edge, whether they are tied through the seam or not.
            *first |= std::mem::take(last);
        }
        write_edges(out, n, |i, row| {
            let (previous, next) = ((i + n - 1) % n, (i + 1) % n);
            let tied = [Some(i), self.tied_to_next[previous].then_some(previous), self.tied_to_next[i].then_some(next)];
            row.extend(tied.into_iter().flatten().map(|j| j as u32));
            row.sort_unstable();
        });
        Ok(())
    }
}
