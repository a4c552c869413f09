//! What was seen around a place, to tell whether it is seen again.

use crosscut_stage::Frame;
use nalgebra::Isometry2;

use crate::line_points::{LinePoint, line_points};
use crate::map::{Fit, Walls};

/// Line points farther from the sensor than this are left out, m: a pose that is off by little misplaces them.
const WITHIN_M: f64 = 12.0;

/// The walls that were seen around a place.
#[derive(Clone, Debug, Default)]
pub struct Look {
    outline: Vec<LinePoint>,
    walls: Option<Walls>,
}

impl Look {
    /// Adds the walls that a frame saw from `pose`, in the frame of the place.
    pub fn add(&mut self, frame: &Frame, pose: &Isometry2<f64>) {
        self.outline.extend(in_view(frame).map(|point| point.at(pose)));
        self.walls = None;
    }

    /// How the walls that a frame sees lie on these, if it was taken about in the direction of `pose`; its pose is then in the frame
    /// of the place. `None` where there are too few walls to tell.
    pub fn seen_again(&mut self, frame: &Frame, pose: &Isometry2<f64>) -> Option<Fit> {
        let walls = self.walls.get_or_insert_with(|| Walls::new(&self.outline));
        let view: Vec<LinePoint> = in_view(frame).collect();
        walls.fit(&Walls::new(&view), &Isometry2::rotation(pose.rotation.angle()))
    }
}

fn in_view(frame: &Frame) -> impl Iterator<Item = LinePoint> {
    let mut points = Vec::new();
    line_points(&frame.revolution.points_m, 1, &mut points);
    points.into_iter().filter(|point| point.position_m.coords.norm() < WITHIN_M)
}
