//! The walls that were seen on the way past a place.

use std::collections::VecDeque;
use std::sync::Arc;

use nalgebra::{Isometry2, Point2};

use super::visit::Visit;
use crate::line_points::LinePoint;
use crate::{HereKind, Way};

/// Walls are kept each time the vehicle has moved this far, for the last [`VIEWS`] of them: twice the longest look each way.
const EVERY_M: f64 = 0.7;
const VIEWS: usize = 50;

/// What lies in a mouth is looked for within this share of its width, about its middle.
const WITHIN_MOUTH: f64 = 0.7;

/// What ends within this many widths of the passage, and within the look, is a pocket in the wall.
const POCKET_WIDTHS: f64 = 1.45;

/// The walls that were seen on the last metres of the flight.
#[derive(Clone, Debug, Default)]
pub(super) struct Passed {
    views: VecDeque<WallView>,
}

/// What was seen from a place, in the frame that poses are tracked in.
#[derive(Clone, Debug)]
struct WallView {
    from_m: Point2<f64>,
    walls_m: Arc<[Point2<f64>]>,
}

impl Passed {
    pub(super) fn add(&mut self, pose: Isometry2<f64>, line_points: impl FnOnce() -> Vec<LinePoint>) {
        let from_m = Point2::from(pose.translation.vector);
        if self.views.back().is_some_and(|before| (from_m - before.from_m).norm() <= EVERY_M) {
            return;
        }
        if self.views.len() == VIEWS {
            self.views.pop_front();
        }
        let walls_m = line_points().iter().map(|point| pose * point.position_m).collect();
        self.views.push_back(WallView { from_m, walls_m });
    }

    /// The poses that follow do not go with those before.
    pub(super) fn clear(&mut self) {
        self.views.clear();
    }

    /// How far the vehicle saw into a mouth as it passed it, metres from where it was nearest; `None` if it did not pass, went
    /// in, or saw no wall there.
    fn depth_m(&self, mouth_m: Point2<f64>, width_m: f64) -> Option<f64> {
        let off_m = |at: usize| (mouth_m - self.views[at].from_m).norm();
        let nearest = (0..self.views.len()).min_by(|a, b| off_m(*a).total_cmp(&off_m(*b)))?;
        if nearest == 0 || nearest + 1 == self.views.len() || off_m(nearest) < 0.5 * width_m {
            return None;
        }
        let at_m = self.views[nearest].from_m;
        let towards = mouth_m - at_m;
        let within_rad = (0.5 * WITHIN_MOUTH * width_m / towards.norm()).atan();
        let around = self.views.range(nearest - 1..=nearest + 1).flat_map(|view| view.walls_m.iter());
        let inside = around.map(|point_m| point_m - at_m).filter(|to| to.angle(&towards) < within_rad);
        let depth_m = inside.map(|to| to.norm()).max_by(f64::total_cmp)?;
        // What is nearer than the mouth hides what lies in it.
        (depth_m > towards.norm()).then_some(depth_m)
    }

    /// Whether a junction is none: from where the vehicle passed them, of all of its ways but two the end was in view within the
    /// look.
    pub(super) fn is_a_pocket(&self, visit: &Visit, width_m: Option<f64>) -> bool {
        if visit.kind != HereKind::Junction {
            return false;
        }
        let pocket_m = width_m.map_or(visit.look_m, |width_m| visit.look_m.min(POCKET_WIDTHS * width_m));
        let ends = |(way, mouth_m): &(&Way, Point2<f64>)| {
            self.depth_m(*mouth_m, way.width_m).is_some_and(|depth_m| depth_m < pocket_m)
        };
        let pockets = visit.ways.iter().zip(visit.mouths_m()).filter(ends).count();
        pockets > 0 && visit.ways.len() - pockets < 3
    }
}
