//! What each part of the geometry of a scan promises, on scans computed by hand.

mod directions;
mod gaps;
mod islands;
mod roughness;
mod single_returns;

use std::f64::consts::{PI, TAU};

use crosscut_scan::{Lengths, Scan};
use crosscut_stage::{Beam, Point, Sweep};

/// The lengths of preset `default` for a vehicle of 0.6 m.
const LENGTHS: Lengths = Lengths { passage_m: 0.6, island_m: 2.0, stretch_m: 0.85 };

/// Farther, nothing comes back.
const RANGE_MAX_M: f64 = 30.0;

/// A wall from one point to another, metres.
type Segment = [[f64; 2]; 2];

/// The range of the nearest wall in a direction, metres; infinite without one.
fn range_m(walls: &[Segment], bearing_rad: f64) -> f64 {
    let (sin, cos) = bearing_rad.sin_cos();
    let range_m = |&[[ax, ay], [bx, by]]: &Segment| {
        let (along_x, along_y) = (bx - ax, by - ay);
        let across = cos * along_y - sin * along_x;
        let (range_m, share) = ((ax * along_y - ay * along_x) / across, (ax * sin - ay * cos) / across);
        if range_m > 0.0 && (0.0..=1.0).contains(&share) { range_m } else { f64::INFINITY }
    };
    walls.iter().map(range_m).fold(f64::INFINITY, f64::min)
}

/// A full turn of `beams` beams, the first one at -π, with this range in each direction.
fn scan_of(beams: usize, range_m: impl Fn(usize, f64) -> f64) -> Scan {
    let step_rad = TAU / beams as f64;
    let (mut sweep, mut points_m) = (Sweep { step_rad, full_turn: true, ..Sweep::default() }, Vec::new());
    sweep.range_max_m = RANGE_MAX_M;
    for beam in 0..beams {
        let bearing_rad = -PI + (beam as f64 + 0.5) * step_rad;
        let range_m = range_m(beam, bearing_rad);
        sweep.bearings_rad.push(bearing_rad);
        sweep.beams.push(if range_m < RANGE_MAX_M {
            points_m.push(Point::new(range_m * bearing_rad.cos(), range_m * bearing_rad.sin(), 0.0));
            Beam::Return(points_m.len() as u32 - 1)
        } else {
            Beam::NoReturn
        });
    }
    let mut scan = Scan::default();
    scan.make(&sweep, &points_m, &LENGTHS).expect("in message order");
    scan
}

/// A scan of walls.
fn scan(beams: usize, walls: &[Segment]) -> Scan {
    scan_of(beams, |_, bearing_rad| range_m(walls, bearing_rad))
}

/// A closed room around the sensor, this far to each side.
fn room(half_m: f64) -> Vec<Segment> {
    let corners = [[half_m, half_m], [-half_m, half_m], [-half_m, -half_m], [half_m, -half_m]];
    (0..4).map(|at| [corners[at], corners[(at + 1) % 4]]).collect()
}
