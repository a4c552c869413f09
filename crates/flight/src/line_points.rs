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
}

impl LinePoint {
    /// This line point, moved by `pose`.
    pub(crate) fn at(&self, pose: &Isometry2<f64>) -> Self {
        Self { position_m: pose * self.position_m, normal: pose.rotation * self.normal }
    }
}

/// The returns that lie on a line of at least three, in message order.
pub(crate) fn line_points(points_m: &[Point], out: &mut Vec<LinePoint>) {
    out.clear();
    let position_m: Vec<Point2<f64>> = points_m.iter().map(Point::xy).collect();
    out.extend((0..position_m.len()).filter_map(|at| line_point(&position_m, at)));
}

fn line_point(position_m: &[Point2<f64>], at: usize) -> Option<LinePoint> {
    let here = position_m[at];
    let around = at.saturating_sub(NEIGHBOURS)..(at + NEIGHBOURS + 1).min(position_m.len());
    let adjacent = [at.checked_sub(1), Some(at + 1)].into_iter().flatten().filter_map(|i| position_m.get(i));
    let spacing_m = adjacent.map(|other| (other - here).norm()).fold(f64::INFINITY, f64::min);
    let reach_m = REACH_M.max(REACH_SPACINGS * spacing_m);
    let near = position_m[around].iter().filter(|other| (*other - here).norm() <= reach_m);
    let count = near.clone().count();
    if count < 3 {
        return None;
    }
    let mean = near.clone().map(|point| point.coords).sum::<Vector2<f64>>() / count as f64;
    let spread: Matrix2<f64> = near.map(|point| (point.coords - mean) * (point.coords - mean).transpose()).sum();
    let axes = spread.symmetric_eigen();
    let across = axes.eigenvalues.imin();
    let is_line = axes.eigenvalues[across].max(0.0).sqrt() <= MAX_SPREAD * axes.eigenvalues[1 - across].sqrt();
    let normal = Unit::try_new(axes.eigenvectors.column(across).into_owned(), 1e-12)?;
    let towards_sensor = if normal.dot(&here.coords) > 0.0 { -normal } else { normal };
    is_line.then_some(LinePoint { position_m: here, normal: towards_sensor })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn normals(points_m: &[Point]) -> Vec<Vector2<f64>> {
        let mut out = Vec::new();
        line_points(points_m, &mut out);
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
