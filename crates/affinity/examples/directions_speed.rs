//! Prints how long a cloud takes to its ways, by number of points: the median of 101 clouds, in one thread.
//!
//! ```text
//! cargo run --release -p crosscut-affinity --example directions_speed
//! ```

use std::time::Instant;

use crosscut_affinity::directions;
use crosscut_stage::{Affinity, Notes, Point, Revolution};

/// A crossing of two galleries, 4 m wide and 3 m high, as rings of 512 beams see it that look everywhere.
fn crossing(rings: usize) -> Vec<Point> {
    let point = |at: usize| {
        let (ring, column) = ((at / 512) as f64, (at % 512) as f64);
        let (up, out) = ((ring + 0.5) / rings as f64 * std::f64::consts::PI - std::f64::consts::FRAC_PI_2).sin_cos();
        let (sin, cos) = (column / 512.0 * std::f64::consts::TAU).sin_cos();
        let sides_m = 2.0 / (out * sin).abs().min((out * cos).abs()).max(1e-9);
        let range_m = sides_m.min(1.5 / up.abs()).min(80.0);
        Point::new(out * cos * range_m, out * sin * range_m, up * range_m)
    };
    (0..rings * 512).map(point).collect()
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut stage = directions::KIND.with(&[])?;
    println!("points  ways  median ms");
    for rings in [32, 64, 128, 256] {
        let revolution = Revolution { cloud_m: crossing(rings), ..Revolution::default() };
        let (mut out, mut notes, mut ms) = (Affinity::default(), Notes::default(), Vec::new());
        for _ in 0..101 {
            let started = Instant::now();
            stage.affinity(&revolution, &mut out, &mut notes)?;
            ms.push(started.elapsed().as_secs_f64() * 1e3);
        }
        ms.sort_by(f64::total_cmp);
        let ways = out.dual.map_or(0, |dual| dual.ways.len());
        println!("{:6}  {ways:4}  {:9.1}", revolution.cloud_m.len(), ms[50]);
    }
    Ok(())
}
