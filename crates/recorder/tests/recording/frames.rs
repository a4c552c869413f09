//! Frames as the pipeline would fill them: a vehicle driving through a 3.5 m tunnel towards a T junction.

use std::f64::consts::{PI, TAU};

use crosscut_stage::NoteCode::N101;
use crosscut_stage::{
    Affinity, Beam, Between, Cell, Dual, Evidence, Frame, Junction, Opening, Partition, Place, Point, Revolution,
    Spectrum, Step, Sweep, Wall, Way, Weights,
};
use faer::{Mat, Side};
use nalgebra::{UnitQuaternion, Vector3};

pub(crate) const BEAMS: usize = 360;
const RANGE_M: f64 = 15.0;
const HALF_WIDTH_M: f64 = 1.75;
const CROSSING_X_M: f64 = 9.0;
const SIGMA_PER_M2: f64 = 1.5;
const TOLERANCE: f64 = 1e-7;

/// The frame of revolution `seq`, 10 Hz and 5 cm from the one before.
pub(crate) fn frame(seq: u64) -> Frame {
    frame_of(seq, BEAMS)
}

/// The same with another number of beams.
pub(crate) fn frame_of(seq: u64, beams: usize) -> Frame {
    let mut frame = Frame::default();
    let walls = scan(seq, beams, &mut frame.revolution);
    fill_affinity(&frame.revolution, &mut frame.affinity);
    fill_spectrum(&frame.affinity, &mut frame.spectrum);
    fill_partition(&walls, &frame.spectrum, &mut frame.partition);
    fill_junction(seq, &walls, &mut frame.junction);
    for (i, step) in Step::ALL.into_iter().enumerate() {
        frame.timings.set_ns(step, 100_000 * (i as u64 + 1) + 10_000 * (seq % 7));
    }
    frame
}

/// A revolution in which no beam came back.
pub(crate) fn empty_frame(seq: u64) -> Frame {
    let mut frame = Frame::default();
    let mut sweep = geometry(BEAMS);
    sweep.ranges_m = vec![f32::INFINITY; BEAMS];
    sweep.beams = vec![Beam::NoReturn; BEAMS];
    frame.revolution = Revolution { seq, stamp_ns: stamp_ns(seq), sweep: Some(sweep), ..Revolution::default() };
    frame.spectrum.tolerance = TOLERANCE;
    frame.notes.add(N101, "no beam came back");
    frame
}

/// `n` returns without beams, each linked to itself alone, in sparse form: what a 3D cloud may look like.
pub(crate) fn cloud_frame(seq: u64, n: usize) -> Frame {
    let mut frame = Frame::default();
    frame.revolution.seq = seq;
    frame.revolution.stamp_ns = stamp_ns(seq);
    frame.revolution.points_m = (0..n).map(|i| Point::new(i as f64, 1.0, 0.5)).collect();
    frame.affinity.degrees = vec![1.0; n];
    let w = frame.affinity.weights.make_sparse();
    for i in 0..n {
        w.push(i as u32, 1.0);
        w.end_row();
    }
    frame
}

/// Makes the rows of a frame the directions of its beams, and its walls ways on; with a cloud above the returns.
pub(crate) fn make_ways(frame: &mut Frame) {
    let sweep = frame.revolution.sweep.as_ref().expect("a sweep");
    let cell = |(beam, bearing_rad): (&Beam, &f64)| {
        let way = if let Beam::Return(i) = beam { frame.junction.wall_of_return[*i as usize] } else { None };
        let direction = Vector3::new(bearing_rad.cos(), bearing_rad.sin(), 0.0);
        let known_m = if way.is_some() { 6.5 } else { f64::INFINITY };
        Cell { direction, range_m: known_m, reach_m: known_m, way }
    };
    let cells: Vec<Cell> = sweep.beams.iter().zip(&sweep.bearings_rad).map(cell).collect();
    let way = |number: u32| Way {
        direction: Vector3::new(0.6, 0.0, 0.8),
        slope_rad: 0.9,
        clearance_m: 2.0 + f64::from(number),
        p: 0.98,
        evidence: Evidence::SeenThrough,
        cut_by_view: number == 1,
        is_wide: false,
    };
    let ways: Vec<Way> = (0..3).map(way).collect();
    let between = vec![Between { ways: [0, 1], direction: Vector3::y(), reach_m: 3.5 }];
    let above = |point_m: &Point| Point::new(point_m.x, point_m.y, 0.5).map(|x| f64::from(x as f32));
    frame.revolution.cloud_m = frame.revolution.points_m.iter().map(above).collect();
    frame.revolution.cloud_tilt = UnitQuaternion::from_euler_angles(0.1, -0.2, 0.0);
    frame.junction.ways = Some(ways.clone());
    let tilt = UnitQuaternion::default();
    frame.affinity.dual =
        Some(Dual { cells, ways, between, tilt, view_rad: [-0.3, 0.3], room_m: 1.8, cut_m: 4.0, on_m: 4.4 });
}

/// When revolution `seq` was taken.
pub(crate) fn stamp_ns(seq: u64) -> u64 {
    1_700_000_000_000_000_000 + 100_000_000 * seq
}

fn geometry(beams: usize) -> Sweep {
    let step_rad = TAU / beams as f64;
    Sweep {
        bearings_rad: (0..beams).map(|i| -PI + step_rad * (i as f64 + 0.5)).collect(),
        step_rad,
        range_max_m: RANGE_M,
        full_turn: true,
        wire_geometry: [(-PI + 0.5 * step_rad) as f32, step_rad as f32, 0.1, RANGE_M as f32],
        ..Sweep::default()
    }
}

/// Casts the beams; returns the wall of each return: 0 right of the tunnel, 1 across it, 2 left of it.
fn scan(seq: u64, beams: usize, revolution: &mut Revolution) -> Vec<u32> {
    let x = 0.05 * seq as f64;
    let near = CROSSING_X_M - HALF_WIDTH_M - x;
    let far = CROSSING_X_M + HALF_WIDTH_M - x;
    let (h, end) = (HALF_WIDTH_M, 60.0);
    let segments = [
        (0, [-end, -h], [near, -h]),
        (0, [near, -h], [near, -end]),
        (1, [far, -end], [far, end]),
        (2, [near, end], [near, h]),
        (2, [near, h], [-end, h]),
    ];
    let mut noise = seq.wrapping_mul(2).wrapping_add(1);
    let mut sweep = geometry(beams);
    let mut walls = Vec::new();
    for &bearing in &sweep.bearings_rad {
        noise = noise.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let jitter_m = 0.02 * ((noise >> 33) as f64 / f64::from(1u32 << 30) - 1.0);
        let hits = segments.iter().filter_map(|&(wall, a, b)| Some((hit(bearing, a, b)?, wall)));
        match hits.min_by(|a, b| a.0.total_cmp(&b.0)).filter(|(range, _)| *range < RANGE_M - 0.1) {
            Some((range, wall)) => {
                let range = (range + jitter_m) as f32;
                sweep.ranges_m.push(range);
                sweep.beams.push(Beam::Return(walls.len() as u32));
                let range = f64::from(range);
                revolution.points_m.push(Point::new(range * bearing.cos(), range * bearing.sin(), 0.0));
                walls.push(wall);
            }
            None => {
                sweep.ranges_m.push(f32::INFINITY);
                sweep.beams.push(Beam::NoReturn);
            }
        }
    }
    revolution.seq = seq;
    revolution.stamp_ns = stamp_ns(seq);
    revolution.frame_id = "laser".to_owned();
    revolution.sweep = Some(sweep);
    walls
}

/// How far the beam from the origin goes until it crosses the segment.
fn hit(bearing: f64, a: [f64; 2], b: [f64; 2]) -> Option<f64> {
    let (dx, dy) = (bearing.cos(), bearing.sin());
    let (ex, ey) = (b[0] - a[0], b[1] - a[1]);
    let denominator = dx * ey - dy * ex;
    let range = (a[0] * ey - a[1] * ex) / denominator;
    let along = (a[0] * dy - a[1] * dx) / denominator;
    (denominator.abs() > 1e-12 && range > 0.0 && (0.0..=1.0).contains(&along)).then_some(range)
}

fn fill_affinity(revolution: &Revolution, out: &mut Affinity) {
    let (points, n) = (&revolution.points_m, revolution.len());
    let w = Mat::from_fn(n, n, |i, j| (-SIGMA_PER_M2 * (points[i] - points[j]).norm_squared()).exp());
    out.degrees = (0..n).map(|i| (0..n).map(|j| w[(i, j)]).sum()).collect();
    out.weights = Weights::Dense(w);
}

/// L = I - D^-1/2 W D^-1/2.
pub(crate) fn laplacian(affinity: &Affinity) -> Mat<f64> {
    let n = affinity.weights.n();
    let mut l = Mat::from_fn(n, n, |i, j| f64::from(u8::from(i == j)));
    affinity.weights.for_each(|i, j, w| l[(i, j)] -= w / (affinity.degrees[i] * affinity.degrees[j]).sqrt());
    l
}

/// W with both triangles.
pub(crate) fn dense(affinity: &Affinity) -> Mat<f64> {
    let mut w = Mat::zeros(affinity.weights.n(), affinity.weights.n());
    affinity.weights.for_each(|i, j, value| w[(i, j)] = value);
    w
}

/// Leaves the weak links out.
pub(crate) fn make_sparse(affinity: &mut Affinity) {
    let full = dense(affinity);
    let sparse = affinity.weights.make_sparse();
    for i in 0..full.nrows() {
        for j in (0..full.ncols()).filter(|&j| full[(i, j)] > 1e-6) {
            sparse.push(j as u32, full[(i, j)]);
        }
        sparse.end_row();
    }
}

fn fill_spectrum(affinity: &Affinity, out: &mut Spectrum) {
    let n = affinity.weights.n();
    let eigen = laplacian(affinity).self_adjoint_eigen(Side::Lower).expect("a small symmetric matrix");
    let all: Vec<f64> = (0..n).map(|i| eigen.S()[i]).collect();
    out.tolerance = TOLERANCE;
    out.k = all.iter().filter(|&&lambda| lambda < TOLERANCE).count();
    out.margin_decades = Spectrum::tolerance_margin_decades(&all, n, out.k, TOLERANCE);
    out.u = Mat::from_fn(n, out.k, |i, j| eigen.U()[(i, j)]);
    out.eigenvalues = all.into_iter().take(16).collect();
}

fn fill_partition(walls: &[u32], spectrum: &Spectrum, out: &mut Partition) {
    out.labels = walls.iter().copied().map(Some).collect();
    out.clusters = walls.iter().max().map_or(0, |&last| last as usize + 1);
    let rows = |wall: usize| walls.iter().enumerate().filter(move |(_, w)| **w as usize == wall).map(|(i, _)| i);
    out.centroids = Mat::from_fn(out.clusters, spectrum.u.ncols(), |c, j| {
        rows(c).map(|i| spectrum.u[(i, j)]).sum::<f64>() / rows(c).count().max(1) as f64
    })
    .into();
}

fn fill_junction(seq: u64, walls: &[u32], out: &mut Junction) {
    let x = 0.05 * seq as f64;
    let near = CROSSING_X_M - HALF_WIDTH_M - x;
    let far = CROSSING_X_M + HALF_WIDTH_M - x;
    let h = HALF_WIDTH_M;
    let opening = |bearing_rad, walls, a: [f64; 2], b: [f64; 2]| Opening {
        bearing_rad,
        width_m: 2.0 * h,
        walls,
        returns: [Some(0), Some(1)],
        gaps: Vec::new(),
        evidence: Evidence::NoReturn,
        known: crosscut_stage::Known::Judged,
        edge_m: [Point::new(a[0], a[1], 0.0), Point::new(b[0], b[1], 0.0)],
        p: None,
    };
    let side = f64::atan2(8.0, near + h);
    out.junctions = 3;
    out.place = Place::Tee;
    out.confidence = Some(0.97);
    out.wall_of_return = walls.iter().copied().map(Some).collect();
    out.openings = vec![
        opening(-side, [0, 1], [near, -h], [far, -h]),
        opening(side, [1, 2], [far, h], [near, h]),
        opening(PI, [2, 0], [-8.0, h], [-8.0, -h]),
    ];
    out.walls = (0..3)
        .map(|id| Wall {
            id,
            returns: walls.iter().filter(|w| **w == id).count(),
            bearing_rad: [0.0, 1.0],
            island: false,
        })
        .collect();
}
