//! `threshold`: an edge between any two returns within a radius of each other, a baseline.
//!
//! W_ij = 1 if ‖x_i - x_j‖ <= radius, else 0: single-linkage clustering, once its components are taken. It depends on
//! distances alone, so it is blind to every rigid motion, to mirroring, and to the order of the returns.

use crosscut_stage::{Affinity, AffinityStage, Invariance, Kind, Notes, Number, Revolution, StageError};
use nalgebra::distance_squared;

use crate::edges::write_edges;

const RADIUS_M: Number =
    Number::new("radius_m", "m", 2.5).above(0.0).to(1e6).doc("returns no farther apart than this have an edge");

/// The threshold graph.
pub const KIND: Kind<dyn AffinityStage> =
    Kind::affinity("threshold", "a 0/1 graph: an edge between any two returns within a radius (baseline)", |params| {
        Box::new(Threshold { radius_m: params.get(RADIUS_M) })
    })
    .params(&[RADIUS_M.spec])
    .blind_to(Invariance::ALL);

struct Threshold {
    radius_m: f64,
}

impl AffinityStage for Threshold {
    fn weigh(&mut self, revolution: &Revolution, out: &mut Affinity, _: &mut Notes) -> Result<(), StageError> {
        let points_m = &revolution.points_m;
        let square_m2 = self.radius_m * self.radius_m;
        write_edges(out, points_m.len(), |i, row| {
            let near = (0..).zip(points_m).filter(|(_, point)| distance_squared(&points_m[i], point) <= square_m2);
            row.extend(near.map(|(number, _)| number));
        });
        Ok(())
    }
}
