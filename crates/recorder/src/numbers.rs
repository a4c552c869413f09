//! The numbers of the walls beside them, and a ring around what tips the count.

use std::f64::consts::TAU;

use crosscut_explain::Explanation;
use crosscut_stage::{Frame, Point, Wall};
use nalgebra::Vector3;
use rerun::{AsComponents, LineStrips3D, Points3D, Radius, RecordingStream, RecordingStreamResult};

use crate::colors::{TOLERANCE, color};
use crate::rows::Rows;
use crate::scan::{LABEL_RISE, WIDTH_ROOM, within_view, xyz};
use crate::schema::SCAN_NUMBERS;
use crate::tracks::Classes;

/// Walls with a number at most; islands have theirs only if all walls have.
const NUMBERED: usize = 16;
/// How far behind a wall its number is written, as a share of the view's reach.
const BEHIND: f64 = 0.13;
/// The least room between a ring and what it marks, as a share of the view's reach.
const AROUND: f64 = 0.06;
/// Corners of a ring.
const CORNERS: usize = 12;
/// Coordinates are multiples of this, metres: those of few digits take less space.
const STEP_M: f64 = 1.0 / 32.0;

pub(crate) fn log_static(rec: &RecordingStream) -> RecordingStreamResult<()> {
    let ui = Radius::new_ui_points;
    let numbers = Points3D::update_fields().with_radii([ui(0.0)]).with_show_labels(true);
    let ring = LineStrips3D::update_fields().with_radii([ui(1.0)]).with_colors([color(TOLERANCE)]);
    rec.log_static(SCAN_NUMBERS.path, &[&numbers as &dyn AsComponents, &ring])
}

/// A number behind the middle return of each wall, in its colour; the ring around the wall that may be none, else around the gap
/// that is nearest to another count.
pub(crate) fn log(rows: &mut Rows, frame: &Frame, explanation: &Explanation, classes: &Classes, reach_m: f64) {
    let (walls, points_m) = (&frame.junction.walls, &frame.revolution.points_m);
    let behind = |wall: &Wall| {
        let of_wall = |(_, id): &(&Point, &Option<u32>)| **id == Some(wall.id);
        let middle_m = points_m.iter().zip(&frame.junction.wall_of_return).filter(of_wall).nth(wall.returns / 2)?.0;
        let beyond_m = middle_m + middle_m.coords.try_normalize(0.0)? * BEHIND * reach_m;
        Some(coarse(within_view(beyond_m, WIDTH_ROOM, reach_m) + reach_m * LABEL_RISE * Vector3::x()))
    };
    let is_numbered = |wall: &&Wall| !wall.island || walls.len() <= NUMBERED;
    let (at, walls): (Vec<_>, Vec<u32>) =
        walls.iter().filter(is_numbered).take(NUMBERED).filter_map(|wall| Some((behind(wall)?, wall.id))).unzip();
    let numbers = Points3D::new(at)
        .with_class_ids(walls.iter().map(|wall| classes.of_wall(Some(*wall))))
        .with_labels(walls.iter().map(u32::to_string));
    let around = match explanation.may_be_none {
        Some(wall) => frame.junction.ends_m(wall, points_m),
        None => explanation.nearest.as_ref().map(|nearest| nearest.returns.map(|i| points_m[i])),
    };
    let rings = LineStrips3D::new(around.map(|ends_m| ring(ends_m, reach_m)));
    rows.log(&SCAN_NUMBERS, &[&numbers as &dyn AsComponents, &rings]);
}

/// A circle around two points, metres.
fn ring([a, b]: [Point; 2], reach_m: f64) -> Vec<[f32; 3]> {
    let (middle, radius_m) = (nalgebra::center(&a, &b), 0.5 * (a - b).norm() + AROUND * reach_m);
    let corner = |at: usize| {
        let (sin, cos) = (TAU * at as f64 / CORNERS as f64).sin_cos();
        coarse(middle + radius_m * Vector3::new(cos, sin, 0.0))
    };
    (0..=CORNERS).map(corner).collect()
}

fn coarse(at_m: Point) -> [f32; 3] {
    xyz(&at_m.map(|along_m| (along_m / STEP_M).round() * STEP_M))
}
