//! An affinity of one's own, and the whole program with it:
//!
//! ```text
//! F=../../recordings/tee.mcap
//! cargo run -- run $F --preset paper --set affinity.kind=quartic --set spectral.zero_tolerance=0.003
//! cargo run -- compare $F --with paper --with paper,affinity.kind=quartic,spectral.zero_tolerance=0.003
//! cargo run -- config --preset paper --set affinity.kind=quartic
//! ```
//!
//! `cargo test` holds it to what the rest of the program relies on.

use std::process::ExitCode;

use crosscut_detector::Registry;
use crosscut_detector::stage::{Affinity, AffinityStage, Invariance, Kind, Notes, Number, Revolution, StageError};

const SCALE_M: Number = Number::new("scale_m", "m", 0.5).above(0.0).to(100.0).doc("distance at which W_ij is 1/2");

/// W_ij = 1 / (1 + (‖x_i - x_j‖ / scale)⁴).
const QUARTIC: Kind<dyn AffinityStage> =
    Kind::affinity("quartic", "every pair of returns, falling with the fourth power of their distance", |params| {
        Box::new(Quartic { scale_m: params.get(SCALE_M) })
    })
    .params(&[SCALE_M.spec])
    .blind_to(Invariance::ALL);

struct Quartic {
    scale_m: f64,
}

impl AffinityStage for Quartic {
    fn weigh(&mut self, revolution: &Revolution, out: &mut Affinity, _: &mut Notes) -> Result<(), StageError> {
        let points_m = &revolution.points_m;
        let w = out.weights.make_dense(points_m.len());
        for (j, b) in points_m.iter().enumerate() {
            for (i, a) in points_m.iter().enumerate() {
                w[(i, j)] = 1.0 / (1.0 + ((a - b).norm() / self.scale_m).powi(4));
            }
        }
        Ok(())
    }
}

fn main() -> ExitCode {
    let mut registry = Registry::standard();
    registry.affinity.push(QUARTIC);
    crosscut::main(&registry)
}

#[test]
fn the_rest_of_the_program_can_rely_on_it() {
    crosscut_conformance::affinity::all(&QUARTIC);
}
