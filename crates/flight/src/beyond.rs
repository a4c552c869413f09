//! What earlier scans saw beyond the gaps of a scan.
//!
//! One scan does not show what a corner hides; scans from other places may have. Beyond a gap lies what is behind the line between
//! its ends and outside what this scan sees. The vehicle's disc is led from that line on through cells of the
//! [`Surroundings`], on squares of 0.2 m:
//!
//! - **seen through**: it gets 3 m away through cells that were seen free;
//! - **closed**: it does not get 3 m away through all cells but walls, so that nothing unseen matters;
//! - **not told**: neither, and the gap is what the scan itself says.
//!
//! A gap at which the scan sees a wall go on is an opening if it was seen through, unless the disc gets from there to what lies
//! beyond an opening: that is the same way.

use crosscut_stage::{DEPTH_M, Junction, Known};
use nalgebra::{Isometry2, Point2, Vector2};

use crate::rays::Rays;
use crate::surroundings::{CELL_M, CellState, Disc, SIDE, Surroundings};

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
    /// Also through what was not seen.
    NoWall,
}

/// Leads the vehicle's disc through what was seen.
#[derive(Clone, Debug)]
pub(crate) struct Beyond {
    width_m: f64,
    disc: Disc,
    /// How many times a disc was led.
    walks: u32,
    /// Of each square: the last walk that came there.
    came: Vec<u32>,
    /// Of each square: the last scan beyond whose openings a walk came there, by its first walk.
    of_opening: Vec<u32>,
    /// Where a walk may go on: squares, and how far they are from the gap, metres.
    open: Vec<(u32, f64)>,
}

/// What walks are in: a scan, and what was seen around it.
struct Scene<'a> {
    rays: &'a Rays,
    around: &'a Surroundings,
    pose: &'a Isometry2<f64>,
    /// In the frame of the scan: the corner of the squares, and from a square to the next one along each axis.
    corner_m: Vector2<f64>,
    right_m: Vector2<f64>,
    up_m: Vector2<f64>,
}

impl Gap {
    /// Whether its ends lie on both sides of the line from the sensor through a place.
    fn spans(&self, place_m: &Vector2<f64>) -> bool {
        self.from_m.perp(place_m) >= 0.0 && place_m.perp(&self.to_m) >= 0.0
    }

    /// Whether a place lies behind the gap, or outside what the scan sees.
    fn is_beyond(&self, place_m: &Vector2<f64>, rays: &Rays) -> bool {
        if self.spans(place_m) {
            return (self.to_m - self.from_m).perp(&(place_m - self.from_m)) <= 0.0;
        }
        !rays.sees(place_m)
    }

    /// The distance of a place from the line between the ends, metres.
    fn off_m(&self, place_m: &Vector2<f64>) -> f64 {
        let along_m = self.to_m - self.from_m;
        let share = ((place_m - self.from_m).dot(&along_m) / along_m.norm_squared()).clamp(0.0, 1.0);
        (place_m - self.from_m - along_m * share).norm()
    }

    /// Whether the vehicle may fit, and there is less than half a turn between its ends.
    fn is_wide(&self, width_m: f64) -> bool {
        (self.to_m - self.from_m).norm() >= width_m && self.from_m.perp(&self.to_m) > 0.0
    }
}

impl<'a> Scene<'a> {
    fn new(rays: &'a Rays, around: &'a Surroundings, pose: &'a Isometry2<f64>) -> Self {
        let [right_m, up_m] =
            [Vector2::x(), Vector2::y()].map(|axis| pose.rotation.inverse_transform_vector(&axis) * SQUARE_M);
        let corner_m = pose.inverse_transform_point(&Point2::from(around.corner_m())).coords;
        Self { rays, around, pose, corner_m, right_m, up_m }
    }

    /// The middle of a square in the frame of the scan.
    fn middle_m(&self, x: usize, y: usize) -> Vector2<f64> {
        self.corner_m + self.right_m * (x as f64 + 0.5) + self.up_m * (y as f64 + 0.5)
    }

    /// The square of a place in the frame of the scan.
    fn square(&self, place_m: &Vector2<f64>) -> Option<[usize; 2]> {
        let at = ((self.pose * Point2::from(*place_m)).coords - self.around.corner_m()) / SQUARE_M;
        let is_inside = |along: f64| (0.0..SQUARES as f64).contains(&along);
        (is_inside(at.x) && is_inside(at.y)).then(|| [at.x as usize, at.y as usize])
    }
}

impl Beyond {
    /// For a vehicle of this width; cells do not tell one narrower than a square from that.
    pub(crate) fn new(width_m: f64) -> Self {
        let width_m = width_m.max(SQUARE_M);
        let disc = Disc::new(0.5 * width_m);
        Self { width_m, disc, walks: 0, came: Vec::new(), of_opening: Vec::new(), open: Vec::new() }
    }

    /// The openings of a scan: its own, or with what it sees, what was seen around it up to now, and its pose.
    pub(crate) fn openings(
        &mut self,
        junction: &Junction,
        stamp_ns: u64,
        seen: Option<(&Rays, &Surroundings, &Isometry2<f64>)>,
    ) -> Vec<KnownOpening> {
        let by_scan = junction.openings.iter().enumerate().map(|(index, opening)| KnownOpening {
            index: Some(index),
            bearing_rad: opening.bearing_rad,
            width_m: opening.width_m,
            p: opening.p,
            seen_ns: (opening.known == Known::Seen).then_some(stamp_ns),
        });
        let mut openings: Vec<KnownOpening> = by_scan.collect();
        let Some((rays, around, pose)) = seen else { return openings };
        self.came.resize(SQUARES * SQUARES, 0);
        self.of_opening.resize(SQUARES * SQUARES, 0);
        let ends_m = junction.openings.iter().map(|opening| opening.edge_m.map(|end_m| end_m.coords.xy()));
        let gaps: Vec<Gap> = ends_m.map(|[from_m, to_m]| Gap { from_m, to_m }).collect();
        let scene = Scene::new(rays, around, pose);
        openings.retain_mut(|opening| {
            let Some(index) = opening.index.filter(|_| opening.seen_ns.is_none()) else { return true };
            let gap = &gaps[index];
            if junction.openings[index].is_cut_by_view() || !gap.is_wide(self.width_m) {
                return true;
            }
            let seen = self.lead(&scene, gap, Through::SeenFree);
            opening.seen_ns = seen.and_then(|square| seen_ns(around, square));
            seen.is_some() || self.lead(&scene, gap, Through::NoWall).is_some()
        });
        // What lies beyond the openings is looked at once it matters.
        let (mut marked, scan) = (false, self.walks + 1);
        for [from_m, to_m] in rays.joined() {
            let gap = Gap { from_m, to_m };
            let middle_m = 0.5 * (from_m + to_m);
            if !gap.is_wide(self.width_m) || gaps.iter().any(|gap| gap.spans(&middle_m)) {
                continue;
            }
            let Some(square) = self.lead(&scene, &gap, Through::SeenFree) else { continue };
            let mut of_opening = std::mem::take(&mut self.of_opening);
            let mut is_known = |square: usize| std::mem::replace(&mut of_opening[square], scan) == scan;
            if !std::mem::replace(&mut marked, true) {
                for gap in &gaps {
                    self.walk(&scene, gap, Through::NoWall, |square, _| {
                        is_known(square);
                        false
                    });
                }
            }
            let is_same = self.walk(&scene, &gap, Through::SeenFree, |square, _| is_known(square)).is_some();
            self.of_opening = of_opening;
            if !is_same {
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

    /// Leads the disc from a gap on. A square that it gets to 3 m from there; `None` if it does not get as far.
    fn lead(&mut self, scene: &Scene<'_>, gap: &Gap, through: Through) -> Option<usize> {
        self.walk(scene, gap, through, |_, off_m| off_m >= DEPTH_M)
    }

    /// Leads the disc from a gap on, to squares less than 3 m from there and the next ones, those that are farther off first, until
    /// `stop` is true of a square and its distance from the gap.
    fn walk(
        &mut self,
        scene: &Scene<'_>,
        gap: &Gap,
        through: Through,
        mut stop: impl FnMut(usize, f64) -> bool,
    ) -> Option<usize> {
        self.walks += 1;
        self.open.clear();
        let Gap { from_m, to_m } = gap;
        let steps = ((to_m - from_m).norm() / CELL_M).ceil();
        for step in 0..=steps as usize {
            // What lies beyond the squares was not seen.
            let Some([x, y]) = scene.square(&from_m.lerp(to_m, step as f64 / steps)) else {
                return (through == Through::NoWall).then_some(0);
            };
            if self.comes_to([x, y]) {
                self.open_if_fits(scene, gap, through, [x, y]);
            }
        }
        while let Some((square, off_m)) = self.open.pop() {
            let square = square as usize;
            if stop(square, off_m) {
                return Some(square);
            }
            if off_m >= DEPTH_M {
                continue;
            }
            let ([x, y], first) = ([square % SQUARES, square / SQUARES], self.open.len());
            for [right, up] in BESIDE {
                if let Some((x, y)) = x.checked_add_signed(right).zip(y.checked_add_signed(up))
                    && x < SQUARES
                    && y < SQUARES
                    && self.comes_to([x, y])
                    && gap.is_beyond(&scene.middle_m(x, y), scene.rays)
                {
                    self.open_if_fits(scene, gap, through, [x, y]);
                }
            }
            self.open[first..].sort_unstable_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
        }
        None
    }

    /// Whether this walk comes to a square for the first time.
    fn comes_to(&mut self, [x, y]: [usize; 2]) -> bool {
        std::mem::replace(&mut self.came[y * SQUARES + x], self.walks) != self.walks
    }

    /// The walk may go on from a square, if the disc fits there.
    fn open_if_fits(&mut self, scene: &Scene<'_>, gap: &Gap, through: Through, [x, y]: [usize; 2]) {
        if self.fits(scene.around, [x, y], through) {
            self.open.push(((y * SQUARES + x) as u32, gap.off_m(&scene.middle_m(x, y))));
        }
    }

    /// Whether the disc fits at the middle of a square.
    fn fits(&self, around: &Surroundings, [x, y]: [usize; 2], through: Through) -> bool {
        match around.under(&self.disc, [SQUARE * x + 1, SQUARE * y + 1]) {
            CellState::Wall => false,
            CellState::Free => true,
            CellState::Never | CellState::Dark => through == Through::NoWall,
        }
    }
}

const BESIDE: [[isize; 2]; 8] = [[1, 0], [-1, 0], [0, 1], [0, -1], [1, 1], [1, -1], [-1, 1], [-1, -1]];

fn seen_ns(around: &Surroundings, square: usize) -> Option<u64> {
    around.seen_ns(SQUARE * (square % SQUARES) + 1, SQUARE * (square / SQUARES) + 1)
}

#[cfg(test)]
mod tests {
    use crosscut_stage::{Evidence, Opening, PoseDoubt};

    use super::*;
    use crate::Tracked;
    use crate::rays::{Ray, RayEnd};

    /// A tunnel 2 m wide along x, with a side way 2 m wide from (3, 1) on, which ends at `end_m`.
    fn tunnel(end_m: f64) -> Vec<[Vector2<f64>; 2]> {
        let [corners, side] = [
            [[3.0, 1.0], [-9.0, 1.0], [-9.0, -1.0], [14.0, -1.0], [14.0, 1.0], [5.0, 1.0]],
            [[5.0, 1.0], [5.0, end_m], [3.0, end_m], [3.0, 1.0], [3.0, 1.0], [3.0, 1.0]],
        ]
        .map(|corners| corners.map(Vector2::from));
        let walls = |corners: &[Vector2<f64>]| corners.windows(2).map(|ends| [ends[0], ends[1]]).collect::<Vec<_>>();
        [walls(&corners), walls(&side)].concat()
    }

    /// What is seen at a place, 720 rays.
    fn rays(walls: &[[Vector2<f64>; 2]], from_m: Vector2<f64>) -> Rays {
        let ray = |at: i32| {
            let mut ray = Ray::new(f64::from(at).to_radians() * 0.5, f64::INFINITY, RayEnd::Wall(0));
            for [a, b] in walls {
                let (along, off) = (b - a, a - from_m);
                let share = off.perp(&ray.towards) / ray.towards.perp(&along);
                let range_m = off.perp(&along) / ray.towards.perp(&along);
                if (0.0..=1.0).contains(&share) && range_m > 0.0 {
                    ray.free_m = ray.free_m.min(range_m);
                }
            }
            ray
        };
        Rays::of_one_wall((-359..=360).map(ray).collect(), true)
    }

    /// The openings at (9, 0), after the vehicle came by from (0, 0), where the scan sees this in the gap at the side way.
    fn after_passing(width_m: f64, end_m: f64, is_opening: bool) -> Vec<KnownOpening> {
        let (walls, mut around) = (tunnel(end_m), Surroundings::default());
        for x in 0..=9_u32 {
            let pose = Isometry2::translation(f64::from(x), 0.0);
            let tracked = Tracked { pose, doubt: PoseDoubt::default(), lost: false };
            around.add(&tracked, 1000 + u64::from(x), &rays(&walls, pose.translation.vector));
        }
        let seen = rays(&walls, Vector2::new(9.0, 0.0));
        let edge_m = [[-4.0, 1.0, 0.0], [-6.0, 1.4, 0.0]].map(crosscut_stage::Point::from);
        let opening = Opening {
            bearing_rad: 2.9,
            width_m: 2.0,
            walls: [0, 0],
            returns: [Some(0), Some(1)],
            gaps: Vec::new(),
            evidence: Evidence::SeenThrough,
            known: Known::Judged,
            edge_m,
            p: Some(0.5),
        };
        let openings = if is_opening { vec![opening] } else { Vec::new() };
        let junction = Junction { openings, ..Junction::default() };
        Beyond::new(width_m).openings(&junction, 1009, Some((&seen, &around, &Isometry2::translation(9.0, 0.0))))
    }

    #[test]
    fn a_side_way_that_was_seen_is_an_opening_whatever_the_scan_says() {
        for is_opening in [false, true] {
            let found = after_passing(0.6, 7.0, is_opening);
            assert!(matches!(found[..], [KnownOpening { seen_ns: Some(1002..=1006), .. }]), "{is_opening}: {found:?}");
            assert_eq!(found[0].index.is_some(), is_opening);
            assert!((found[0].bearing_rad - 2.9).abs() < 0.2 && (1.5..2.5).contains(&found[0].width_m), "{found:?}");
        }
    }

    #[test]
    fn a_pocket_whose_end_was_seen_is_no_opening_whatever_the_scan_says() {
        for (width_m, is_opening) in [(0.6, false), (0.6, true), (0.01, false), (0.01, true), (50.0, false)] {
            assert_eq!(after_passing(width_m, 2.5, is_opening), [], "{width_m}, {is_opening}");
        }
    }

    #[test]
    fn without_a_pose_the_openings_are_those_of_the_scan() {
        let opening = Opening {
            bearing_rad: 1.0,
            width_m: 2.0,
            walls: [0, 0],
            returns: [None, None],
            gaps: Vec::new(),
            evidence: Evidence::NoReturn,
            known: Known::Seen,
            edge_m: [crosscut_stage::Point::origin(); 2],
            p: None,
        };
        let junction = Junction { openings: vec![opening], ..Junction::default() };
        let found = Beyond::new(0.6).openings(&junction, 7, None);
        assert!(matches!(found[..], [KnownOpening { index: Some(0), seen_ns: Some(7), .. }]), "{found:?}");
    }
}
