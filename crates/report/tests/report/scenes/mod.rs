//! Scans computed by hand: axis-parallel walls, one ray per beam, range limit 15 m.

use std::f64::consts::PI;

use crosscut_stage::{Beam, Point, Revolution, Sweep};

const RANGE_MAX_M: f64 = 15.0;

/// A wall from one end to the other.
pub(crate) struct Segment(pub(crate) [f64; 2], pub(crate) [f64; 2]);

/// Distance along the ray at which it hits the segment.
fn hit(segment: &Segment, bearing_rad: f64) -> Option<f64> {
    let (dy, dx) = bearing_rad.sin_cos();
    let Segment(a, b) = segment;
    let (ex, ey) = (b[0] - a[0], b[1] - a[1]);
    let det = ex * dy - ey * dx;
    let range = (ex * a[1] - ey * a[0]) / det;
    let along = (dx * a[1] - dy * a[0]) / det;
    (range > 0.0 && (0.0..=1.0).contains(&along)).then_some(range)
}

/// A revolution of `beams` from -π, and the segment that each return lies on, as `wall_of_segment` names it.
pub(crate) fn scan(
    segments: &[(Segment, u32)],
    beams: usize,
    blind: impl Fn(f64) -> bool,
) -> (Revolution, Vec<Option<u32>>) {
    let step_rad = 2.0 * PI / beams as f64;
    let mut sweep = Sweep { step_rad, range_max_m: RANGE_MAX_M, full_turn: true, ..Default::default() };
    let (mut points_m, mut walls) = (Vec::new(), Vec::new());
    for beam in 0..beams {
        let bearing = -PI + (beam as f64 + 0.5) * step_rad;
        let nearest = segments
            .iter()
            .filter_map(|(segment, wall)| hit(segment, bearing).map(|range| (range, *wall)))
            .filter(|(range, _)| *range < RANGE_MAX_M)
            .min_by(|a, b| a.0.total_cmp(&b.0));
        sweep.bearings_rad.push(bearing);
        sweep.ranges_m.push(nearest.map_or(f32::INFINITY, |(range, _)| range as f32));
        sweep.beams.push(match nearest {
            _ if blind(bearing) => Beam::Unknown,
            None => Beam::NoReturn,
            Some((range, wall)) => {
                points_m.push(Point::new(range * bearing.cos(), range * bearing.sin(), 0.0));
                walls.push(Some(wall));
                Beam::Return(points_m.len() as u32 - 1)
            }
        });
    }
    (Revolution { points_m, sweep: Some(sweep), ..Default::default() }, walls)
}

pub(crate) fn tunnel() -> Vec<(Segment, u32)> {
    vec![(Segment([-30.0, 1.75], [30.0, 1.75]), 0), (Segment([-30.0, -1.75], [30.0, -1.75]), 1)]
}

/// A tunnel along x with a passage to the left between x = 3 and x = 6.5.
pub(crate) fn tee() -> Vec<(Segment, u32)> {
    vec![
        (Segment([-30.0, 1.75], [3.0, 1.75]), 0),
        (Segment([3.0, 1.75], [3.0, 30.0]), 0),
        (Segment([6.5, 30.0], [6.5, 1.75]), 1),
        (Segment([6.5, 1.75], [30.0, 1.75]), 1),
        (Segment([-30.0, -1.75], [30.0, -1.75]), 2),
    ]
}
