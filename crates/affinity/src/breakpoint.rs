//! `breakpoint`: the adaptive breakpoint detector, a baseline (Borges and Aldon 2004).

use crosscut_stage::{
    Affinity, AffinityStage, Beam, Interval, Invariance, Kind, Notes, ParamError, ParamSpec, Revolution, Shape,
    StageError, Sweep, Value,
};
use nalgebra::distance;

use crate::edges::{edges_bytes, write_edges};
use crate::finite::check_finite;

const LAMBDA_DEG: ParamSpec = ParamSpec {
    name: "lambda_deg",
    unit: "°",
    shape: Shape::Number { default: 4.0, range: Interval::above(0.0, 90.0) },
    doc: "λ, the smallest angle between a beam and the wall that it hits",
};

const RANGE_NOISE_M: ParamSpec = ParamSpec {
    name: "range_noise_m",
    unit: "m",
    shape: Shape::Number { default: 0.02, range: Interval::closed(0.0, 10.0) },
    doc: "σ_r, the standard deviation of a range",
};

const MISSING_BEAMS: ParamSpec = ParamSpec {
    name: "missing_beams",
    unit: "beams",
    shape: Shape::Integer { default: 3, min: 0, max: 10_000 },
    doc: "beams without a return that may lie between two neighbours; more break the wall",
};

pub(crate) const KIND: Kind<dyn AffinityStage> = Kind {
    name: "breakpoint",
    doc: "a 0/1 graph: an edge between neighbouring returns unless their distance jumps (adaptive breakpoints, baseline)",
    params: &[LAMBDA_DEG, RANGE_NOISE_M, MISSING_BEAMS],
    build: |params| {
        let (lambda_deg, range_noise_m) = (params.number(LAMBDA_DEG.name), params.number(RANGE_NOISE_M.name));
        Box::new(Breakpoint::with(lambda_deg, range_noise_m, params.count(MISSING_BEAMS.name)))
    },
};

/// W_ij = 1 between neighbouring returns, an angle Δφ apart, of which no wall that a beam meets at λ or more could put
/// one out of reach of the other:
///
/// ‖x_i - x_j‖ <= r sin Δφ / sin(λ - Δφ) + 3 σ_r, where r is the nearer range of the two.
///
/// The paper takes the range of the return before; the nearer one is what its drawing shows, and makes the answer the
/// same in both directions of turning. Neighbours are successive returns with at most `missing_beams` beams between
/// them (nothing in range, masked or unreadable, all alike); Δφ is the angle between the two, and they break if it
/// reaches λ. In a full turn the last return is a neighbour of the first. A sweep is needed: a cloud has no
/// neighbouring beams.
#[derive(Clone, Debug)]
pub struct Breakpoint {
    lambda_rad: f64,
    range_noise_m: f64,
    missing_beams: usize,
    /// The beam of each return.
    beam_of_return: Vec<usize>,
    /// Whether a return is tied to the next one; the last one's next is the first.
    tied_to_next: Vec<bool>,
}

impl Breakpoint {
    /// λ in degrees, in (0, 90]; the standard deviation of a range, metres; how many beams may be missing.
    ///
    /// # Errors
    /// When a number is out of range.
    pub fn new(lambda_deg: f64, range_noise_m: f64, missing_beams: u32) -> Result<Self, ParamError> {
        LAMBDA_DEG.check(Value::Number(lambda_deg))?;
        RANGE_NOISE_M.check(Value::Number(range_noise_m))?;
        MISSING_BEAMS.check(Value::Integer(missing_beams.into()))?;
        Ok(Self::with(lambda_deg, range_noise_m, missing_beams as usize))
    }

    fn with(lambda_deg: f64, range_noise_m: f64, missing_beams: usize) -> Self {
        let (lambda_rad, beam_of_return, tied_to_next) = (lambda_deg.to_radians(), Vec::new(), Vec::new());
        Self { lambda_rad, range_noise_m, missing_beams, beam_of_return, tied_to_next }
    }

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

    /// Whether return j, `steps` beams after return i, goes on with the wall of i.
    fn goes_on(&self, revolution: &Revolution, i: usize, j: usize, steps: usize, step_rad: f64) -> bool {
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
    fn affinity(&mut self, revolution: &Revolution, out: &mut Affinity, _: &mut Notes) -> Result<(), StageError> {
        let n = revolution.len();
        check_finite(&revolution.points_m)?;
        let Some(sweep) = revolution.beams() else {
            let message = "affinity `breakpoint` needs the beams of a 2D sweep, which a point cloud does not have";
            return Err(StageError::Unsupported(message.to_owned()));
        };
        self.read_beams(sweep, n)?;
        self.tied_to_next.clear();
        for i in 0..n {
            let (j, beam) = ((i + 1) % n, self.beam_of_return[i]);
            let wraps = i + 1 == n;
            // For the last return: through the last beam, and those that a turn is short of, to the first.
            let steps = self.beam_of_return[j] + if wraps { sweep.len() + sweep.missing } else { 0 } - beam;
            let neighbours = i != j && (!wraps || sweep.full_turn);
            self.tied_to_next.push(neighbours && self.goes_on(revolution, i, j, steps, sweep.step_rad));
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

    fn memory_bytes(&self, n: usize) -> u64 {
        edges_bytes(n, 3)
    }

    fn invariances(&self) -> &'static [Invariance] {
        // It sees ranges, distances and the order of the beams.
        &[Invariance::Turn, Invariance::Mirror]
    }
}
