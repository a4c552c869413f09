//! What was seen around a place, to tell whether it is seen again.

use std::sync::Arc;

use crosscut_stage::Frame;
use nalgebra::Isometry2;

use crate::line_points::{LinePoint, line_points};
use crate::map::Walls;

/// Line points farther from the sensor than this are left out, m: a pose that is off by little misplaces them.
const WITHIN_M: f64 = 12.0;

/// The walls that were seen around a place.
#[derive(Clone, Debug, Default)]
pub struct Look {
    outline: Vec<LinePoint>,
    walls: Option<Arc<Walls>>,
}

/// How the walls in view lie on those of a place.
#[derive(Clone, Copy, Debug)]
pub struct SeenAgain {
    /// Where the vehicle is, in the frame of the place.
    pub pose: Isometry2<f64>,
    /// Share of the walls in view that lie on those of the place, and the other way round; the lesser of the two.
    pub share: f64,
}

impl Look {
    /// Adds the walls that a frame saw from `pose`, in the frame of the place.
    pub fn add(&mut self, frame: &Frame, pose: &Isometry2<f64>) {
        self.outline.extend(in_view(frame).map(|point| point.at(pose)));
        self.walls = None;
    }

    /// Whether the frame, taken from about `pose` by what is known, sees these walls; `None` where there are too few to tell.
    pub fn seen_again(&mut self, frame: &Frame, pose: &Isometry2<f64>) -> Option<SeenAgain> {
        let walls = self.walls.get_or_insert_with(|| Arc::new(Walls::new(&self.outline)));
        let view: Vec<LinePoint> = in_view(frame).collect();
        let fit = walls.fit(&Walls::new(&view), &Isometry2::rotation(pose.rotation.angle()))?;
        Some(SeenAgain { pose: fit.pose, share: fit.share })
    }
}

fn in_view(frame: &Frame) -> impl Iterator<Item = LinePoint> {
    let mut points = Vec::new();
    line_points(&frame.revolution.points_m, 1, &mut points);
    points.into_iter().filter(|point| point.position_m.coords.norm() < WITHIN_M)
}
