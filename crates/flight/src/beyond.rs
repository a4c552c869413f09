//! What earlier scans saw beyond the gaps of a scan.
//!
//! One scan does not show what a corner hides; scans from other places may have. Beyond a gap lies what is behind the line between
//! its ends and outside what this scan sees. The vehicle's disc is led from that line on through cells of the
//! [`Surroundings`], by shortest paths on squares of 0.2 m with eight neighbours:
//!
//! - **seen through**: it gets 3 m far through cells that were seen free;
//! - **closed**: it does not get 3 m far through all cells but walls, so that nothing unseen matters;
//! - **not told**: neither, and the gap is what the scan itself says.
//!
//! A gap at which the scan sees a wall go on is an opening if it was seen through, unless the disc gets from there to what lies
//! beyond an opening: that is the same way.

use crosscut_stage::{Junction, Known};
use nalgebra::{Isometry2, Point2, Vector2};

use crate::rays::Rays;
use crate::surroundings::{CELL_M, CellState, SIDE, Surroundings};

/// A way on is as long, as for one scan.
const LEAST_DEPTH_M: f64 = 3.0;
/// Side of a square, cells.
const SQUARE: usize = 2;
const SQUARES: usize = SIDE / SQUARE;
const SQUARE_M: f64 = SQUARE as f64 * CELL_M;

/// An opening, by this scan and those before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct KnownOpening {
    /// Its index among those of the scan; `None` where the scan sees a wall go on.
    pub(crate) index: Option<usize>,
    pub(crate) bearing_rad: f64,
    pub(crate) width_m: f64,
    /// The odds by the scan.
    pub(crate) p: Option<f64>,
    /// The stamp of the scan that saw through.
    pub(crate) seen_ns: Option<u64>,
}

/// Between two ends, clockwise first, metres in the frame of the scan; less than half a turn wide.
#[derive(Clone, Copy, Debug)]
struct Gap {
    from_m: Vector2<f64>,
    to_m: Vector2<f64>,
}

/// Through which cells the disc is led.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Through {
    SeenFree,
    /// Also through what was not seen. The squares are known as those of an opening.
    NoWall,
}

/// Leads the vehicle's disc through what was seen.
#[derive(Clone, Debug)]
pub(crate) struct Beyond {
    width_m: f64,
    /// The cells of the disc around a corner of cells.
    disc: Vec<[isize; 2]>,
    /// How many times a disc was led.
    walks: u32,
    /// Of each square: the last walk that came there, and its way from the gap, metres.
    walked: Vec<(u32, f32)>,
    /// The last walk beyond an opening that came there.
    of_opening: Vec<u32>,
    queue: Vec<u32>,
}

/// What a walk is in: a scan, what was seen around it, and its gap.
struct Scene<'a> {
    rays: &'a Rays,
    around: &'a Surroundings,
    pose: &'a Isometry2<f64>,
    gap: Gap,
}

fn cross(a: &Vector2<f64>, b: &Vector2<f64>) -> f64 {
    a.perp(b)
}

impl Gap {
    /// Whether a place lies behind the gap, or outside what the scan sees.
    fn is_beyond(&self, place_m: &Vector2<f64>, rays: &Rays) -> bool {
        if cross(&self.from_m, place_m) >= 0.0 && cross(place_m, &self.to_m) >= 0.0 {
            return cross(&(self.to_m - self.from_m), &(place_m - self.from_m)) <= 0.0;
        }
        !rays.sees(place_m)
    }

    fn is_told(&self, width_m: f64) -> bool {
        (self.to_m - self.from_m).norm() >= width_m && cross(&self.from_m, &self.to_m) > 0.0
    }
}

impl Scene<'_> {
    /// The middle of a square in the frame of the scan.
    fn middle_m(&self, x: usize, y: usize) -> Vector2<f64> {
        let middle = Vector2::new((SQUARE * x + 1) as f64, (SQUARE * y + 1) as f64);
        let place_m = self.around.corner_m() + middle * CELL_M;
        self.pose.inverse_transform_point(&Point2::from(place_m)).coords
    }

    /// The square of a place in the frame of the scan.
    fn square(&self, place_m: &Vector2<f64>) -> Option<[usize; 2]> {
        let at = ((self.pose * Point2::from(*place_m)).coords - self.around.corner_m()) / SQUARE_M;
        let is_inside = |along: f64| (0.0..SQUARES as f64).contains(&along);
        (is_inside(at.x) && is_inside(at.y)).then(|| [at.x as usize, at.y as usize])
    }
}

impl Beyond {
    pub(crate) fn new(width_m: f64) -> Self {
        let reach = (0.5 * width_m / CELL_M).ceil() as isize;
        let of_disc = |x: isize, y: isize| {
            let off_m = Vector2::new(x as f64 + 0.5, y as f64 + 0.5) * CELL_M;
            (off_m.norm() <= 0.5 * width_m).then_some([x, y])
        };
        let disc = (-reach..reach).flat_map(|y| (-reach..reach).filter_map(move |x| of_disc(x, y))).collect();
        Self { width_m, disc, walks: 0, walked: Vec::new(), of_opening: Vec::new(), queue: Vec::new() }
    }

    /// The openings of a scan, taken at a pose, with what was seen around it up to now.
    pub(crate) fn openings(
        &mut self,
        junction: &Junction,
        stamp_ns: u64,
        rays: &Rays,
        seen: Option<(&Surroundings, &Isometry2<f64>)>,
    ) -> Vec<KnownOpening> {
        let by_scan = junction.openings.iter().enumerate().map(|(index, opening)| KnownOpening {
            index: Some(index),
            bearing_rad: opening.bearing_rad,
            width_m: opening.width_m,
            p: opening.p,
            seen_ns: (opening.known == Known::Seen).then_some(stamp_ns),
        });
        let mut openings: Vec<KnownOpening> = by_scan.collect();
        let Some((around, pose)) = seen else { return openings };
        self.walked.resize(SQUARES * SQUARES, (0, 0.0));
        self.of_opening.resize(SQUARES * SQUARES, 0);
        let before = self.walks;
        let gap_of = |index: usize| {
            let [from_m, to_m] = junction.openings[index].edge_m.map(|end_m| end_m.coords.xy());
            Gap { from_m, to_m }
        };
        openings.retain_mut(|opening| {
            let Some(index) = opening.index else { return true };
            let gap = gap_of(index);
            if junction.openings[index].is_cut_by_view() || !gap.is_told(self.width_m) {
                return true;
            }
            let scene = Scene { rays, around, pose, gap };
            let is_open = self.lead(&scene, Through::NoWall, before).is_some();
            if opening.seen_ns.is_none() && is_open {
                opening.seen_ns =
                    self.lead(&scene, Through::SeenFree, u32::MAX).and_then(|square| seen_ns(around, square));
            }
            is_open || opening.seen_ns.is_some()
        });
        for pair in rays.joined() {
            let [from_m, to_m] = pair;
            let gap = Gap { from_m, to_m };
            let middle_m = 0.5 * (from_m + to_m);
            let is_in = |index: usize| {
                let of = gap_of(index);
                cross(&of.from_m, &of.to_m) <= 0.0
                    || cross(&of.from_m, &middle_m) >= 0.0 && cross(&middle_m, &of.to_m) >= 0.0
            };
            if !gap.is_told(self.width_m) || (0..junction.openings.len()).any(is_in) {
                continue;
            }
            let scene = Scene { rays, around, pose, gap };
            if let Some(square) = self.lead(&scene, Through::SeenFree, before) {
                openings.push(KnownOpening {
                    index: None,
                    bearing_rad: middle_m.y.atan2(middle_m.x),
                    width_m: (to_m - from_m).norm(),
                    p: None,
                    seen_ns: seen_ns(around, square),
                });
            }
        }
        openings.sort_by(|a, b| a.bearing_rad.total_cmp(&b.bearing_rad));
        openings
    }

    /// Leads the disc from a gap on. The square that it gets to after [`LEAST_DEPTH_M`]; `None` if it does not get as far, or to
    /// where a walk after `before` came beyond an opening.
    fn lead(&mut self, scene: &Scene<'_>, through: Through, before: u32) -> Option<usize> {
        self.walks += 1;
        let walk = self.walks;
        self.queue.clear();
        let Gap { from_m, to_m } = scene.gap;
        let steps = ((to_m - from_m).norm() / CELL_M).ceil();
        for step in 0..=steps as usize {
            let Some([x, y]) = scene.square(&from_m.lerp(&to_m, step as f64 / steps)) else {
                // What is as far off was not seen.
                return (through == Through::NoWall).then_some(0);
            };
            let square = y * SQUARES + x;
            if self.walked[square].0 != walk && self.fits(scene.around, x, y, through) {
                self.walked[square] = (walk, 0.0);
                self.queue.push(square as u32);
            }
        }
        let (mut at, mut found) = (0, None);
        while let Some(&square) = self.queue.get(at) {
            at += 1;
            let square = square as usize;
            let (_, way_m) = self.walked[square];
            match through {
                Through::NoWall => self.of_opening[square] = walk,
                Through::SeenFree if self.of_opening[square] > before => return None,
                Through::SeenFree => {}
            }
            if f64::from(way_m) >= LEAST_DEPTH_M {
                found = found.or(Some(square));
                if through == Through::SeenFree {
                    return found;
                }
                continue;
            }
            let [x, y] = [square % SQUARES, square / SQUARES];
            for [right, up] in BESIDE {
                let (Some(x), Some(y)) = (x.checked_add_signed(right), y.checked_add_signed(up)) else { continue };
                if x >= SQUARES || y >= SQUARES {
                    continue;
                }
                let (beside, step_m) = (y * SQUARES + x, SQUARE_M * ((right * right + up * up) as f64).sqrt());
                let next_m = way_m + step_m as f32;
                let (by, known_m) = self.walked[beside];
                let is_new = by != walk;
                if !is_new && known_m <= next_m + 1e-6
                    || is_new && !self.fits(scene.around, x, y, through)
                    || is_new && !scene.gap.is_beyond(&scene.middle_m(x, y), scene.rays)
                {
                    continue;
                }
                self.walked[beside] = (walk, next_m);
                self.queue.push(beside as u32);
            }
        }
        found
    }

    /// Whether the disc fits at the middle of a square.
    fn fits(&self, around: &Surroundings, x: usize, y: usize, through: Through) -> bool {
        self.disc.iter().all(|[right, up]| {
            let cell = (SQUARE * x + 1).checked_add_signed(*right).zip((SQUARE * y + 1).checked_add_signed(*up));
            match cell.map_or(CellState::Never, |(x, y)| around.state(x, y)) {
                CellState::Wall => false,
                CellState::Free => true,
                CellState::Never | CellState::Dark => through == Through::NoWall,
            }
        })
    }
}

const BESIDE: [[isize; 2]; 8] = [[1, 0], [-1, 0], [0, 1], [0, -1], [1, 1], [1, -1], [-1, 1], [-1, -1]];

fn seen_ns(around: &Surroundings, square: usize) -> Option<u64> {
    around.seen_ns(SQUARE * (square % SQUARES) + 1, SQUARE * (square / SQUARES) + 1)
}
