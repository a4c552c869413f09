//! `rbf`: the paper's dense similarity, equation (1).

use crosscut_stage::{
    Affinity, AffinityStage, Interval, Invariance, Kind, Notes, ParamError, ParamSpec, Revolution, Shape, StageError,
    Value,
};
use nalgebra::distance_squared;

use crate::finite::check_finite;

const SIGMA_PER_M2: ParamSpec = ParamSpec {
    name: "sigma_per_m2",
    unit: "1/m²",
    shape: Shape::Number { default: 1.5, range: Interval::above(0.0, 1e6) },
    doc: "σ of equation (1): how fast the similarity of two returns falls with their distance",
};

pub(crate) const KIND: Kind<dyn AffinityStage> = Kind {
    name: "rbf",
    doc: "every pair of returns, W_ij = exp(-σ ‖x_i - x_j‖²); the paper's equation (1), dense",
    params: &[SIGMA_PER_M2],
    build: |params| Box::new(Rbf { sigma_per_m2: params.number(SIGMA_PER_M2.name) }),
};

/// W_ij = exp(-σ ‖x_i - x_j‖²) for every pair of returns, dense and exactly symmetric.
///
/// It depends on distances alone, so it is blind to every rigid motion, to mirroring, and to the order of the returns.
#[derive(Clone, Debug)]
pub struct Rbf {
    sigma_per_m2: f64,
}

impl Rbf {
    /// σ in 1/m², above 0; the paper has 1.5.
    ///
    /// # Errors
    /// When σ is out of range.
    pub fn new(sigma_per_m2: f64) -> Result<Self, ParamError> {
        SIGMA_PER_M2.check(Value::Number(sigma_per_m2))?;
        Ok(Self { sigma_per_m2 })
    }
}

impl AffinityStage for Rbf {
    fn affinity(&mut self, revolution: &Revolution, out: &mut Affinity, _: &mut Notes) -> Result<(), StageError> {
        let points_m = &revolution.points_m;
        check_finite(points_m)?;
        let n = points_m.len();
        let w = out.weights.make_dense(n);
        out.degrees.clear();
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
            out.degrees.push(column.iter().sum());
        }
        Ok(())
    }

    fn memory_bytes(&self, n: usize) -> u64 {
        // Columns of a dense matrix start on multiples of 64 bytes.
        let (rows, n) = (n.next_multiple_of(8) as u64, n as u64);
        rows.saturating_mul(n).saturating_add(n).saturating_mul(8)
    }

    fn invariances(&self) -> &'static [Invariance] {
        &[Invariance::Translation, Invariance::Rotation, Invariance::Turn, Invariance::Mirror, Invariance::Permutation]
    }
}
