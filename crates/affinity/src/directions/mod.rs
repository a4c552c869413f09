//! `directions`: ways on in three dimensions, the dual of the walls.
//!
//! In the plane, n gaps in a ring of returns leave n walls. On the sphere of directions n gaps leave one surface with n holes:
//! what is hit cannot count ways on, and what is open can, in every dimension. So the rows of W are directions.
//!
//! 1. **Cells.** The sphere is cut into cells of nearly one size, at most 2,000, of about 8 points each or more, and none so low
//!    that it lies between two rings of the lidar. A cell shows the return that a quarter of its returns are nearer than, so that
//!    dust does not count. Returns within half the vehicle's width are of the vehicle. A ring of cells at one elevation with returns
//!    in fewer than half of them is not looked at, nor is one at the edge with fewer than half of the returns of the one beside it:
//!    in a part of a cell, a few returns of dust would count. Elsewhere a cell without a return is open. Rings lie about the
//!    axis of the lidar, also of a tilted one.
//! 2. **Room.** R is the radius of the largest ball that holds the sensor and no return, its centre no farther aside than the
//!    nearest return: from near the ground it rises to the middle of the place, and does not roll along.
//! 3. **Reach.** F(e) is how far the vehicle's ball, of radius r, gets straight on in direction e: the least p·e - √(r² - |p -
//!    (p·e) e|²) over the returns p that are nearer than r to the ray.
//! 4. **Cut.** Nodes are the cells with F(e) >= 2.25 R; W_ij = exp(-σ |e_i - e_j|²) between cells that touch, 0 otherwise, and
//!    W_ii = 1. The components are the ways, if one of their cells has F(e) >= 2.475 R. Rock that reaches between two ways nearer than
//!    2.25 R tells them apart, and a recess that is not as deep is none.
//! 5. **What stays.** p of a way is the share of right answers, on development seeds, whose least way stays by itself at as
//!    many of five distances from 1.75 to 2.75 R; less where the view cuts it or is narrow, where it takes up half a turn or 30 % of all directions, as in a
//!    place that is wide for its height, and where something is seen hardly farther than r: it is rather the vehicle.
//!
//! 6. **Slope** of a way is the elevation of the line between its middles at 2 R and 3 R, each the mean of the cells with F(e) that
//!    far: where the sensor stands, low or high, does not turn that line. Where the view cuts them above or below, it is that of the
//!    line between their other edges.
//!
//! The direction of a way is the mean of its cells, by the square of the room around the point 2.36 R away on each, or that in
//! which the vehicle gets farthest, if the way is not open at its mean; its clearance is twice the largest of these rooms. Of a scan without a cloud, the cells are those of the horizon, 1° wide.

mod reach;
mod sight;
mod slope;
mod sphere;
mod ways;

pub use ways::Found;

use crosscut_scan::VEHICLE_WIDTH_M;
use crosscut_stage::NoteCode::N106;
use crosscut_stage::{Affinity, AffinityStage, Beam, Between, Cell, Dual, Kind, Notes, Point, Revolution, StageError};

use nalgebra::{UnitQuaternion, Vector3};
use sight::{Seen, Sight};
use sphere::Sphere;

/// Cells of the sphere, and of the horizon alone.
const CELLS: usize = 2000;
/// See [`CELLS`].
const LEAST_CELLS: usize = 400;
/// See [`CELLS`].
const LEVEL_CELLS: usize = 360;
/// Cells have this many points on average, or more.
const LEAST_POINTS: usize = 8;
/// W_ij of two cells beside each other is about exp(-1/4).
const SIGMA: f64 = 0.25;

/// Directions that are open, and ways on.
pub const KIND: Kind<dyn AffinityStage> = Kind::affinity(
    "directions",
    "exp(-sigma |e_i - e_j|²) between neighbouring directions in which the vehicle gets on: their components are the ways on, in three dimensions",
    |params| Box::new(Directions { width_m: params.get(VEHICLE_WIDTH_M), sky: Sky::default() }),
)
.params(&[VEHICLE_WIDTH_M.shared("vehicle.width_m")])
.takes_cloud();

struct Directions {
    width_m: f64,
    sky: Sky,
}

/// A lidar that does not look everywhere may be tilted by as much for its answers to be sure.
const MOST_TILT_RAD: f64 = 0.4;

/// What is seen around the sensor, kept from cloud to cloud.
#[derive(Clone, Debug, Default)]
pub struct Sky {
    sphere: Sphere,
    /// The number of cells that `sphere` was made for.
    made_for: usize,
    sight: Sight,
    reach_m: Vec<f64>,
    /// R, the radius of the largest ball that holds the sensor, metres.
    pub room_m: f64,
    /// The radius of the vehicle, metres.
    radius_m: f64,
    /// From the frame of the sphere, in which the axis of the lidar is upright, to the level one.
    tilt: UnitQuaternion<f64>,
}

impl Sky {
    fn is_level(&self) -> bool {
        self.tilt == UnitQuaternion::default()
    }

    /// Cuts the sphere, or the horizon, into so many cells. (The horizon has fewer than any sphere.)
    fn cut(&mut self, cells: usize, of: fn(usize) -> Sphere) {
        if self.made_for != cells {
            (self.sphere, self.made_for) = (of(cells), cells);
        }
    }

    /// Looks at a cloud that `tilt` turned level ([`Revolution::cloud_tilt`]), for a vehicle of this width.
    pub fn look(&mut self, points_m: &[Point], tilt: &UnitQuaternion<f64>, width_m: f64) {
        self.tilt = *tilt;
        let upright_m: Vec<Point>;
        let points_m = if self.is_level() {
            points_m
        } else {
            upright_m = points_m.iter().map(|point_m| tilt.inverse_transform_point(point_m)).collect();
            &upright_m
        };
        let mut wanted = CELLS.min(points_m.len() / LEAST_POINTS).max(LEAST_CELLS).next_multiple_of(100);
        loop {
            self.cut(wanted, Sphere::of);
            self.sight.look(&self.sphere, points_m, 0.5 * width_m);
            // Between the rings of a lidar there is nothing to see.
            if !self.sight.hide_unseen(&self.sphere) || wanted <= LEAST_CELLS {
                break;
            }
            wanted = (wanted * 2 / 3).max(LEAST_CELLS).next_multiple_of(100);
        }
        self.measure(width_m);
    }

    /// Looks at the returns of a level sweep.
    fn look_level(&mut self, revolution: &Revolution, width_m: f64) {
        self.tilt = UnitQuaternion::default();
        let sweep = revolution.beams();
        let beams = sweep.map_or(revolution.len(), |sweep| sweep.len() + sweep.missing);
        let cells = LEVEL_CELLS.min(beams).max(16);
        self.cut(cells, Sphere::level);
        self.sight.look(&self.sphere, &revolution.points_m, 0.5 * width_m);
        if let Some(sweep) = sweep {
            let mut looked_at = vec![false; cells];
            for (beam, bearing_rad) in sweep.beams.iter().zip(&sweep.bearings_rad) {
                let towards = Vector3::new(bearing_rad.cos(), bearing_rad.sin(), 0.0);
                looked_at[self.sphere.cell(&towards, 1.0)] |= *beam != Beam::Unknown;
            }
            let unseen = self.sight.seen.iter_mut().zip(looked_at).filter(|(_, looked_at)| !looked_at);
            unseen.filter(|(seen, _)| **seen == Seen::Nothing).for_each(|(seen, _)| *seen = Seen::Unknown);
        }
        self.measure(width_m);
    }

    /// The vertical axis in the frame of the lidar.
    fn up(&self) -> Vector3<f64> {
        self.tilt.inverse_transform_vector(&Vector3::z())
    }

    fn measure(&mut self, width_m: f64) {
        self.radius_m = 0.5 * width_m;
        self.room_m = reach::room_m(&self.sphere, &self.sight, &self.up());
        reach::reach_m(&self.sphere, &self.sight, self.radius_m, &mut self.reach_m);
    }

    /// The ways that are seen, by their first cell.
    pub fn ways(&self) -> Vec<Found> {
        if !self.room_m.is_finite() {
            return Vec::new();
        }
        let mut found = ways::find(&self.sphere, &self.sight, &self.reach_m, self.room_m, self.is_doubtful());
        let slopes_rad = slope::slopes_rad(&self.sphere, &self.sight, &self.reach_m, self.room_m, &self.up(), &found);
        for (Found { way, .. }, slope_rad) in found.iter_mut().zip(slopes_rad) {
            way.direction = self.leveled(way.direction);
            way.slope_rad = slope_rad.unwrap_or_else(|| way.elevation_rad());
        }
        found
    }

    /// Whether parts of the vehicle bound the room, a cloud has few points, or level ways may lie where a lidar does not look that is
    /// tilted by much.
    fn is_doubtful(&self) -> bool {
        let is_sparse = self.made_for == LEAST_CELLS && self.sphere.rings().len() > 1;
        let is_steep = self.tilt.transform_vector(&Vector3::z()).z < MOST_TILT_RAD.cos();
        self.own_m().is_some() || is_sparse || is_steep && ways::is_narrow(&self.sphere, &self.sight)
    }

    /// How near the nearest that is seen is, if it is rather a part of the vehicle, metres.
    fn own_m(&self) -> Option<f64> {
        let near_m = reach::clear_m(&self.sight, &Vector3::zeros());
        (near_m < ways::OWN_RADII * self.radius_m).then_some(near_m)
    }

    fn leveled(&self, direction: Vector3<f64>) -> Vector3<f64> {
        if self.is_level() { direction } else { self.tilt * direction }
    }

    /// What parts the ways.
    fn between(&self, ways: &[Found]) -> Vec<Between> {
        let found = ways::between(&self.sphere, &self.reach_m, ways).into_iter();
        found.map(|of| Between { direction: self.leveled(of.direction), ..of }).collect()
    }

    /// The lowest and the highest elevation at which something is known, radians; 0 of nothing.
    fn view_rad(&self) -> [f64; 2] {
        if self.is_level() {
            return self.sight.view_rad(&self.sphere);
        }
        let known = self.sphere.directions.iter().zip(&self.sight.seen).filter(|(_, seen)| **seen != Seen::Unknown);
        let elevations_rad = known.map(|(direction, _)| [(self.tilt * direction).z.clamp(-1.0, 1.0).asin(); 2]);
        elevations_rad.reduce(|[low, high], [at, _]| [low.min(at), high.max(at)]).unwrap_or_default()
    }

    /// All cells; of each its row, and of each row its cell and way.
    fn cells(&self, row_of: &[Option<u32>], rows: &[(u32, u32)]) -> Vec<Cell> {
        let cell = |cell: usize| {
            let known_m = |m: f64| if self.sight.seen[cell] == Seen::Unknown { f64::NAN } else { m };
            let range_m = if let Seen::Return(at_m) = self.sight.seen[cell] { at_m.norm() } else { f64::INFINITY };
            Cell {
                direction: self.sphere.directions[cell].into_inner(),
                range_m: known_m(range_m),
                reach_m: known_m(self.reach_m[cell]),
                way: row_of[cell].map(|row| rows[row as usize].1),
            }
        };
        (0..self.sphere.len()).map(cell).collect()
    }
}

impl AffinityStage for Directions {
    fn weigh(&mut self, revolution: &Revolution, out: &mut Affinity, notes: &mut Notes) -> Result<(), StageError> {
        let Self { width_m, sky } = self;
        if revolution.cloud_m.is_empty() {
            sky.look_level(revolution, *width_m);
        } else {
            sky.look(&revolution.cloud_m, &revolution.cloud_tilt, *width_m);
        }
        if let Some(near_m) = sky.own_m() {
            let least_m = (10.0 * ways::OWN_RADII * sky.radius_m).ceil() / 10.0;
            notes.add(
                N106,
                format!(
                    "directions: something is {near_m:.2} m from the sensor, as parts of the vehicle are, so no way is sure; if it is one, and \
                     not the ground, --set ingest.min_range_m={least_m} leaves it out"
                ),
            );
        }
        let ways = sky.ways();
        let mut row_of = vec![None; sky.sphere.len()];
        let cells: Vec<(u32, u32)> =
            (0..).zip(&ways).flat_map(|(of, way)| way.cells.iter().map(move |cell| (*cell, of))).collect();
        (0..).zip(&cells).for_each(|(row, (cell, _))| row_of[*cell as usize] = Some(row));
        let sigma = SIGMA / (sky.sphere.step_rad() * sky.sphere.step_rad());
        let w = out.weights.make_sparse();
        for &(cell, of) in &cells {
            let direction = sky.sphere.directions[cell as usize];
            let beside = sky.sphere.neighbours[cell as usize].iter().copied();
            let mut row: Vec<(u32, f64)> = beside
                .filter_map(|other| {
                    let row: u32 = row_of[other as usize]?;
                    let off =
                        (sky.sphere.directions[other as usize].into_inner() - direction.into_inner()).norm_squared();
                    (cells[row as usize].1 == of).then(|| (row, (-sigma * off).exp()))
                })
                .collect();
            row.extend(row_of[cell as usize].map(|row| (row, 1.0)));
            row.sort_unstable_by_key(|(row, _)| *row);
            row.iter().for_each(|(row, weight)| w.push(*row, *weight));
            w.end_row();
        }
        let room_m = if sky.room_m.is_finite() { sky.room_m } else { 0.0 };
        out.dual = Some(Dual {
            cells: sky.cells(&row_of, &cells),
            tilt: sky.tilt,
            between: sky.between(&ways),
            ways: ways.iter().map(|found| found.way).collect(),
            view_rad: sky.view_rad(),
            room_m,
            cut_m: ways::APART * room_m,
            on_m: ways::ON * room_m,
        });
        Ok(())
    }
}
