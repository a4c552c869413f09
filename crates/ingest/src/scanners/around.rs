//! The revolution that a lidar in the common frame would see, of what several scanners see.

use std::f64::consts::{PI, TAU};

use crosscut_stage::{Beam, Point, Revolution};
use nalgebra::Isometry3;

/// A beam is at least this wide, rad: at most 2048 beams.
const LEAST_STEP_RAD: f64 = TAU / 2048.0;
/// Free space of scanners that state no limit ends here, m.
const NO_LIMIT_M: f64 = 1e3;

/// Beams all around the origin of the common frame. Each is as wide as two steps of the coarsest scanner, as their steps
/// look wider from a place that is nearer to a wall, and sees the nearest return in it.
#[derive(Debug, Default)]
pub(super) struct Around {
    nearest: Vec<Option<(f64, Point)>>,
    is_free: Vec<bool>,
}

impl Around {
    /// Writes what these scanners see, each with its pose in the common frame, into the points and beams of `out`.
    pub(super) fn look(&mut self, scanners: &[(Isometry3<f64>, &Revolution)], out: &mut Revolution) {
        let sweeps = || scanners.iter().filter_map(|(_, seen)| seen.sweep.as_ref());
        let coarsest_rad =
            sweeps().map(|sweep| sweep.step_rad).filter(|step| *step < PI).fold(LEAST_STEP_RAD, f64::max);
        let beams = ((TAU / (2.0 * coarsest_rad)).round() as usize).clamp(4, 2048);
        let step_rad = TAU / beams as f64;
        let beam_of = |at: &Point| (((at.y.atan2(at.x) + PI) / step_rad) as usize).min(beams - 1);
        self.nearest.clear();
        self.nearest.resize(beams, None);
        self.is_free.clear();
        self.is_free.resize(beams, false);
        for (pose, seen) in scanners {
            for point_m in &seen.points_m {
                let point_m = pose * point_m;
                let range_m = point_m.x.hypot(point_m.y);
                let nearest = &mut self.nearest[beam_of(&point_m)];
                if nearest.is_none_or(|(nearest_m, _)| range_m < nearest_m) {
                    *nearest = Some((range_m, Point::new(point_m.x, point_m.y, 0.0)));
                }
            }
            let Some(sweep) = &seen.sweep else { continue };
            let end_m = sweep.range_max_m.min(NO_LIMIT_M);
            let free = sweep.beams.iter().zip(&sweep.bearings_rad).filter(|(beam, _)| **beam == Beam::NoReturn);
            for (_, bearing_rad) in free {
                let (sin, cos) = bearing_rad.sin_cos();
                self.is_free[beam_of(&(pose * Point::new(end_m * cos, end_m * sin, 0.0)))] = true;
            }
        }
        let range_max_m = sweeps().map(|sweep| sweep.range_max_m).fold(0.0, f64::max);
        out.points_m.clear();
        let sweep = out.sweep.get_or_insert_default();
        sweep.clear();
        (sweep.step_rad, sweep.full_turn, sweep.range_max_m) = (step_rad, true, range_max_m);
        sweep.wire_geometry = [0.5 * step_rad - PI, step_rad, 0.0, range_max_m].map(|value| value as f32);
        for (beam, (nearest, is_free)) in self.nearest.iter().zip(&self.is_free).enumerate() {
            sweep.bearings_rad.push((beam as f64 + 0.5) * step_rad - PI);
            let (range_m, seen) = match nearest {
                Some((range_m, point_m)) => {
                    out.points_m.push(*point_m);
                    (*range_m as f32, Beam::Return(out.points_m.len() as u32 - 1))
                }
                None if *is_free => (f32::INFINITY, Beam::NoReturn),
                None => (f32::NAN, Beam::Unknown),
            };
            sweep.ranges_m.push(range_m);
            sweep.beams.push(seen);
        }
    }
}
