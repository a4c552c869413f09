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
    /// Writes what these scanners see, each with its pose in the common frame, into the points and beams of `out`. Gives the
    /// number of beams that see what their neighbours do.
    pub(super) fn look(&mut self, scanners: &[(Isometry3<f64>, &Revolution)], out: &mut Revolution) -> usize {
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
        let filled = self.fill(step_rad);
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
        filled
    }

    /// Where the scanners' beams diverge, or one of them looks past a corner, a single beam may have none of theirs in it. It
    /// sees as far as the farther of its two neighbours.
    fn fill(&mut self, step_rad: f64) -> usize {
        let beams = self.nearest.len();
        let is_seen: Vec<bool> =
            self.nearest.iter().zip(&self.is_free).map(|(near, free)| near.is_some() || *free).collect();
        let mut filled = 0;
        for beam in 0..beams {
            let sides = [(beam + beams - 1) % beams, (beam + 1) % beams];
            if is_seen[beam] || !sides.iter().all(|side| is_seen[*side]) {
                continue;
            }
            filled += 1;
            // A side without a return is free.
            let [left_m, right_m] = sides.map(|side| self.nearest[side].map(|(range_m, _)| range_m));
            match left_m.zip(right_m) {
                Some((left_m, right_m)) => {
                    let range_m = left_m.max(right_m);
                    let (sin, cos) = ((beam as f64 + 0.5) * step_rad - PI).sin_cos();
                    self.nearest[beam] = Some((range_m, Point::new(range_m * cos, range_m * sin, 0.0)));
                }
                None => self.is_free[beam] = true,
            }
        }
        filled
    }
}

#[cfg(test)]
mod tests {
    use crosscut_stage::Sweep;

    use super::*;

    /// Four beams of 90° from the back on, anticlockwise; none of the scanner's looks to the first.
    fn quarters(more: (f64, Beam, Option<Point>)) -> (usize, Revolution) {
        let (bearing_rad, beam, point_m) = more;
        let sweep = Sweep {
            bearings_rad: vec![0.05, 3.0, bearing_rad],
            beams: vec![Beam::Return(0), Beam::Return(1), beam],
            step_rad: 0.25 * PI,
            range_max_m: 9.0,
            ..Sweep::default()
        };
        let points_m = [Point::new(2.0, 0.1, 0.0), Point::new(-3.0, 0.4, 0.0)].into_iter().chain(point_m).collect();
        let seen = Revolution { points_m, sweep: Some(sweep), ..Revolution::default() };
        let mut out = Revolution::default();
        (Around::default().look(&[(Isometry3::identity(), &seen)], &mut out), out)
    }

    #[test]
    fn a_single_beam_between_others_sees_as_far_as_the_farther_one() {
        let (filled, out) = quarters((-0.1, Beam::Return(2), Some(Point::new(2.0, -0.2, 0.0))));
        let sweep = out.sweep.as_ref().expect("beams");
        assert_eq!((filled, sweep.beams.clone()), (1, (0..4).map(Beam::Return).collect()));
        assert_eq!(sweep.ranges_m[0], sweep.ranges_m[3]);
        assert!((out.bearing_rad(0) + 0.75 * PI).abs() < 1e-12);
        let (filled, out) = quarters((-1.5, Beam::NoReturn, None));
        let expected = [Beam::NoReturn, Beam::NoReturn, Beam::Return(0), Beam::Return(1)];
        assert_eq!((filled, out.sweep.map(|sweep| sweep.beams)), (1, Some(expected.to_vec())));
        let (filled, out) = quarters((-1.5, Beam::Unknown, None));
        assert_eq!((filled, out.sweep.map(|sweep| sweep.beams[0])), (0, Some(Beam::Unknown)), "two are not known");
    }
}
