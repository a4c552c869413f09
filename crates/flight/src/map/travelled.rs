//! The way of a flight so far, and what was passed since the last node.

use std::collections::VecDeque;

use nalgebra::{Isometry2, Point2};

use super::visit::Visit;

/// Places along a passage are this far apart.
const VIA_M: f64 = 2.0;

/// Steps shorter than this add nothing to the way: poses of a standing vehicle tremble.
const STEP_M: f64 = 0.3;

/// This many steps are remembered; the oldest shows where the vehicle came from.
const TRAIL: usize = 10;

/// The way so far.
#[derive(Clone, Debug, Default)]
pub(super) struct Travelled {
    from: Option<Isometry2<f64>>,
    pub(super) way_m: f64,
    /// Widths since the last node, and their number.
    widths_m: [f64; 2],
    /// Places since the last node, as they were tracked, [`VIA_M`] apart, with the way up to there.
    via: Vec<(f64, Point2<f64>)>,
    /// The last places, [`STEP_M`] and more apart.
    trail_m: VecDeque<Point2<f64>>,
}

impl Travelled {
    pub(super) fn add(&mut self, pose: Isometry2<f64>) {
        let step_m = |from: Isometry2<f64>| (pose.translation.vector - from.translation.vector).norm();
        match self.from.map(step_m) {
            Some(step_m) if step_m < STEP_M => {}
            step_m => {
                self.way_m += step_m.unwrap_or(0.0);
                self.from = Some(pose);
                let place_m = Point2::from(pose.translation.vector);
                if self.trail_m.len() == TRAIL {
                    self.trail_m.pop_front();
                }
                self.trail_m.push_back(place_m);
                if self.via.last().is_none_or(|(_, last_m)| (place_m - last_m).norm() > VIA_M) {
                    self.via.push((self.way_m, place_m));
                }
            }
        }
    }

    /// The poses that follow do not go with those before.
    pub(super) fn begin_again(&mut self) {
        *self = Self { way_m: self.way_m, ..Self::default() };
    }

    pub(super) fn add_width(&mut self, width_m: f64) {
        self.widths_m = [self.widths_m[0] + width_m, self.widths_m[1] + 1.0];
    }

    /// Mean width since the last node.
    pub(super) fn width_m(&self) -> Option<f64> {
        let [sum_m, count] = self.widths_m;
        (count > 0.0).then(|| sum_m / count)
    }

    /// How far from a visit's anchor the way since the last visit begins.
    pub(super) fn began_m(&self, visit: &Visit) -> f64 {
        self.via.first().map_or(0.0, |(_, place_m)| (visit.anchor.inverse() * place_m).coords.norm())
    }

    /// Places between two visits in a row, as they were tracked.
    pub(super) fn between<'a>(&'a self, from: &'a Visit, to: &'a Visit) -> impl Iterator<Item = &'a Point2<f64>> {
        let between = self.via.iter().filter(move |(way_m, _)| (from.left_at_m..to.reached_at_m).contains(way_m));
        between.map(|(_, place_m)| place_m)
    }

    /// A visit has ended: what was passed up to there is no more of the way since.
    pub(super) fn begin_at(&mut self, visit: &Visit) {
        self.widths_m = [0.0; 2];
        self.via.retain(|(way_m, _)| *way_m >= visit.left_at_m);
    }

    /// A place a few metres back.
    pub(super) fn came_from(&self) -> Option<Point2<f64>> {
        self.trail_m.front().copied()
    }
}
