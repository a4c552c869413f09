//! `threshold`: returns within a radius of each other, a baseline.

use crosscut_stage::{
    Affinity, AffinityStage, Interval, Invariance, Kind, Notes, ParamError, ParamSpec, Revolution, Shape, StageError,
    Value,
};

use crate::columns::Columns;
use crate::edges::{edges_bytes, write_edges};
use crate::finite::check_finite;

const RADIUS_M: ParamSpec = ParamSpec {
    name: "radius_m",
    unit: "m",
    shape: Shape::Number { default: 2.5, range: Interval::above(0.0, 1e6) },
    doc: "returns no farther apart than this have an edge",
};

pub(crate) const KIND: Kind<dyn AffinityStage> = Kind {
    name: "threshold",
    doc: "a 0/1 graph: an edge between any two returns within a radius (baseline)",
    params: &[RADIUS_M],
    build: |params| Box::new(Threshold::with(params.number(RADIUS_M.name))),
};

/// W_ij = 1 if ‖x_i - x_j‖ <= radius, else 0: single-linkage clustering, once its components are taken.
///
/// Only returns in columns around each other are looked at. It depends on distances alone, so it is blind to every
/// rigid motion, to mirroring, and to the order of the returns.
#[derive(Clone, Debug)]
pub struct Threshold {
    radius_m: f64,
    columns: Columns,
}

impl Threshold {
    /// The radius in metres, above 0.
    ///
    /// # Errors
    /// When the radius is out of range.
    pub fn new(radius_m: f64) -> Result<Self, ParamError> {
        RADIUS_M.check(Value::Number(radius_m))?;
        Ok(Self::with(radius_m))
    }

    fn with(radius_m: f64) -> Self {
        Self { radius_m, columns: Columns::default() }
    }
}

impl AffinityStage for Threshold {
    fn affinity(&mut self, revolution: &Revolution, out: &mut Affinity, _: &mut Notes) -> Result<(), StageError> {
        let points_m = &revolution.points_m;
        check_finite(points_m)?;
        self.columns.fill(points_m, self.radius_m);
        write_edges(out, points_m.len(), |i, row| self.columns.near(points_m, &points_m[i], self.radius_m, row));
        Ok(())
    }

    fn memory_bytes(&self, n: usize) -> u64 {
        edges_bytes(n, n) // at worst: all within one radius
    }

    fn invariances(&self) -> &'static [Invariance] {
        &[Invariance::Translation, Invariance::Rotation, Invariance::Turn, Invariance::Mirror, Invariance::Permutation]
    }
}
