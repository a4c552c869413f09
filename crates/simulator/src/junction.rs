//! Single places: a few branches that meet, and a lidar near the point where they meet.

use std::f64::consts::{PI, TAU};

use rand::RngExt;

use crate::cloud::{Cloud, Rings};
use crate::course::{bent, half_widths};
use crate::lidar::Lidar;
use crate::mine::Mine;
use crosscut_stage::unit;

use crate::network::{Disc, Network, Point, left_of};
use crate::noise::{Generator, generator};
use crate::pose::{Motion, Pose};
use crate::scene::{FIRST_STAMP_NS, Scene, View};
use crate::surface::{Surface, Texture};

/// Branches are at least this far apart.
const APART_RAD: f64 = 54.0 * PI / 180.0;
/// The lidar is at least this far from the rock.
const CLEARANCE_M: f64 = 0.25;
/// At least this many beams meet each wall and pillar: fewer do not make a line that could be recognised.
const BEAMS_OF_WALL: usize = 3;
/// A pillar is at least this far from walls, other pillars and the lidar, so that a vehicle can pass.
const PASSAGE_M: f64 = 0.8;
/// At most this many places are drawn to find a suitable one; usually the first is suitable.
const MOST_DRAWS: usize = 10_000;

/// A family of places, each with 1 to 5 branches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Places {
    /// Width of the narrowest and of the widest branch.
    pub width_m: [f64; 2],
    /// Least and largest distance of the lidar from the point where the branches meet, as a share of the width.
    pub off_centre: [f64; 2],
    /// Standard deviation and correlation length of the bumps.
    pub bumps_m: [f64; 2],
    /// Least and largest number of pillars.
    pub pillars: [usize; 2],
    /// The lidar. Its noise is drawn for each place, from 1 to 2 cm.
    pub lidar: Lidar,
}

impl Places {
    /// 3-6 m wide, bumps of 6 cm, no pillars, no lost beams.
    pub const CLEAN: Self = Self {
        width_m: [3.0, 6.0],
        off_centre: [0.0, 0.25],
        bumps_m: [0.06, 0.8],
        pillars: [0, 0],
        lidar: Lidar::CLEAN,
    };

    /// The scan and truth of one place with this many branches, at most 5. The same seed gives the same scene.
    ///
    /// # Panics
    /// With more than 5 branches, or if no suitable place is found because it is too narrow for the lidar or the pillars.
    pub fn scene(&self, branches: usize, seed: u64, stamp_ns: u64) -> Scene {
        self.suitable_place(branches, seed, |mine, _, view, rng| view.scene(mine, stamp_ns, rng))
    }

    /// The cloud of a lidar of `rings` at the place of [`Places::scene`], with the truth of the level scan.
    ///
    /// # Panics
    /// As [`Places::scene`].
    pub fn cloud(&self, branches: usize, seed: u64, rings: Rings) -> Cloud {
        self.suitable_place(branches, seed, |mine, pose, view, rng| {
            let truth = view.scene(mine, FIRST_STAMP_NS, rng).truth;
            Cloud { points_m: rings.points_m(view.lidar, mine, pose, rng), truth }
        })
    }

    /// Draws places until one has room for the lidar and its pillars and no wall of too few beams, and observes it.
    fn suitable_place<T>(
        &self,
        branches: usize,
        seed: u64,
        observe: impl FnOnce(&Mine, Pose, &View, &mut Generator) -> T,
    ) -> T {
        let mut rng = generator(seed, "place");
        let lidar = Lidar { noise_sd_m: rng.random_range(0.01..0.02), ..self.lidar };
        for _ in 0..MOST_DRAWS {
            let Some((mine, pose)) = self.place(branches, &mut rng) else { continue };
            let view = View::of(&mine, &lidar, &Motion::still(pose));
            if view.scenery.fewest_beams() >= BEAMS_OF_WALL {
                return observe(&mine, pose, &view, &mut rng);
            }
        }
        panic!("none of {MOST_DRAWS} places of {branches} branches is suitable: {self:?}");
    }

    fn place(&self, branches: usize, rng: &mut Generator) -> Option<(Mine, Pose)> {
        let length_m = self.lidar.range_max_m + 5.0;
        let mut network = Network::new(4.0);
        let centre = network.add_node(Point::origin());
        let bearings_rad = bearings_apart(branches, rng);
        for &bearing_rad in &bearings_rad {
            let line = bent(Point::origin(), bearing_rad, length_m, rng.random_range(-0.012..0.012));
            let widths = half_widths(line.len(), 0.5 * self.width_m(rng), 0.04, rng);
            network.add_branch(centre, line, widths);
        }
        if branches == 1 {
            // A dead end continues a little beyond the point opposite its branch.
            let width_m = self.width_m(rng);
            let away_rad = bearings_rad[0] + PI + rng.random_range(-0.5..0.5);
            let line = bent(Point::origin(), away_rad, width_m * rng.random_range(0.6..1.6), 0.0);
            let widths = half_widths(line.len(), 0.5 * width_m, 0.04, rng);
            network.add_branch(centre, line, widths);
        }
        let width_m = 2.0 * network.half_width_at_m(centre);
        let [nearest, farthest] = self.off_centre.map(|share| share * width_m);
        let position_m =
            Point::origin() + unit(rng.random_range(0.0..TAU)) * (nearest + (farthest - nearest) * rng.random::<f64>());
        self.add_pillars(&mut network, position_m, rng)?;
        let [bump_sd_m, bump_length_m] = self.bumps_m;
        let texture = Texture { bump_sd_m, bump_length_m, ..Texture::SMOOTH };
        let surface = Surface::new(&network, &texture, rng.random());
        let free = surface.sees(position_m, Point::origin()) && surface.clearance_m(position_m, 1.0) >= CLEARANCE_M;
        free.then(|| (Mine::new(network, surface), Pose::level(position_m, rng.random_range(-PI..PI))))
    }

    fn width_m(&self, rng: &mut Generator) -> f64 {
        rng.random_range(self.width_m[0]..self.width_m[1])
    }

    /// Puts pillars into the branches; `None` if there is no room for them.
    fn add_pillars(&self, network: &mut Network, lidar_m: Point, rng: &mut Generator) -> Option<()> {
        for _ in 0..rng.random_range(self.pillars[0]..=self.pillars[1]) {
            let tunnel = &network.tunnels[rng.random_range(0..network.tunnels.len())];
            // The centreline has a point every half metre.
            let at = rng.random_range(4..15).min(tunnel.centreline_m.len() - 1);
            let radius_m = rng.random_range(0.4..0.8);
            let room_m = tunnel.half_widths_m[at] - radius_m - PASSAGE_M;
            if room_m <= 0.0 {
                return None;
            }
            let side_m = rng.random_range(-room_m..room_m);
            let centre_m = tunnel.centreline_m[at] + left_of(tunnel.tangent(at)) * side_m;
            let apart = |pillar: &Disc| (pillar.centre_m - centre_m).norm() > pillar.radius_m + radius_m + PASSAGE_M;
            if (centre_m - lidar_m).norm() < radius_m + PASSAGE_M || !network.pillars.iter().all(apart) {
                return None;
            }
            network.pillars.push(Disc { centre_m, radius_m });
        }
        Some(())
    }
}

/// Bearings in random directions, neighbours at least [`APART_RAD`] apart.
fn bearings_apart(branches: usize, rng: &mut Generator) -> Vec<f64> {
    let spare_rad = TAU - branches as f64 * APART_RAD;
    let mut cuts: Vec<f64> = (1..branches).map(|_| rng.random_range(0.0..spare_rad)).collect();
    cuts.sort_by(f64::total_cmp);
    let first_rad = rng.random_range(0.0..TAU);
    let rest = cuts.iter().enumerate().map(|(i, cut)| first_rad + (i + 1) as f64 * APART_RAD + cut);
    std::iter::once(first_rad).chain(rest).collect()
}
