//! `rbf`: the paper's dense similarity, equation (1).
//!
//! W_ij = exp(-σ ‖x_i - x_j‖²) for every pair of returns, exactly symmetric. It depends on distances alone, so it is
//! blind to every rigid motion, to mirroring, and to the order of the returns.

use crosscut_stage::{Affinity, AffinityStage, Invariance, Kind, Notes, Number, Revolution, StageError};
use nalgebra::distance_squared;

const SIGMA_PER_M2: Number = Number::new("sigma_per_m2", "1/m²", 1.5)
    .above(0.0)
    .to(1e6)
    .doc("σ of equation (1): how fast the similarity of two returns falls with their distance");

/// The paper's affinity.
pub const KIND: Kind<dyn AffinityStage> = Kind::affinity(
    "rbf",
    "every pair of returns, W_ij = exp(-σ ‖x_i - x_j‖²); the paper's equation (1), dense",
    |params| Box::new(Rbf { sigma_per_m2: params.get(SIGMA_PER_M2) }),
)
.params(&[SIGMA_PER_M2.spec])
.blind_to(Invariance::ALL);

struct Rbf {
    sigma_per_m2: f64,
}

impl AffinityStage for Rbf {
    fn weigh(&mut self, revolution: &Revolution, out: &mut Affinity, _: &mut Notes) -> Result<(), StageError> {
        let points_m = &revolution.points_m;
        let w = out.weights.make_dense(points_m.len());
        for (j, xj) in points_m.iter().enumerate() {
            // The part of column j above the diagonal is the part of row j left of it, computed already.
            for i in 0..j {
                w[(i, j)] = w[(j, i)];
            }
            let column = w.col_as_slice_mut(j);
            column[j] = 1.0;
            for (wij, xi) in column[j + 1..].iter_mut().zip(&points_m[j + 1..]) {
                // Equation (1).
                *wij = (-self.sigma_per_m2 * distance_squared(xi, xj)).exp();
            }
        }
        Ok(())
    }
}
