//! Single places: a few branches that meet, and a lidar near where they do.

use std::f64::consts::{PI, TAU};

use rand::RngExt;

use crate::cloud::{Cloud, Rings};
use crate::course::{bent, half_widths};
use crate::lidar::Lidar;
use crate::mine::Mine;
use crate::network::{Disc, Network, Point, left_of, unit};
use crate::noise::{Generator, generator};
use crate::pose::{Motion, Pose};
use crate::scene::{FIRST_STAMP_NS, Scene, Sweep};
use crate::surface::{Surface, Texture};

/// Branches are at least this far apart.
const APART_RAD: f64 = 54.0 * PI / 180.0;
/// The lidar is at least this far from the rock.
const CLEARANCE_M: f64 = 0.25;
/// Each wall and pillar is met by at least this many beams: fewer are no line, and nobody could name them.
const BEAMS_OF_WALL: usize = 3;
/// Between a pillar and what is beside it there is at least this much room: a vehicle can pass.
const PASSAGE_M: f64 = 0.8;
/// Of so many places that are drawn, one is fit to be seen: most often it is the first.
const MOST_DRAWS: usize = 10_000;

/// A family of places, each with 1 to 5 branches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Places {
    /// Narrowest and widest branch.
    pub width_m: [f64; 2],
    /// The lidar is between these shares of the width away from where the branches meet.
    pub off_centre: [f64; 2],
    /// Standard deviation and length of the bumps.
    pub bumps_m: [f64; 2],
    /// Fewest and most pillars.
    pub pillars: [usize; 2],
    /// The lidar; its noise is drawn anew for every place, from 1 to 2 cm.
    pub lidar: Lidar,
}

impl Places {
    /// 3-6 m wide, bumps of 6 cm, no pillar, nothing lost.
    pub const CLEAN: Self = Self {
        width_m: [3.0, 6.0],
        off_centre: [0.0, 0.25],
        bumps_m: [0.06, 0.8],
        pillars: [0, 0],
        lidar: Lidar::CLEAN,
    };

    /// The scan and truth of one place with this many branches; the same for the same seed. There is room for 5 at
    /// most.
    ///
    /// # Panics
    /// With more branches, or when no place is fit to be seen: too narrow for the lidar, or for the pillars.
    pub fn scene(&self, branches: usize, seed: u64, stamp_ns: u64) -> Scene {
        self.look(branches, seed, |mine, _, sweep, rng| sweep.scene(mine, stamp_ns, rng))
    }

    /// What a lidar of `rings` sees of the same place, and the truth of the level scan.
    ///
    /// # Panics
    /// As [`Places::scene`].
    pub fn cloud(&self, branches: usize, seed: u64, rings: Rings) -> Cloud {
        self.look(branches, seed, |mine, pose, sweep, rng| {
            let truth = sweep.scene(mine, FIRST_STAMP_NS, rng).truth;
            Cloud { points_m: rings.look(sweep.lidar, mine, pose, rng), truth }
        })
    }

    /// Draws places until one is fit to be seen: with room for the lidar and its pillars, and no mere scrap of a wall.
    fn look<T>(&self, branches: usize, seed: u64, see: impl FnOnce(&Mine, Pose, &Sweep, &mut Generator) -> T) -> T {
        let mut rng = generator(seed, "place");
        let lidar = Lidar { noise_sd_m: rng.random_range(0.01..0.02), ..self.lidar };
        for _ in 0..MOST_DRAWS {
            let Some((mine, pose)) = self.place(branches, &mut rng) else { continue };
            let sweep = Sweep::of(&mine, &lidar, &Motion::still(pose));
            if sweep.scenery.fewest_beams() >= BEAMS_OF_WALL {
                return see(&mine, pose, &sweep, &mut rng);
            }
        }
        panic!("none of {MOST_DRAWS} places of {branches} branches is fit to be seen: {self:?}");
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
            // Away from its one branch, a dead end goes on a little.
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
