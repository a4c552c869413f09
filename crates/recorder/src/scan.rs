//! What the sensor saw, in the body frame (metres, x forward, y left): 3D archetypes, seen from above in the layout.

use crosscut_flight::{FlightAnswer, SteadyOpening};
use crosscut_stage::{Beam, Frame, Junction, Opening, Point, Revolution, Sweep, unit};
use nalgebra::Vector3;
use rerun::{
    Arrows3D, AsComponents, LineStrip3D, LineStrips3D, Points3D, Radius, RecordingStream, RecordingStreamResult,
    Scalars,
};

use crate::colors::{GREY, GRID, OPENING, UNSURE, color, series};
use crate::polyline::simplified;
use crate::rows::Rows;
use crate::schema::{
    SCAN_BEAMS, SCAN_BEAMS_WIRE, SCAN_COUNT, SCAN_OPENINGS, SCAN_RANGES, SCAN_RETURNS, SCAN_RINGS, SCAN_SEEN,
    SCAN_SENSOR, SCAN_WALLS,
};
use crate::tensors::{f32_vector, f64_matrix, f64_vector, u8_vector};
use crate::tracks::Classes;

/// Neighbouring returns of a wall that are farther apart are not joined by a line.
const GAP_M: f64 = 2.5;
/// Largest distance between a return and the line that is drawn along its wall.
const LINE_M: f32 = 0.03;
/// Length of the arrows through the openings, as a share of the view's reach.
const ARROW: f64 = 0.18;
/// How far behind an opening its width is written, as a share of the view's reach.
const WIDTH_BEYOND: f64 = 0.22;
/// How much farther behind an opening to the side its width is written, as text is wide; a share of the view's reach.
const WIDTH_ASIDE: f64 = 0.08;
/// A width fits into the view if its middle is no farther out than these shares of the view's reach: ahead or behind,
/// and to either side.
pub(crate) const WIDTH_ROOM: [f64; 2] = [1.2, 1.08];
/// A label hangs below its point. Raised by this share of the view's reach, its middle lies at the point.
pub(crate) const LABEL_RISE: f64 = 0.08;

/// Look of the entities, and what never changes.
pub(crate) fn log_static(rec: &RecordingStream) -> RecordingStreamResult<()> {
    let ui = Radius::new_ui_points;
    rec.log_static(SCAN_RETURNS.path, &Points3D::update_fields().with_radii([ui(2.5)]))?;
    rec.log_static(SCAN_COUNT.path, &series("returns", GREY, 1.5))?;
    rec.log_static(SCAN_WALLS.path, &LineStrips3D::update_fields().with_radii([ui(1.0)]).with_show_labels(false))?;
    let arrows = Arrows3D::update_fields().with_radii([ui(2.5)]);
    let bars = LineStrips3D::update_fields().with_radii([ui(1.5)]).with_colors([color(OPENING)]);
    let widths = Points3D::update_fields().with_radii([ui(0.0)]).with_colors([color(OPENING)]).with_show_labels(true);
    rec.log_static(SCAN_OPENINGS.path, &[&arrows as &dyn AsComponents, &bars, &widths])?;
    let sensor = [[0.9f32, 0.0, 0.0], [-0.5, 0.3, 0.0], [-0.2, 0.0, 0.0], [-0.5, -0.3, 0.0], [0.9, 0.0, 0.0]];
    rec.log_static(SCAN_SENSOR.path, &LineStrips3D::new([sensor]).with_radii([ui(1.5)]).with_colors([color(GREY)]))
}

/// Returns, walls and openings of one revolution, in views that reach `reach_m`; raw ranges where there is a sweep.
pub(crate) fn log(rows: &mut Rows, frame: &Frame, classes: &Classes, reach_m: f64) {
    let (revolution, junction) = (&frame.revolution, &frame.junction);
    let points = revolution.points_m.iter().map(xyz);
    rows.log(&SCAN_RETURNS, &Points3D::new(points).with_class_ids(classes.returns.iter().copied()));
    rows.log(&SCAN_COUNT, &Scalars::single(revolution.len() as f64));
    if let Some(sweep) = revolution.beams() {
        rows.log_tensor(&SCAN_RANGES, f32_vector(sweep.ranges_m.clone(), SCAN_RANGES.dims), &[]);
        rows.log_tensor(&SCAN_SEEN, u8_vector(sweep.beams.iter().map(seen), SCAN_SEEN.dims), &[]);
    }
    log_walls(rows, revolution, junction, classes);
    let steady = FlightAnswer::of(frame).steady.as_ref().map_or(&[][..], |steady| &steady.openings);
    log_openings(rows, &junction.openings, steady, reach_m);
}

/// 2: a return; 1: nothing in range; 0: unknown.
fn seen(beam: &Beam) -> u8 {
    match beam {
        Beam::Return(_) => 2,
        Beam::NoReturn => 1,
        Beam::Unknown => 0,
    }
}

fn log_walls(rows: &mut Rows, revolution: &Revolution, junction: &Junction, classes: &Classes) {
    let strips = match revolution.beams() {
        Some(sweep) => wall_strips(&revolution.points_m, &junction.wall_of_return, sweep.full_turn),
        None => Vec::new(), // returns without beams have no order to draw a line along
    };
    let of_lines: Vec<u16> = strips.iter().map(|(wall, _)| classes.of_wall(Some(*wall))).collect();
    let lines = strips.into_iter().map(|(_, strip)| LineStrip3D::from_iter(simplified(&strip, LINE_M)));
    rows.log(&SCAN_WALLS, &LineStrips3D::new(lines).with_class_ids(of_lines));
}

/// Lines along the walls, broken at gaps: `closed` if the last return is a neighbour of the first.
fn wall_strips(points_m: &[Point], wall_of: &[Option<u32>], closed: bool) -> Vec<(u32, Vec<[f32; 3]>)> {
    let mut strips: Vec<(u32, Vec<[f32; 3]>)> = Vec::new();
    let joined = |a: usize, b: usize| wall_of[a] == wall_of[b] && (points_m[a] - points_m[b]).norm() <= GAP_M;
    for i in 0..points_m.len().min(wall_of.len()) {
        let Some(wall) = wall_of[i] else { continue };
        match strips.last_mut() {
            Some((_, strip)) if i > 0 && joined(i - 1, i) => strip.push(xyz(&points_m[i])),
            _ => strips.push((wall, vec![xyz(&points_m[i])])),
        }
    }
    if closed && points_m.len() > 1 && wall_of.len() == points_m.len() && wall_of[0].is_some() {
        let (first, last) = (0, points_m.len() - 1);
        if joined(last, first)
            && let Some((_, strip)) = strips.last_mut()
        {
            strip.push(xyz(&points_m[first]));
        }
    }
    strips.retain(|(_, strip)| strip.len() > 1);
    strips
}

/// An arrow through each opening with its width, and a bar across it; bearing and width exactly as a tensor. From the sensor an
/// arrow to each opening of the steady answer, in another colour where no scan saw through.
fn log_openings(rows: &mut Rows, openings: &[Opening], steady: &[SteadyOpening], reach_m: f64) {
    let arrow_m = |o: &Opening| ARROW * reach_m * inwards(o);
    let beyond = |o: &Opening| {
        let far_m = reach_m * (WIDTH_BEYOND + WIDTH_ASIDE * inwards(o).y.abs());
        let at = within_view(middle(o) + far_m * inwards(o), WIDTH_ROOM, reach_m);
        xyz(&(at + reach_m * LABEL_RISE * Vector3::x()))
    };
    let width = |o: &Opening| format!("{}{:.1} m", if o.is_cut_by_view() { "≥ " } else { "" }, o.width_m);
    let widths = Points3D::new(openings.iter().map(beyond)).with_labels(openings.iter().map(width));
    let of_scan = openings.iter().map(|o| (middle(o) - 0.25 * arrow_m(o), arrow_m(o), OPENING));
    let of_flight = steady.iter().map(|o| {
        let vector_m = (ARROW * reach_m * unit(o.bearing_rad)).push(0.0);
        (Point::origin(), vector_m, if o.seen_ns.is_some() { OPENING } else { UNSURE })
    });
    let (origins, (vectors, colors)): (Vec<_>, (Vec<_>, Vec<_>)) = of_scan
        .chain(of_flight)
        .map(|(origin_m, vector_m, rgba)| (xyz(&origin_m), (xyz(&vector_m.into()), color(rgba))))
        .unzip();
    let arrows = Arrows3D::from_vectors(vectors).with_origins(origins).with_colors(colors);
    let bars = LineStrips3D::new(openings.iter().map(|o| o.edge_m.map(|end| xyz(&end))));
    let exact = openings.iter().flat_map(|o| [o.bearing_rad, o.width_m]).collect();
    let table = f64_matrix(exact, [openings.len(), 2], SCAN_OPENINGS.dims);
    rows.log_tensor(&SCAN_OPENINGS, table, &[&arrows, &bars, &widths]);
}

/// The place nearest to `at` where text fits into a view that reaches `reach_m`: it fits if its middle is no farther out
/// than the shares `room` of that, ahead or behind and to either side.
pub(crate) fn within_view(at: Point, room: [f64; 2], reach_m: f64) -> Point {
    let [along_m, across_m] = room.map(|share| share * reach_m);
    Point::new(at.x.clamp(-along_m, along_m), at.y.clamp(-across_m, across_m), at.z)
}

fn middle(opening: &Opening) -> Point {
    nalgebra::center(&opening.edge_m[0], &opening.edge_m[1])
}

/// The unit vector into the branch, across the opening's edge. The edge has its clockwise end first, so its other end
/// lies to the left of a vehicle that enters.
fn inwards(opening: &Opening) -> Vector3<f64> {
    let [right, left] = opening.edge_m;
    let across = Vector3::new(left.y - right.y, right.x - left.x, 0.0);
    let ahead = Vector3::new(opening.bearing_rad.cos(), opening.bearing_rad.sin(), 0.0);
    across.try_normalize(0.0).unwrap_or(ahead)
}

/// Geometry of the beams, logged when it changes.
#[derive(Default)]
pub(crate) struct BeamGeometry {
    bearings_rad: Vec<f64>,
    wire: [f32; 4],
}

impl BeamGeometry {
    /// Logs the bearing of each beam, and `angle_min`, `angle_increment`, `range_min`, `range_max` as on the wire.
    /// Returns whether they changed.
    pub(crate) fn log(&mut self, rows: &mut Rows, sweep: &Sweep) -> bool {
        let bits = |wire: [f32; 4]| wire.map(f32::to_bits); // NaN equals itself
        if sweep.bearings_rad == self.bearings_rad && bits(sweep.wire_geometry) == bits(self.wire) {
            return false;
        }
        self.bearings_rad.clone_from(&sweep.bearings_rad);
        self.wire = sweep.wire_geometry;
        rows.log_tensor(&SCAN_BEAMS, f64_vector(self.bearings_rad.clone(), SCAN_BEAMS.dims), &[]);
        rows.log_tensor(&SCAN_BEAMS_WIRE, f32_vector(self.wire.to_vec(), SCAN_BEAMS_WIRE.dims), &[]);
        true
    }
}

/// A round number of metres that fits into `reach_m` four times at most; views reach 2 km at most.
pub(crate) fn step_m(reach_m: f64) -> f64 {
    [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0].into_iter().find(|step| reach_m / step <= 4.0).unwrap_or(500.0)
}

/// Multiples of [`step_m`] up to `reach_m`.
pub(crate) fn ticks_m(reach_m: f64) -> impl Iterator<Item = f64> {
    let step_m = step_m(reach_m);
    (1..=4).map(move |tick| f64::from(tick) * step_m).filter(move |&tick_m| tick_m <= reach_m)
}

/// Circles to read distances by, at [`ticks_m`]. The titles of the views have their spacing.
pub(crate) fn log_rings(rec: &RecordingStream, reach_m: f64) -> RecordingStreamResult<()> {
    let at = |radius_m: f64, degrees: f64| {
        let angle = degrees.to_radians();
        [(radius_m * angle.cos()) as f32, (radius_m * angle.sin()) as f32, 0.0]
    };
    let circle = |radius_m: f64| (0..=72).map(|i| at(radius_m, 5.0 * f64::from(i))).collect::<Vec<_>>();
    let rings = LineStrips3D::new(ticks_m(reach_m).map(circle))
        .with_radii([Radius::new_ui_points(0.5)])
        .with_colors([color(GRID)]);
    rec.log_static(SCAN_RINGS.path, &rings)
}

/// A point as it is drawn.
pub(crate) fn xyz(p: &Point) -> [f32; 3] {
    [p.x as f32, p.y as f32, p.z as f32]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn strips(points: &[(f64, f64)], walls: &[Option<u32>], closed: bool) -> Vec<(u32, usize)> {
        let points: Vec<Point> = points.iter().map(|&(x, y)| Point::new(x, y, 0.0)).collect();
        wall_strips(&points, walls, closed).into_iter().map(|(wall, strip)| (wall, strip.len())).collect()
    }

    #[test]
    fn a_wall_line_is_broken_at_wide_gaps() {
        let points = [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (9.0, 0.0), (10.0, 0.0)];
        assert_eq!(strips(&points, &[Some(4); 5], false), [(4, 3), (4, 2)]);
    }

    #[test]
    fn an_arrow_leads_across_the_opening_into_the_branch() {
        let inwards_of = |edge_m: [(f64, f64); 2], bearing_rad| {
            let edge_m = edge_m.map(|(x, y)| Point::new(x, y, 0.0));
            let evidence = crosscut_stage::Evidence::SeenThrough;
            inwards(&Opening {
                bearing_rad,
                width_m: 2.0,
                walls: [0, 1],
                returns: [Some(0), Some(1)],
                gaps: Vec::new(),
                evidence,
                known: crosscut_stage::Known::Judged,
                edge_m,
                p: None,
            })
        };
        assert_eq!(inwards_of([(3.0, -1.0), (3.0, 1.0)], 0.0), Vector3::x());
        let seen_past_a_corner_to_the_left = inwards_of([(6.0, 6.0), (2.0, 2.0)], 1.2);
        assert!(seen_past_a_corner_to_the_left.dot(&Vector3::new(-1.0, 1.0, 0.0)) > 1.4);
        assert_eq!(inwards_of([(2.0, 0.0); 2], 0.0), Vector3::x(), "without a width");
    }

    #[test]
    fn a_wall_line_is_broken_by_a_return_of_another_wall() {
        let points = [(0.0, 0.0), (1.0, 0.0), (1.5, 0.0), (2.0, 0.0), (3.0, 0.0)];
        let (a, b) = (Some(0), Some(1));
        assert_eq!(strips(&points, &[a, a, b, a, a], false), [(0, 2), (0, 2)]);
        assert_eq!(strips(&points, &[a, a, None, a, a], false), [(0, 2), (0, 2)]);
    }

    #[test]
    fn a_full_turn_joins_the_last_return_to_the_first() {
        let points = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
        assert_eq!(strips(&points, &[Some(0); 4], true), [(0, 5)]);
        assert_eq!(strips(&points, &[Some(0); 4], false), [(0, 4)]);
    }

    #[test]
    fn more_labels_than_returns_or_fewer_do_not_panic() {
        assert_eq!(strips(&[(0.0, 0.0), (1.0, 0.0)], &[], true), []);
        assert_eq!(strips(&[], &[Some(0)], true), []);
    }
}
