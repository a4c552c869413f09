//! The way of the flight and the walls along it, as they are drawn on a map.

use std::collections::BTreeSet;

use crosscut_stage::{Frame, Point, Unsure};
use nalgebra::{Isometry2, Point2};

use super::{Anchored, Mapper};
use crate::FlightAnswer;

/// Points of the path are this far apart.
const PATH_M: f64 = 0.5;
/// Walls are kept as the points that lie in other squares of this side than those before.
const CELL_M: f64 = 0.2;
/// Walls are added each time the vehicle has moved this far.
const WALLS_EVERY_M: f64 = 0.7;
/// Returns farther than this add little, and are misplaced where the heading of the pose is uncertain.
const WALLS_WITHIN_M: f64 = 12.0;

/// Where the vehicle was, and the walls that it saw.
#[derive(Clone, Debug, Default)]
pub struct MapDrawing {
    path: Vec<Anchored>,
    /// Where each stretch of the path begins, and its number.
    stretches: Vec<(usize, u32)>,
    unsure: Unsure,
    unsure_at: Vec<usize>,
    way_m: f64,
    walls: Vec<Anchored>,
    cells: BTreeSet<[i64; 2]>,
    walls_from: Option<Point2<f64>>,
}

impl MapDrawing {
    /// Takes the next frame, after `mapper` took it. A frame without a pose is passed over.
    pub fn add(&mut self, frame: &Frame, mapper: &Mapper) {
        let is_unsure = self.unsure.after(frame.junction.confidence);
        let FlightAnswer { pose: Some(pose), doubt, .. } = FlightAnswer::of(frame) else { return };
        let stretch = doubt.map_or(0, |doubt| doubt.stretch);
        let is_new_stretch = self.stretches.last().is_none_or(|(_, last)| *last != stretch);
        if is_new_stretch {
            self.stretches.push((self.path.len(), stretch));
        }
        let here = mapper.anchored(*pose);
        let placed_m = |anchored: &Anchored| Point2::from(mapper.placed(anchored).translation.vector);
        let at_m = placed_m(&here);
        let last_here = self.path.last().filter(|_| !is_new_stretch);
        let since_last_m = last_here.map(|last| (placed_m(last) - at_m).norm());
        if since_last_m.is_none_or(|since_last_m| since_last_m > PATH_M) {
            self.path.push(here);
            self.way_m += since_last_m.unwrap_or(0.0);
        }
        let last = self.path.len() - 1;
        if is_unsure && self.unsure_at.last() != Some(&last) {
            self.unsure_at.push(last);
        }
        if self.walls_from.is_some_and(|from| (from - at_m).norm() <= WALLS_EVERY_M) {
            return;
        }
        self.walls_from = Some(at_m);
        let near = frame.revolution.points_m.iter().map(Point::xy);
        for point_m in near.filter(|point_m| point_m.coords.norm() < WALLS_WITHIN_M) {
            let wall = Anchored { visit: here.visit, pose: here.pose * Isometry2::from(point_m.coords) };
            let at_m = placed_m(&wall);
            if self.cells.insert([at_m.x, at_m.y].map(|along_m| (along_m / CELL_M).floor() as i64)) {
                self.walls.push(wall);
            }
        }
    }

    /// Places of the vehicle, half a metre apart.
    pub fn path(&self) -> &[Anchored] {
        &self.path
    }

    /// The path in its stretches: how one lies to the one before was not seen.
    pub fn stretches(&self) -> impl Iterator<Item = &[Anchored]> {
        let ends = self.stretches.iter().skip(1).map(|(begin, _)| *begin).chain([self.path.len()]);
        self.stretches.iter().zip(ends).map(|((begin, _), end)| &self.path[*begin..end])
    }

    /// Which places of the path the vehicle left with an answer that was unsure, ascending.
    pub fn unsure_at(&self) -> &[usize] {
        &self.unsure_at
    }

    /// Length of the path, metres.
    pub fn way_m(&self) -> f64 {
        self.way_m
    }

    /// Points of the walls, in the order in which they were seen.
    pub fn walls(&self) -> &[Anchored] {
        &self.walls
    }
}
