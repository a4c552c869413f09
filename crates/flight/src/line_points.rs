//! Returns that lie on a line of returns, with the normal of that line.

use nalgebra::{Isometry2, Matrix2, Point2, Unit, Vector2};

use crosscut_stage::Point;

/// Neighbours on each side, in message order, that the line is fitted to.
const NEIGHBOURS: usize = 4;

/// Neighbours farther away than this are of another surface, unless returns lie as far apart.
const REACH_M: f64 = 0.3;

/// As a multiple of the distance to the nearer adjacent return.
const REACH_SPACINGS: f64 = 4.5;

/// Returns whose spread across the line is a larger share of that along it are no line.
const MAX_SPREAD: f64 = 0.25;

/// A return on a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LinePoint {
    pub(crate) position_m: Point2<f64>,
    /// Of the line, towards the sensor.
    pub(crate) normal: Unit<Vector2<f64>>,
    /// Variance of the direction of the normal, rad²: what the noise of the returns makes of the line.
    pub(crate) tilt_rad2: f64,
}

impl LinePoint {
    /// This line point, moved by `pose`.
    pub(crate) fn at(&self, pose: &Isometry2<f64>) -> Self {
        Self { position_m: pose * self.position_m, normal: pose.rotation * self.normal, tilt_rad2: self.tilt_rad2 }
    }
}

/// Of every n-th return (`every`), those that lie on a line of at least three, in message order.
pub(crate) fn line_points(points_m: &[Point], every: usize, out: &mut Vec<LinePoint>) {
    out.clear();
    out.extend((0..points_m.len()).step_by(every).filter_map(|at| line_point(points_m, at)));
}

fn line_point(points_m: &[Point], at: usize) -> Option<LinePoint> {
    let here = points_m[at].xy();
    let around = at.saturating_sub(NEIGHBOURS)..(at + NEIGHBOURS + 1).min(points_m.len());
    let adjacent = [at.checked_sub(1), Some(at + 1)].into_iter().flatten().filter_map(|i| points_m.get(i));
    let spacing_m2 = adjacent.map(|other| (other.xy() - here).norm_squared()).fold(f64::INFINITY, f64::min);
    let reach_m2 = (REACH_M * REACH_M).max(REACH_SPACINGS * REACH_SPACINGS * spacing_m2);
    let (mut count, mut sum, mut squares) = (0, Vector2::zeros(), Matrix2::zeros());
    for off in points_m[around].iter().map(|other| other.xy() - here) {
        if off.norm_squared() <= reach_m2 {
            (count, sum, squares) = (count + 1, sum + off, squares + off * off.transpose());
        }
    }
    if count < 3 {
        return None;
    }
    let spread: Matrix2<f64> = squares - sum * sum.transpose() / f64::from(count);
    let (across_m2, normal) = least_axis(&spread);
    let (across_m2, along_m2) = (across_m2.max(0.0), spread.trace() - across_m2);
    let is_line = along_m2 > 1e-12 && across_m2 <= MAX_SPREAD * MAX_SPREAD * along_m2;
    let towards_sensor = if normal.dot(&here.coords) > 0.0 { -normal } else { normal };
    // The slope of a line fitted to n returns: var = (Σ across² / (n - 2)) / Σ along².
    let tilt_rad2 = across_m2 / f64::from(count - 2) / along_m2;
    is_line.then_some(LinePoint { position_m: here, normal: towards_sensor, tilt_rad2 })
}

/// The lesser eigenvalue of a symmetric matrix, and its direction.
pub(crate) fn least_axis(symmetric: &Matrix2<f64>) -> (f64, Unit<Vector2<f64>>) {
    let (xx, xy, yy) = (symmetric[(0, 0)], symmetric[(0, 1)], symmetric[(1, 1)]);
    let half = 0.5 * (xx - yy);
    let greater = 0.5 * (xx + yy) + (half * half + xy * xy).sqrt();
    // Of the two rows of M - λ the longer one is across the direction of λ, the greater eigenvalue.
    let row = if half > 0.0 { Vector2::new(xy, yy - greater) } else { Vector2::new(xx - greater, xy) };
    let axis = Unit::try_new(row, f64::MIN_POSITIVE).unwrap_or(Vector2::x_axis());
    (xx + yy - greater, axis)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn normals(points_m: &[Point]) -> Vec<Vector2<f64>> {
        let mut out = Vec::new();
        line_points(points_m, 1, &mut out);
        out.iter().map(|point| point.normal.into_inner()).collect()
    }

    #[test]
    fn the_normal_of_a_wall_points_to_the_sensor() {
        for y in [2.0, -2.0] {
            let wall: Vec<_> = (0..10).map(|i| Point::new(0.2 * f64::from(i), y, 0.0)).collect();
            let normals = normals(&wall);
            assert_eq!(normals.len(), 10);
            assert!(
                normals.iter().all(|normal| (normal - Vector2::new(0.0, -y.signum())).norm() < 1e-9),
                "{normals:?}"
            );
        }
    }

    #[test]
    fn single_returns_and_scattered_ones_are_on_no_line() {
        let alone = [Point::new(1.0, 0.0, 0.0), Point::new(5.0, 0.0, 0.0)];
        assert!(normals(&alone).is_empty());
        let scattered =
            [(0.0, 0.0), (0.1, 0.1), (0.0, 0.2), (0.2, 0.0), (0.2, 0.2)].map(|(x, y)| Point::new(3.0 + x, y, 0.0));
        assert!(normals(&scattered).is_empty());
    }
}
