//! An affinity of one's own: W_ij = 1 / (1 + (‖x_i - x_j‖ / scale)⁴). `cargo run` in this folder; `cargo test` holds it to
//! what the rest of the program relies on.

use std::error::Error;

use crosscut_pipeline::stage::{
    Affinity, AffinityStage, Invariance, Kind, Notes, Number, Point, Revolution, StageError, Storage,
};
use crosscut_pipeline::{Engine, Frame, Preset, Registry, Settings};

const SCALE_M: Number = Number::new("scale_m", "m", 0.5).above(0.0).to(100.0).doc("distance at which W_ij is 1/2");

const KIND: Kind<dyn AffinityStage> =
    Kind::affinity("quartic", "every pair of returns, falling with the fourth power of their distance", |params| {
        Box::new(Quartic { scale_m: params.get(SCALE_M) })
    })
    .params(&[SCALE_M.spec])
    .storage(Storage::Dense)
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

fn main() -> Result<(), Box<dyn Error>> {
    let mut registry = Registry::standard();
    registry.affinity.push(KIND);
    let settings = Settings::new(Preset::Paper).set("affinity.kind", "quartic").set("spectral.zero_tolerance", 0.05);
    let mut engine = Engine::new(&settings.config(&registry)?, &registry);

    // Two walls, 6 m apart: each a row of returns 20 cm apart.
    let mut frame = Frame::default();
    let rows = [-3.0, 3.0].into_iter().flat_map(|y| (0..20).map(move |i| Point::new(0.2 * f64::from(i), y, 0.0)));
    frame.revolution.points_m.extend(rows);
    engine.process(&mut frame)?;
    println!("{} walls", frame.junction.junctions);
    Ok(())
}

#[test]
fn the_rest_of_the_program_can_rely_on_it() {
    crosscut_conformance::affinity::all(&KIND);
}
