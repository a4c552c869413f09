//! Whether two scanners that state one frame see the same things in it: drivers state `laser` whatever they are told.

use std::f64::consts::TAU;

use crosscut_stage::{Revolution, wrap_angle_rad};

/// Ranges of one thing differ by less than this, m, and this share of them.
const NEAR_M: f64 = 0.1;
const NEAR_SHARE: f64 = 0.05;
/// Fewer beams where both see something show nothing.
const LEAST_COMPARED: usize = 30;
/// Edges and moving things aside, more than this share of the beams agree.
const AGREEING_SHARE: f64 = 0.5;

/// What was compared up to now.
#[derive(Debug, Default)]
pub(super) struct Agreement {
    compared: usize,
    agreeing: usize,
}

impl Agreement {
    /// Compares what two revolutions in one frame see where both see something.
    pub(super) fn compare(&mut self, first: &Revolution, other: &Revolution) {
        let Some(step_rad) = first.sweep.as_ref().map(|sweep| sweep.step_rad).filter(|step| *step < TAU) else {
            return;
        };
        let polar = |seen: &Revolution| -> Vec<(f64, f64)> {
            seen.points_m.iter().map(|point_m| (point_m.y.atan2(point_m.x), point_m.coords.norm())).collect()
        };
        let mut here = polar(first);
        here.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (bearing_rad, range_m) in polar(other) {
            let after = here.partition_point(|(other_rad, _)| *other_rad < bearing_rad);
            let near = [after.checked_sub(1), Some(after)].into_iter().flatten().filter_map(|at| here.get(at));
            let apart_rad = |other_rad: f64| wrap_angle_rad(other_rad - bearing_rad).abs();
            let nearest = near.min_by(|a, b| apart_rad(a.0).total_cmp(&apart_rad(b.0)));
            if let Some((_, other_m)) = nearest.filter(|(other_rad, _)| apart_rad(*other_rad) <= step_rad) {
                self.compared += 1;
                self.agreeing += usize::from((other_m - range_m).abs() <= NEAR_M + NEAR_SHARE * range_m);
            }
        }
    }

    /// Whether the two cannot be in one frame. Scanners that look at different things may be.
    pub(super) fn is_refuted(&self) -> bool {
        self.compared >= LEAST_COMPARED && (self.agreeing as f64) < AGREEING_SHARE * self.compared as f64
    }
}

#[cfg(test)]
mod tests {
    use crosscut_stage::{Point, Sweep};

    use super::*;

    /// The walls of a passage 4 m wide, seen from the middle by beams 2° apart, as a scanner turned by `yaw_rad` states them.
    fn passage(yaw_rad: f64) -> Revolution {
        let point = |beam: i32| {
            let bearing_rad = f64::from(beam).to_radians() * 2.0;
            let range_m = 2.0 / (bearing_rad + yaw_rad).sin().abs().max(0.2);
            Point::new(range_m * bearing_rad.cos(), range_m * bearing_rad.sin(), 0.0)
        };
        let sweep = Sweep { step_rad: 2f64.to_radians(), ..Sweep::default() };
        Revolution { points_m: (-45..45).map(point).collect(), sweep: Some(sweep), ..Revolution::default() }
    }

    #[test]
    fn a_scanner_that_is_turned_does_not_lie_in_the_same_frame() {
        for (yaw_rad, is_refuted) in [(0.0, false), (std::f64::consts::FRAC_PI_2, true)] {
            let mut agreement = Agreement::default();
            agreement.compare(&passage(0.0), &passage(yaw_rad));
            assert_eq!(agreement.is_refuted(), is_refuted, "{yaw_rad}: {agreement:?}");
        }
    }
}
