//! Whether two outlines are of one place: point to line, from several starts.

use nalgebra::{Isometry2, Matrix3, Vector2, Vector3};

use crate::line_points::LinePoint;
use crate::local_map::LocalMap;

use super::visit::placed;

/// At most this many line points are matched; more add time and no certainty.
const MOST_POINTS: usize = 160;

/// A line point lies on a wall that is no farther than this.
const ON_WALL_M: f64 = 0.12;

/// ρ of Geman and McClure turns from a square to a constant about here.
const KERNEL_M: f64 = 0.3;

const ITERATIONS: usize = 15;

/// The anchors of two visits of one place lie within this of each other, along each axis; starts are a step apart.
const APART_M: f64 = 3.0;
const START_STEP_M: f64 = 1.0;

/// How well one outline lies on another.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fit {
    /// The pose of the one in the frame of the other.
    pub(crate) pose: Isometry2<f64>,
    /// Share of its line points that lie on a wall of the other, and the other way round; the lesser of the two.
    pub(crate) share: f64,
}

/// The walls of a place, around its anchor.
#[derive(Clone, Debug)]
pub(crate) struct Walls {
    map: LocalMap,
    points: Vec<LinePoint>,
    reach_m: f64,
}

impl Walls {
    pub(crate) fn new(outline: &[LinePoint]) -> Self {
        let mut map = LocalMap::default();
        outline.iter().for_each(|point| map.insert(*point));
        let every = outline.len().div_ceil(MOST_POINTS).max(1);
        let points: Vec<LinePoint> = outline.iter().step_by(every).copied().collect();
        let reach_m = points.iter().map(|point| point.position_m.coords.norm()).fold(0.0, f64::max);
        Self { map, points, reach_m }
    }

    /// The best fit of `other` on these walls, turned by about `yaw_rad`.
    pub(crate) fn fit(&self, other: &Self, yaw_rad: f64) -> Option<Fit> {
        let steps = (APART_M / START_STEP_M) as i32;
        let offsets = (-steps..=steps).flat_map(|x| (-steps..=steps).map(move |y| (x, y)));
        let starts = offsets.map(|(x, y)| {
            let offset_m = Vector2::new(f64::from(x), f64::from(y)) * START_STEP_M;
            Isometry2::new(offset_m, yaw_rad)
        });
        let mut starts: Vec<_> = starts.map(|start| (self.share_on(other, &start, KERNEL_M), start)).collect();
        starts.sort_by(|a, b| b.0.total_cmp(&a.0));
        let fits = starts.iter().take(4).map(|(_, start)| {
            let pose = self.align(other, *start);
            let shares = [self.share_on(other, &pose, ON_WALL_M), other.share_on(self, &pose.inverse(), ON_WALL_M)];
            Fit { pose, share: shares[0].min(shares[1]) }
        });
        let is_near = |fit: &Fit| fit.pose.translation.vector.amax() <= APART_M + START_STEP_M;
        fits.filter(is_near).max_by(|a, b| a.share.total_cmp(&b.share))
    }

    /// Share of the line points of `other` at `pose` that lie on these walls, of those that are near enough to.
    fn share_on(&self, other: &Self, pose: &Isometry2<f64>, within_m: f64) -> f64 {
        let (mut on, mut all) = (0, 0);
        for point in other.points.iter().map(|point| placed(point, pose)) {
            if point.position_m.coords.norm() > 0.8 * self.reach_m {
                continue;
            }
            all += 1;
            let is_on = |wall: &LinePoint| wall.normal.dot(&(point.position_m - wall.position_m)).abs() < within_m;
            on += usize::from(self.map.nearest(&point).is_some_and(is_on));
        }
        if all < 10 { 0.0 } else { f64::from(on as u32) / f64::from(all) }
    }

    /// The pose near `start` where the line points of `other` lie on these walls, point to line.
    fn align(&self, other: &Self, start: Isometry2<f64>) -> Isometry2<f64> {
        let mut pose = start;
        for _ in 0..ITERATIONS {
            let (mut information, mut gradient) = (Matrix3::identity() * 1e-3, Vector3::zeros());
            for point in &other.points {
                let at = placed(point, &pose);
                let Some(wall) = self.map.nearest(&at) else { continue };
                let distance_m = wall.normal.dot(&(at.position_m - wall.position_m));
                let arm_m = at.position_m.coords - pose.translation.vector;
                let by_yaw = wall.normal.dot(&Vector2::new(-arm_m.y, arm_m.x));
                let by_pose = Vector3::new(wall.normal.x, wall.normal.y, by_yaw);
                let kernel = KERNEL_M * KERNEL_M / (KERNEL_M * KERNEL_M + distance_m * distance_m);
                information += by_pose * by_pose.transpose() * (kernel * kernel);
                gradient += by_pose * (kernel * kernel * distance_m);
            }
            let Some(factor) = information.cholesky() else { break };
            let step = factor.solve(&-gradient);
            pose = Isometry2::new(pose.translation.vector + step.xy(), pose.rotation.angle() + step.z);
            if step.amax() < 1e-3 {
                break;
            }
        }
        pose
    }
}
