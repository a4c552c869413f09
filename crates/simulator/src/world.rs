//! Worlds to explore: a mine, a lidar, and where the vehicle starts. Families of them by name.

use std::f64::consts::PI;

use crosscut_messages::TruthPose;
use rand::RngExt;

use crate::course::{bent, half_widths};
use crate::lidar::Lidar;
use crate::mine::Mine;
use crate::network::{Network, Point};
use crate::noise::{Generator, generator};
use crate::pose::Pose;
use crate::presets::{add_pillars, add_spur, drive, headings_rad, rock_of_mine, rooms};
use crate::surface::{Surface, Texture};

/// The vehicle starts this far from the face of a dead end, m.
const FROM_FACE_M: f64 = 3.0;
/// A tunnel has this much rock beside it, m.
const ROCK_M: f64 = 2.0;
/// Most draws of a tunnel that finds no room.
const MOST_DRAWS: usize = 12;

/// A mine with a vehicle in it.
#[derive(Clone, Debug)]
pub struct World {
    /// The mine.
    pub mine: Mine,
    /// The lidar of the vehicle.
    pub lidar: Lidar,
    /// Where the vehicle starts, and its home.
    pub start: Pose,
    /// The node that the vehicle starts at.
    pub start_node: usize,
}

/// A family of worlds with a name.
#[derive(Clone, Copy, Debug)]
pub struct Family {
    /// Name of the family.
    pub name: &'static str,
    /// Description in one line.
    pub doc: &'static str,
    /// The world of a seed.
    pub world: fn(seed: u64) -> World,
}

/// All families.
pub fn families() -> &'static [Family] {
    &[
        Family { name: "tee", doc: "one T junction, tunnels 3.5 m wide", world: tee },
        Family { name: "tree", doc: "tunnels 3-4 m wide that branch and end, no loops", world: tree },
        Family { name: "loops", doc: "tunnels 3.4-4.6 m wide around blocks of rock, with dead ends", world: loops },
        Family {
            name: "look_alikes",
            doc: "a ladder of straight tunnels 4 m wide: all rungs are alike",
            world: ladder,
        },
        Family {
            name: "chambers",
            doc: "tunnels 3.4-4.6 m wide in loops, some meet in round chambers",
            world: chambers,
        },
        Family { name: "pillars", doc: "tunnels 5.4-6.6 m wide in loops, with pillars", world: pillars },
        Family { name: "wet", doc: "tunnels 5.4-6.6 m wide in loops; a quarter of the walls is wet", world: wet },
        Family { name: "dust", doc: "tunnels 3.4-4.6 m wide in loops, 2 % returns from dust", world: dust },
        Family { name: "narrow", doc: "tunnels 1.6-2.4 m wide that branch and end, no loops", world: narrow },
        Family { name: "tunnel", doc: "the long drive of 3.5 m x 3 m of `simulate tunnel`", world: tunnel },
        Family { name: "mine", doc: "the mine of 6 m x 4 m of `simulate mine`, with loops and wet walls", world: mine },
    ]
}

impl World {
    /// A pose in the frame of the start, in that of the mine.
    pub fn pose_of(&self, seen: &TruthPose) -> Pose {
        let off = nalgebra::Rotation2::new(self.start.heading_rad) * nalgebra::Vector2::new(seen.x_m, seen.y_m);
        Pose::level(self.start.position_m + off, self.start.heading_rad + seen.yaw_rad)
    }

    /// The world of a network. The vehicle starts before the face of dead end `start`, or at node `start` of another kind.
    pub(crate) fn new(network: Network, texture: &Texture, lidar: Lidar, start: usize, seed: u64) -> Self {
        let surface = Surface::new(&network, texture, seed);
        let heading_rad = headings_rad(&network, start).first().copied().unwrap_or(0.0);
        let centre_m = network.nodes[start].position_m;
        let tunnel = network.tunnels.iter().find(|tunnel| tunnel.ends.contains(&start));
        let at = tunnel.filter(|_| network.degree(start) == 1).and_then(|tunnel| {
            let mut line = tunnel.centreline_m.clone();
            if tunnel.ends[0] != start {
                line.reverse();
            }
            let first = line.iter().position(|point| (point - centre_m).norm() >= FROM_FACE_M)?;
            let next = *line.get(first + 1)?;
            let towards = next - line[first];
            Some(Pose::level(line[first], towards.y.atan2(towards.x)))
        });
        let start_pose = at.unwrap_or_else(|| Pose::level(centre_m, heading_rad));
        Self { mine: Mine::new(network, surface), lidar, start: start_pose, start_node: start }
    }
}

/// Bumps of ordinary rock.
const ROUGH: Texture = Texture { bump_sd_m: 0.08, bump_length_m: 0.8, ..Texture::SMOOTH };

fn tee(seed: u64) -> World {
    let mut rng = generator(seed, "world of a tee");
    let mut network = Network::new(3.0);
    let start = network.add_node(Point::new(-16.0, 0.0));
    let mut add = |network: &mut Network, from: usize, heading_rad: f64, length_m: f64| {
        let line = bent(network.nodes[from].position_m, heading_rad, length_m, rng.random_range(-0.006..0.006));
        let widths = half_widths(line.len(), 1.75, 0.04, &mut rng);
        network.add_branch(from, line, widths)
    };
    let tee = add(&mut network, start, 0.0, 18.0);
    add(&mut network, tee, 1.5, 16.0);
    add(&mut network, tee, -1.6, 16.0);
    World::new(network, &ROUGH, Lidar::ORDINARY, start, seed)
}

fn tree(seed: u64) -> World {
    let mut rng = generator(seed, "world of a tree");
    let network = branching([1.5, 2.0], [14.0, 28.0], &mut rng);
    World::new(network, &ROUGH, Lidar::ORDINARY, 0, seed)
}

fn narrow(seed: u64) -> World {
    let mut rng = generator(seed, "world of narrow tunnels");
    let network = branching([0.8, 1.2], [9.0, 20.0], &mut rng);
    World::new(network, &Texture { bump_sd_m: 0.04, ..ROUGH }, Lidar::ORDINARY, 0, seed)
}

fn loops(seed: u64) -> World {
    let mut rng = generator(seed, "world of loops");
    let (network, start) = blocks([1.7, 2.3], 21.0, &mut rng);
    World::new(network, &ROUGH, Lidar::ORDINARY, start, seed)
}

fn dust(seed: u64) -> World {
    let mut rng = generator(seed, "world of dust");
    let (network, start) = blocks([1.7, 2.3], 21.0, &mut rng);
    World::new(network, &ROUGH, Lidar { loss: 0.1, dust: 0.02, ..Lidar::ORDINARY }, start, seed)
}

fn wet(seed: u64) -> World {
    let mut rng = generator(seed, "world of wet rock");
    let (network, start) = blocks([2.7, 3.3], 27.0, &mut rng);
    World::new(network, &rock_of_mine(), Lidar::IN_WET_MINE, start, seed)
}

fn pillars(seed: u64) -> World {
    let mut rng = generator(seed, "world of pillars");
    let (mut network, start) = blocks([2.7, 3.3], 27.0, &mut rng);
    add_pillars(&mut network, 10, &mut rng);
    World::new(network, &ROUGH, Lidar::ORDINARY, start, seed)
}

fn chambers(seed: u64) -> World {
    let mut rng = generator(seed, "world of chambers");
    let (mut network, start) = blocks([1.7, 2.3], 24.0, &mut rng);
    for node in 0..network.nodes.len() {
        if network.degree(node) > 1 && rng.random_bool(0.4) {
            network.nodes[node].chamber_radius_m = rng.random_range(1.5..2.2) * network.half_width_at_m(node);
        }
    }
    World::new(network, &ROUGH, Lidar::ORDINARY, start, seed)
}

/// Two straight rails with rungs at equal distances. The vehicle starts at the end of a rail.
fn ladder(seed: u64) -> World {
    const SPACING_M: f64 = 18.0;
    const HALF_WIDTH_M: f64 = 2.0;
    let mut rng = generator(seed, "world of a ladder");
    let rungs = rng.random_range(2..=4);
    let mut network = Network::new(3.0);
    let add = |network: &mut Network, from: usize, to: usize| {
        let [from_m, to_m] = [from, to].map(|node| network.nodes[node].position_m);
        let along = to_m - from_m;
        let line = bent(from_m, along.y.atan2(along.x), along.norm(), 0.0);
        let widths = vec![HALF_WIDTH_M; line.len()];
        network.add_tunnel(from, to, line, widths);
    };
    let rail = |network: &mut Network, y_m: f64| -> Vec<usize> {
        (0..=rungs + 1).map(|at| network.add_node(Point::new(at as f64 * SPACING_M, y_m))).collect()
    };
    let rails = [rail(&mut network, 0.0), rail(&mut network, SPACING_M)];
    for rail in &rails {
        for pair in rail.windows(2) {
            add(&mut network, pair[0], pair[1]);
        }
    }
    for (&from, &to) in rails[0].iter().zip(&rails[1]).skip(1).take(rungs) {
        add(&mut network, from, to);
    }
    World::new(network, &Texture { bump_sd_m: 0.05, ..ROUGH }, Lidar::ORDINARY, rails[0][0], seed)
}

fn tunnel(seed: u64) -> World {
    let (network, route) = drive(&mut generator(seed, "tunnel"));
    let texture = Texture { bump_sd_m: 0.12, bump_length_m: 0.8, ..Texture::SMOOTH };
    World::new(network, &texture, Lidar::ORDINARY, route[0], seed)
}

fn mine(seed: u64) -> World {
    let (network, route) = rooms(9, &mut generator(seed, "mine"));
    let start = (0..network.nodes.len()).find(|&node| network.degree(node) == 1).unwrap_or(route[0]);
    World::new(network, &rock_of_mine(), Lidar::IN_WET_MINE, start, seed)
}

/// A tree of tunnels from node 0, a dead end, on.
fn branching(half_widths_m: [f64; 2], lengths_m: [f64; 2], rng: &mut Generator) -> Network {
    const JUNCTIONS: usize = 4;
    let mut network = Network::new(3.0);
    let root = network.add_node(Point::origin());
    let draw = |[from, to]: [f64; 2], rng: &mut Generator| rng.random_range(from..to);
    let line = bent(Point::origin(), 0.0, draw(lengths_m, rng), 0.0);
    let widths = half_widths(line.len(), draw(half_widths_m, rng), 0.05, rng);
    let mut ends = vec![network.add_branch(root, line, widths)];
    for _ in 0..JUNCTIONS {
        let from = ends.remove(rng.random_range(0..ends.len()));
        let came_rad = headings_rad(&network, from)[0];
        let ways = if rng.random_bool(0.25) { 3 } else { 2 };
        let mut turns_rad: Vec<f64> = Vec::new();
        for _ in 0..ways * MOST_DRAWS {
            // A turn from the way back; neighbours are at least 60° apart.
            let turn_rad = rng.random_range(1.05..2.0 * PI - 1.05);
            let (half_width_m, length_m) = (draw(half_widths_m, rng), draw(lengths_m, rng));
            let from_m = network.nodes[from].position_m;
            let line = bent(from_m, came_rad + turn_rad, length_m, rng.random_range(-0.015..0.015));
            let is_apart = turns_rad.iter().all(|other| (other - turn_rad).abs() > 1.05);
            let has_room = network.has_room_for(from, &line, half_width_m, ROCK_M);
            if turns_rad.len() < ways && is_apart && has_room {
                let widths = half_widths(line.len(), half_width_m, 0.05, rng);
                ends.push(network.add_branch(from, line, widths));
                turns_rad.push(turn_rad);
            }
        }
        if ends.is_empty() {
            break;
        }
    }
    network
}

/// Tunnels around 2 x 2 blocks of rock, with dead ends, and the dead end that the vehicle starts at.
fn blocks(half_widths_m: [f64; 2], spacing_m: f64, rng: &mut Generator) -> (Network, usize) {
    const SIDE: usize = 3;
    let mut network = Network::new(3.0);
    for index in 0..SIDE * SIDE {
        let mut jitter_m = || rng.random_range(-0.13..0.13) * spacing_m;
        let (x, y) = ((index % SIDE) as f64 * spacing_m + jitter_m(), (index / SIDE) as f64 * spacing_m + jitter_m());
        network.add_node(Point::new(x, y));
    }
    let mut edges = crate::presets::grid_edges(SIDE, rng);
    // Some of the tunnels on the rim are left out, so that there are several shapes of loops.
    for _ in 0..2 {
        let left_out = rng.random_range(0..edges.len());
        let degree = |node: usize| edges.iter().filter(|(a, b)| *a == node || *b == node).count();
        if degree(edges[left_out].0) > 2 && degree(edges[left_out].1) > 2 {
            edges.remove(left_out);
        }
    }
    for (from, to) in edges {
        let (from_m, to_m) = (network.nodes[from].position_m, network.nodes[to].position_m);
        let line = crate::course::swaying(from_m, to_m, rng.random_range(-1.0..1.0));
        let widths = half_widths(line.len(), rng.random_range(half_widths_m[0]..half_widths_m[1]), 0.06, rng);
        network.add_tunnel(from, to, line, widths);
    }
    let half_width_m = 0.5 * (half_widths_m[0] + half_widths_m[1]);
    // The first spur is where the vehicle starts.
    for node in (0..SIDE * SIDE).map(|at| (at + SIDE) % (SIDE * SIDE)) {
        if network.nodes.len() == SIDE * SIDE || rng.random_bool(0.3) {
            add_spur(&mut network, node, half_width_m, |rng| rng.random_range(-PI..PI), rng);
        }
    }
    let start = (SIDE * SIDE..network.nodes.len()).next().unwrap_or(0);
    (network, start)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_world_has_room_for_the_vehicle_and_something_to_explore() {
        for family in families() {
            for seed in 0..8 {
                let world = (family.world)(seed);
                let network = world.mine.network();
                let junctions = (0..network.nodes.len()).filter(|&node| network.degree(node) > 2).count();
                assert!(junctions >= 1, "{} {seed} has no junction", family.name);
                let clear_m = world.mine.surface().clearance_m(world.start.position_m, 9.0);
                assert!(clear_m > 0.4, "{} {seed}: {clear_m} m at the start", family.name);
                let narrowest_m = network.tunnels.iter().flat_map(|tunnel| &tunnel.half_widths_m).copied();
                assert!(narrowest_m.fold(f64::INFINITY, f64::min) > 0.6, "{} {seed} is too narrow", family.name);
            }
        }
    }
}
