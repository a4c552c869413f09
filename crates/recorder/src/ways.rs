//! A cloud and its ways on: the points in space with an arrow along each way, and the sphere of directions unrolled.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use crosscut_stage::{Cell, Dual, Frame, Point, Way};
use nalgebra::{UnitQuaternion, Vector3};
use rerun::components::Colormap;
use rerun::{
    Arrows3D, AsComponents, EncodedDepthImage, LineStrips2D, Points2D, Points3D, Radius, RecordingStream,
    RecordingStreamResult,
};

use crate::colors::{GRID, LABEL, NAMED, color};
use crate::matrices::look;
use crate::png::{Encoder, Picture};
use crate::rows::Rows;
use crate::scan::xyz;
use crate::schema::{SCAN_CLOUD, SCAN_SPHERE, SCAN_SPHERE_AXES, SCAN_SPHERE_MARKS, SCAN_WAYS};
use crate::tensors::{f32_matrix, f64_matrix};
use crate::tracks::Classes;
use crate::words::words;

/// Length of the arrows, in distances at which directions are cut.
const ARROW: f64 = 1.5;
/// A pixel of the sphere unrolled is a degree.
const SIZE: [usize; 2] = [360, 180];
/// Levels of the picture: of what is near, how many there are up to what is far, where nothing came back, and of stripes.
const DARKEST: u8 = 3;
const GREYS: f64 = 10.0;
const WHITE: u8 = 16;
const STRIPES: [u8; 2] = [0, 7];
/// What is seen this many times as far as directions are cut is as bright as what is farther.
const BRIGHTEST: f64 = 4.0;
/// Pixels of a stripe where the sensor does not look.
const STRIPE: usize = 4;

/// Draws clouds and ways, with buffers that are reused from one revolution to the next.
#[derive(Default)]
pub(crate) struct Unrolled {
    picture: Picture,
    encoder: Encoder,
}

/// Look of the entities, and the axes of the sphere unrolled.
pub(crate) fn log_static(rec: &RecordingStream) -> RecordingStreamResult<()> {
    let ui = Radius::new_ui_points;
    rec.log_static(SCAN_CLOUD.path, &Points3D::update_fields().with_radii([ui(0.75)]))?;
    let tips = Points3D::update_fields().with_radii([ui(0.0)]).with_show_labels(true);
    let arrows = Arrows3D::update_fields().with_radii([ui(4.0)]).with_show_labels(false);
    rec.log_static(SCAN_WAYS.path, &[&arrows as &dyn AsComponents, &tips])?;
    let bars = LineStrips2D::update_fields().with_show_labels(false);
    rec.log_static(SCAN_SPHERE.path, &[&look(Colormap::Grayscale) as &dyn AsComponents, &bars])?;
    let marks = Points2D::update_fields().with_radii([ui(4.0)]).with_show_labels(true);
    rec.log_static(SCAN_SPHERE_MARKS.path, &marks)?;
    let [right, low] = SIZE.map(|pixels| pixels as f32);
    let level = LineStrips2D::new([[[0.0, 0.5 * low], [right, 0.5 * low]]]).with_colors([color(GRID)]);
    let bearings = ["180°", "+90° left", "0° ahead", "-90° right", "180°"];
    let elevations = ["90° up", "level", "90° down"];
    let below = (0..).zip(bearings).map(|(at, name)| ([90.0 * at as f32, low + 2.0], name));
    let beside = (0..).zip(elevations).map(|(at, name)| ([-28.0, 88.0 * at as f32 - 4.0], name));
    let names = words(below.chain(beside));
    rec.log_static(SCAN_SPHERE_AXES.path, &[&level.with_radii([ui(0.5)]) as &dyn AsComponents, &names])
}

impl Unrolled {
    /// The ways of one revolution, and the cloud that they are of: nothing where none are counted, no cloud in a flight without any
    /// (`has_clouds`).
    pub(crate) fn log(&mut self, rows: &mut Rows, frame: &Frame, classes: &Classes, has_clouds: bool) {
        let (Some(dual), Some(ways)) = (&frame.affinity.dual, &frame.junction.ways) else { return };
        log_ways(rows, dual, ways, classes);
        let cloud_m = &frame.revolution.cloud_m;
        if has_clouds || !cloud_m.is_empty() {
            let (sphere, number_of) = (Rings::of(dual), numbers(dual, ways));
            let way = |point_m: &Point| sphere.cell(&point_m.coords).and_then(&number_of);
            let points = Points3D::new(cloud_m.iter().map(xyz));
            rows.log(&SCAN_CLOUD, &points.with_class_ids(cloud_m.iter().map(|point_m| classes.of_way(way(point_m)))));
            self.log_sphere(rows, frame, dual, ways, classes);
        }
    }

    /// The sphere as a picture, bearing by elevation: the brighter the farther what is seen there, and stripes where the sensor does
    /// not look. Over it the cells of ways in their colours, their names, and what parts two ways.
    fn log_sphere(&mut self, rows: &mut Rows, frame: &Frame, dual: &Dual, ways: &[Way], classes: &Classes) {
        let ([width, height], sphere, number_of) = (SIZE, Rings::of(dual), numbers(dual, ways));
        let is_known = !frame.revolution.cloud_m.is_empty();
        self.picture.clear(width, height);
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            let towards = unit(PI - (x as f64 + 0.5).to_radians(), FRAC_PI_2 - (y as f64 + 0.5).to_radians());
            let level =
                match sphere.cell(&towards).map(|cell| cell.range_m).filter(|range_m| is_known && !range_m.is_nan()) {
                    Some(range_m) if range_m.is_infinite() => WHITE,
                    Some(range_m) => DARKEST + (GREYS * (range_m / (BRIGHTEST * dual.cut_m)).min(1.0).sqrt()) as u8,
                    None => STRIPES[(x + y) / STRIPE % 2],
                };
            self.picture.set(y, x, 1, level);
        }
        let picture = EncodedDepthImage::new(self.encoder.encode(&self.picture));
        let (bars, of_bars): (Vec<_>, Vec<_>) = sphere.bars(&number_of).into_iter().unzip();
        let bars = LineStrips2D::new(bars)
            .with_class_ids(of_bars.into_iter().map(|way| classes.of_way(Some(way))))
            .with_radii([Radius::new_scene_units(90.0 / sphere.rings.len().max(1) as f32)]);
        let values = dual.cells.iter().flat_map(|cell| {
            let ([x, y, z], way): ([f64; 3], _) =
                ((dual.tilt * cell.direction).into(), number_of(cell).map_or(-1.0, f64::from));
            [x, y, z, cell.range_m, cell.reach_m, way].map(|value| value as f32)
        });
        let table = f32_matrix(values.collect(), [dual.cells.len(), 6], SCAN_SPHERE.dims);
        rows.log_tensor(&SCAN_SPHERE, table, &[&picture, &bars]);
        let named = (0..).zip(ways).map(|(number, way)| (place(&way.direction), (label(number, way), color(LABEL))));
        let parted = dual.between.iter().map(|of| {
            let words = format!("{:.1} of {:.1} m", of.reach_m, dual.cut_m);
            (place(&of.direction), (words, color(NAMED)))
        });
        let (at, (labels, colors)): (Vec<_>, (Vec<_>, Vec<_>)) = named.chain(parted).unzip();
        rows.log(&SCAN_SPHERE_MARKS, &Points2D::new(at).with_labels(labels).with_colors(colors));
    }
}

/// The number of the way that a cell is of.
fn numbers(dual: &Dual, ways: &[Way]) -> impl Fn(&Cell) -> Option<u32> {
    let numbers = dual.numbers_in(ways);
    move |cell| numbers.get(cell.way? as usize).copied().flatten()
}

/// An arrow along each way, with its number, kind and clearance at the tip; what is known of it as a tensor.
fn log_ways(rows: &mut Rows, dual: &Dual, ways: &[Way], classes: &Classes) {
    let tips = ways.iter().map(|way| xyz(&(way.direction * (ARROW * dual.cut_m)).into()));
    let of_ways = || (0..ways.len() as u32).map(|way| classes.of_way(Some(way)));
    let arrows = Arrows3D::from_vectors(tips.clone()).with_class_ids(of_ways());
    let names = Points3D::new(tips)
        .with_class_ids(of_ways())
        .with_labels((0..).zip(ways).map(|(number, way)| label(number, way)));
    let exact = ways.iter().flat_map(|way| {
        let ([x, y, z], cut): ([f64; 3], _) = (way.direction.into(), f64::from(u8::from(way.cut_by_view)));
        [x, y, z, way.clearance_m, way.p, cut]
    });
    let table = f64_matrix(exact.collect(), [ways.len(), 6], SCAN_WAYS.dims);
    rows.log_tensor(&SCAN_WAYS, table, &[&arrows, &names]);
}

/// "2: shaft up, 2.6 m".
fn label(number: u32, way: &Way) -> String {
    format!("{number}: {}, {:.1} m", way.kind().to_string().replace('_', " "), way.clearance_m)
}

/// Where a direction lies on the sphere unrolled.
fn place(towards: &Vector3<f64>) -> [f32; 2] {
    let [bearing_rad, elevation_rad] = bearing_elevation_rad(towards);
    [PI - bearing_rad, FRAC_PI_2 - elevation_rad].map(|rad| rad.to_degrees() as f32)
}

fn bearing_elevation_rad(towards: &Vector3<f64>) -> [f64; 2] {
    [towards.y.atan2(towards.x), towards.z.atan2(towards.x.hypot(towards.y))]
}

fn unit(bearing_rad: f64, elevation_rad: f64) -> Vector3<f64> {
    let ((y, x), (z, level)) = (bearing_rad.sin_cos(), elevation_rad.sin_cos());
    Vector3::new(level * x, level * y, z)
}

/// The cells of a sphere by ring about the axis of the lidar, from the lowest up.
struct Rings<'a> {
    rings: Vec<&'a [Cell]>,
    /// [`Dual::tilt`].
    tilt: UnitQuaternion<f64>,
}

impl<'a> Rings<'a> {
    fn of(dual: &'a Dual) -> Self {
        Self { rings: dual.cells.chunk_by(|a, b| a.direction.z == b.direction.z).collect(), tilt: dual.tilt }
    }

    /// The cell in which a direction lies.
    fn cell(&self, towards: &Vector3<f64>) -> Option<&'a Cell> {
        let [bearing_rad, elevation_rad] = bearing_elevation_rad(&self.tilt.inverse_transform_vector(towards));
        let at = |share: f64, of: usize| ((share * of as f64) as usize).min(of.saturating_sub(1));
        let ring = self.rings.get(at(elevation_rad / PI + 0.5, self.rings.len()))?;
        ring.get(at(bearing_rad / TAU + 0.5, ring.len()))
    }

    /// A bar over each row of cells of one way, with the way; two where the picture's edge parts them.
    fn bars(&self, number_of: &dyn Fn(&Cell) -> Option<u32>) -> Vec<(Vec<[f32; 2]>, u32)> {
        let mut bars = Vec::new();
        for (ring, at) in self.rings.iter().zip(0..) {
            let elevation_rad = PI * ((f64::from(at) + 0.5) / self.rings.len() as f64 - 0.5);
            let end = |cell: usize| unit(TAU * (cell as f64 / ring.len() as f64 - 0.5), elevation_rad);
            let mut from = 0;
            for run in ring.chunk_by(|a, b| number_of(a) == number_of(b)) {
                // Straight where the lidar is level.
                let step = if self.tilt == UnitQuaternion::default() { run.len() } else { 1 };
                let ends: Vec<[f32; 2]> =
                    (from..=from + run.len()).step_by(step).map(|cell| place(&(self.tilt * end(cell)))).collect();
                let parts = if step == 1 {
                    ends.chunk_by(|a, b| (a[0] - b[0]).abs() < 180.0).collect()
                } else {
                    vec![&ends[..]]
                };
                if let Some(way) = number_of(&run[0]) {
                    bars.extend(parts.into_iter().map(|part| (part.to_vec(), way)));
                }
                from += run.len();
            }
        }
        bars
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_of_a_tilted_lidar_are_found_and_drawn_where_they_lie() {
        let tilt = UnitQuaternion::from_euler_angles(0.3, -0.2, 0.0);
        let ring =
            |elevation_rad: f64| (0..8).map(move |at| unit(TAU * ((f64::from(at) + 0.5) / 8.0 - 0.5), elevation_rad));
        let directions = [-0.3, 0.0, 0.3].into_iter().flat_map(|share| ring(PI * share / 0.9));
        let cells: Vec<Cell> = (0..)
            .zip(directions)
            .map(|(at, direction)| Cell { direction, range_m: f64::from(at), reach_m: 1.0, way: Some(0) })
            .collect();
        let dual = Dual { cells, tilt, ..Dual::default() };
        let rings = Rings::of(&dual);
        assert_eq!(rings.rings.len(), 3);
        for cell in &dual.cells {
            assert_eq!(rings.cell(&(tilt * cell.direction)), Some(cell));
        }
        for (bar, _) in rings.bars(&|cell| cell.way) {
            assert!(
                bar.windows(2).all(|ends| (ends[0][0] - ends[1][0]).abs() < 180.0),
                "no bar runs across the picture: {bar:?}"
            );
        }
    }
}
