//! Procedural mines, a different one for each seed, and flights through them.

use std::f64::consts::{PI, TAU};

use rand::RngExt;
use rand::seq::SliceRandom;

use crate::course::{bent, half_widths, swaying};
use crate::lidar::Lidar;
use crate::mine::Mine;
use crosscut_stage::unit;

use crate::network::{Disc, Network, Point, left_of};
use crate::noise::{Generator, generator};
use crate::scene::Flight;
use crate::surface::{Surface, Texture};
use crate::vehicle::{Handling, Vehicle};

/// A flight through a tunnel 3.5 m wide and 3 m high with branches to both sides, from one dead end to the other.
pub(crate) fn tunnel(seed: u64) -> Flight {
    let (network, route) = drive(&mut generator(seed, "tunnel"));
    let texture = Texture { bump_sd_m: 0.12, bump_length_m: 0.8, ..Texture::SMOOTH };
    fly(network, &route, texture, Lidar::ORDINARY, seed)
}

/// A flight through a mine of tunnels 6 m wide and 4 m high that cross many times, its walls wet in places.
pub(crate) fn mine(seed: u64) -> Flight {
    through_rooms(&Rooms { steps: 9, ..Rooms::MINE }, seed)
}

/// A longer flight through such a mine, which comes back to places that it has seen before.
pub(crate) fn loops(seed: u64) -> Flight {
    through_rooms(&Rooms::MINE, seed)
}

/// A flight through straight corridors of one length and width, which meet at right angles.
pub(crate) fn lookalike(seed: u64) -> Flight {
    let rooms = Rooms {
        spacing_m: 22.0,
        disorder: 0.0,
        half_width_m: [1.74, 1.76],
        swell: 0.0,
        spurs: 0.0,
        chambers: 0,
        alcoves: 0,
        pillars: 0,
        bump_sd_m: 0.06,
        wet_share: 0.0,
        ..Rooms::MINE
    };
    through_rooms(&rooms, seed)
}

/// A flight through tunnels 2.4 m wide that meet every 10 m.
pub(crate) fn close(seed: u64) -> Flight {
    let rooms = Rooms {
        steps: 50,
        spacing_m: 10.0,
        disorder: 0.25,
        half_width_m: [1.1, 1.3],
        spurs: 0.0,
        chambers: 0,
        alcoves: 0,
        pillars: 0,
        bump_sd_m: 0.08,
        wet_share: 0.0,
        ..Rooms::MINE
    };
    through_rooms(&rooms, seed)
}

/// A flight through a mine with a chamber in every third place.
pub(crate) fn chambers(seed: u64) -> Flight {
    through_rooms(&Rooms { chambers: 8, pillars: 0, ..Rooms::MINE }, seed)
}

/// A flight through a mine with many pillars.
pub(crate) fn pillars(seed: u64) -> Flight {
    through_rooms(&Rooms { pillars: 60, ..Rooms::MINE }, seed)
}

/// What a net of tunnels looks like, and how far the flight through it goes.
struct Rooms {
    /// Tunnels of the route.
    steps: usize,
    spacing_m: f64,
    /// How far places and tunnels stray from a square grid, 0 to 1.
    disorder: f64,
    half_width_m: [f64; 2],
    /// Variation of the width along a tunnel, as a share.
    swell: f64,
    /// Share of the places with a dead end.
    spurs: f64,
    /// Chambers: at every third place of the route, from the third on.
    chambers: usize,
    alcoves: usize,
    /// Pillars that are drawn; those without room are left out.
    pillars: usize,
    bump_sd_m: f64,
    wet_share: f64,
}

impl Rooms {
    const MINE: Self = Self {
        steps: 24,
        spacing_m: 27.0,
        disorder: 1.0,
        half_width_m: [2.7, 3.3],
        swell: 0.08,
        spurs: 0.6,
        chambers: 1,
        alcoves: 12,
        pillars: 10,
        bump_sd_m: 0.15,
        wet_share: 0.25,
    };
}

fn through_rooms(rooms: &Rooms, seed: u64) -> Flight {
    let (network, route) = rooms.network(&mut generator(seed, "mine"));
    fly(network, &route, rooms.texture(), Lidar::IN_WET_MINE, seed)
}

fn fly(network: Network, route: &[usize], texture: Texture, lidar: Lidar, seed: u64) -> Flight {
    let surface = Surface::new(&network, &texture, seed);
    // The flight starts away from the face if the route begins at a dead end.
    let route_m: Vec<Point> = network.route_m(route).into_iter().skip(4).collect();
    let vehicle = Vehicle::new(Handling::default(), route_m, lidar.sweep_s, seed);
    Flight::new(Mine::new(network, surface), lidar, vehicle, seed)
}

/// A long drive with junctions every 14 to 24 m. The ends of short branches are visible, those of long ones are not.
pub(crate) fn drive(rng: &mut Generator) -> (Network, Vec<usize>) {
    const HALF_WIDTH_M: f64 = 1.75;
    let mut network = Network::new(3.0);
    let mut route = vec![network.add_node(Point::origin())];
    let mut heading_rad = 0.0;
    for _ in 0..7 {
        let from = route[route.len() - 1];
        let length_m = rng.random_range(14.0..24.0);
        // The drive is curved but keeps its main direction, so that it never crosses itself.
        let bend_rad_per_m = (rng.random_range(-0.5..0.5) - 0.5 * heading_rad) / length_m;
        let line = bent(network.nodes[from].position_m, heading_rad, length_m, bend_rad_per_m);
        heading_rad += bend_rad_per_m * length_m;
        let widths = half_widths(line.len(), HALF_WIDTH_M, 0.1, rng);
        route.push(network.add_branch(from, line, widths));
    }
    let mut side = if rng.random_bool(0.5) { 1.0 } else { -1.0 };
    for &node in &route[1..route.len() - 1] {
        // Branches alternate between left and right; some nodes have both.
        let sides = if rng.random_bool(0.25) { vec![side, -side] } else { vec![side] };
        for side in sides {
            add_spur(&mut network, node, HALF_WIDTH_M, |rng| side * rng.random_range(0.9..2.2), rng);
        }
        side = -side;
    }
    add_alcoves(&mut network, 5, rng);
    (network, route)
}

/// The rock of a mine.
pub(crate) fn rock_of_mine() -> Texture {
    Rooms::MINE.texture()
}

/// The net of a mine, and a route of `steps` tunnels through it.
pub(crate) fn rooms(steps: usize, rng: &mut Generator) -> (Network, Vec<usize>) {
    Rooms { steps, ..Rooms::MINE }.network(rng)
}

impl Rooms {
    fn texture(&self) -> Texture {
        Texture { bump_sd_m: self.bump_sd_m, bump_length_m: 1.0, wet_share: self.wet_share, wet_length_m: 1.5 }
    }

    /// A net of tunnels around blocks of rock, and a route through it.
    fn network(&self, rng: &mut Generator) -> (Network, Vec<usize>) {
        const SIDE: usize = 4;
        let mut network = Network::new(4.0);
        for index in 0..SIDE * SIDE {
            let mut jitter_m = || self.disorder * rng.random_range(-4.0..4.0);
            let [x, y] = [index % SIDE, index / SIDE].map(|at| at as f64 * self.spacing_m + jitter_m());
            network.add_node(Point::new(x, y));
        }
        for (from, to) in grid_edges(SIDE, rng) {
            let (from_m, to_m) = (network.nodes[from].position_m, network.nodes[to].position_m);
            let line = swaying(from_m, to_m, self.disorder * rng.random_range(-1.5..1.5));
            let half_width_m = rng.random_range(self.half_width_m[0]..self.half_width_m[1]);
            let widths = half_widths(line.len(), half_width_m, self.swell, rng);
            network.add_tunnel(from, to, line, widths);
        }
        let route = wander(&network, self.steps, rng);
        for node in 0..SIDE * SIDE {
            if rng.random_bool(self.spurs) {
                add_spur(&mut network, node, self.half_width_m[0], |rng| rng.random_range(-PI..PI), rng);
            }
        }
        for &node in route.iter().skip(2).step_by(3).take(self.chambers) {
            network.nodes[node].chamber_radius_m = 6.0;
        }
        add_alcoves(&mut network, self.alcoves, rng);
        add_pillars(&mut network, self.pillars, rng);
        (network, route)
    }
}

/// Edges of a square grid: all on the rim, and most of the inner ones. Every node has at least two.
pub(crate) fn grid_edges(side: usize, rng: &mut Generator) -> Vec<(usize, usize)> {
    let across = (0..side).flat_map(|row| (1..side).map(move |column| (row * side + column - 1, row * side + column)));
    let up = (1..side).flat_map(|row| (0..side).map(move |column| ((row - 1) * side + column, row * side + column)));
    let mut edges: Vec<(usize, usize)> = across.chain(up).collect();
    let on_rim = |node: usize| [0, side - 1].contains(&(node % side)) || [0, side - 1].contains(&(node / side));
    edges.shuffle(rng);
    for edge in edges.clone() {
        let degree = |node: usize| edges.iter().filter(|(a, b)| *a == node || *b == node).count();
        if !(on_rim(edge.0) && on_rim(edge.1)) && degree(edge.0) > 2 && degree(edge.1) > 2 && rng.random_bool(0.3) {
            edges.retain(|&other| other != edge);
        }
    }
    edges
}

/// A walk over `steps` tunnels that never turns back and prefers unused tunnels.
fn wander(network: &Network, steps: usize, rng: &mut Generator) -> Vec<usize> {
    let mut route = vec![rng.random_range(0..network.nodes.len())];
    let mut uses = vec![0; network.tunnels.len()];
    for _ in 0..steps {
        let (at, before) = (route[route.len() - 1], route.len().checked_sub(2).map(|i| route[i]));
        let mut ways: Vec<(usize, usize)> = (0..network.tunnels.len())
            .filter_map(|tunnel| match network.tunnels[tunnel].ends {
                [a, b] if a == at => Some((tunnel, b)),
                [a, b] if b == at => Some((tunnel, a)),
                _ => None,
            })
            .filter(|&(_, to)| Some(to) != before)
            .collect();
        ways.shuffle(rng);
        let Some(&(tunnel, to)) = ways.iter().min_by_key(|(tunnel, _)| uses[*tunnel]) else { break };
        uses[tunnel] += 1;
        route.push(to);
    }
    route
}

/// Adds a dead end at a node, in the direction of the node's first tunnel turned by `turn_rad`, if a few draws find room.
pub(crate) fn add_spur(
    network: &mut Network,
    node: usize,
    half_width_m: f64,
    turn_rad: impl Fn(&mut Generator) -> f64,
    rng: &mut Generator,
) {
    let from_m = network.nodes[node].position_m;
    let ways = headings_rad(network, node);
    for _ in 0..8 {
        let heading_rad = ways[0] + PI + turn_rad(rng);
        let length_m = rng.random_range(6.0..30.0);
        let line = bent(from_m, heading_rad, length_m, rng.random_range(-0.015..0.015));
        let apart = |way: &f64| crosscut_stage::wrap_angle_rad(heading_rad - way).abs() > 0.85;
        // Two tunnels 0.85 rad apart have a distance of 2·d·sin(0.425) at distance d: they are separate from d = 4 half
        // widths.
        if ways.iter().all(apart) && network.has_room_for(node, &line, half_width_m, 1.5) {
            let widths = half_widths(line.len(), half_width_m, 0.08, rng);
            network.add_branch(node, line, widths);
            return;
        }
    }
}

/// Directions of the tunnels at a node, in the order of the tunnels.
pub(crate) fn headings_rad(network: &Network, node: usize) -> Vec<f64> {
    let mut headings = Vec::new();
    for tunnel in &network.tunnels {
        let n = tunnel.centreline_m.len();
        let outward = [tunnel.tangent(0), -tunnel.tangent(n - 1)];
        headings.extend((0..2).filter(|&end| tunnel.ends[end] == node).map(|end| outward[end].y.atan2(outward[end].x)));
    }
    headings
}

/// Adds shallow pockets to the walls, away from the junctions.
fn add_alcoves(network: &mut Network, count: usize, rng: &mut Generator) {
    for _ in 0..count {
        let Some((tunnel, at)) = mid_tunnel(network, 6.0, rng) else { continue };
        let tunnel = &network.tunnels[tunnel];
        let side = if rng.random_bool(0.5) { 1.0 } else { -1.0 };
        let centre_m = tunnel.centreline_m[at] + left_of(tunnel.tangent(at)) * (side * tunnel.half_widths_m[at]);
        network.alcoves.push(Disc { centre_m, radius_m: rng.random_range(0.6..1.0) });
    }
}

/// Adds pillars beside the centrelines, and one in every chamber, all with room to pass on both sides.
pub(crate) fn add_pillars(network: &mut Network, count: usize, rng: &mut Generator) {
    for _ in 0..count {
        let Some((tunnel, at)) = mid_tunnel(network, 4.0, rng) else { continue };
        let tunnel = &network.tunnels[tunnel];
        let radius_m = rng.random_range(0.25..0.45);
        // The pillar is equally far from the wall and from a vehicle on the centreline.
        let side_m = (0.5 * tunnel.half_widths_m[at] + 0.1) * if rng.random_bool(0.5) { 1.0 } else { -1.0 };
        let centre_m = tunnel.centreline_m[at] + left_of(tunnel.tangent(at)) * side_m;
        if network.pillars.iter().all(|other| (other.centre_m - centre_m).norm() > 4.0) {
            network.pillars.push(Disc { centre_m, radius_m });
        }
    }
    for node in 0..network.nodes.len() {
        let radius_m = network.nodes[node].chamber_radius_m;
        if radius_m > 0.0 {
            // The pillar is in the middle of the widest gap between the tunnels of the chamber.
            let mut ways = headings_rad(network, node);
            ways.sort_by(f64::total_cmp);
            let gap = |i: usize| (ways[(i + 1) % ways.len()] - ways[i]).rem_euclid(TAU);
            let widest = (0..ways.len()).max_by(|&a, &b| gap(a).total_cmp(&gap(b))).unwrap_or(0);
            let towards = unit(ways[widest] + 0.5 * gap(widest));
            let centre_m = network.nodes[node].position_m + towards * (0.6 * radius_m);
            network.pillars.push(Disc { centre_m, radius_m: 0.7 });
        }
    }
}

/// A tunnel, and a point of its centreline that is farther than `clear_m` from both its nodes.
fn mid_tunnel(network: &Network, clear_m: f64, rng: &mut Generator) -> Option<(usize, usize)> {
    let tunnel = rng.random_range(0..network.tunnels.len());
    let line = &network.tunnels[tunnel].centreline_m;
    let at = rng.random_range(0..line.len());
    let clear = |end: &Point| (line[at] - end).norm() > clear_m;
    (clear(&line[0]) && clear(&line[line.len() - 1])).then_some((tunnel, at))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::network::Tunnel;

    #[test]
    fn tunnels_meet_only_at_their_nodes() {
        for seed in 0..40 {
            for (network, _) in
                [drive(&mut generator(seed, "tunnel")), Rooms::MINE.network(&mut generator(seed, "mine"))]
            {
                for (a, tunnel) in network.tunnels.iter().enumerate() {
                    for other in &network.tunnels[..a] {
                        assert_apart(&network, [tunnel, other], seed);
                    }
                }
            }
        }
    }

    /// Fails unless there is rock between two tunnels beyond 5 half widths of the nodes that they share.
    fn assert_apart(network: &Network, pair: [&Tunnel; 2], seed: u64) {
        let shared: Vec<Point> = pair[0]
            .ends
            .into_iter()
            .filter(|end| pair[1].ends.contains(end))
            .map(|node| network.nodes[node].position_m)
            .collect();
        for (p, p_half_m) in pair[0].centreline_m.iter().zip(&pair[0].half_widths_m) {
            if shared.iter().any(|node| (p - node).norm() < 5.0 * p_half_m) {
                continue;
            }
            for (q, q_half_m) in pair[1].centreline_m.iter().zip(&pair[1].half_widths_m) {
                assert!((p - q).norm() > p_half_m + q_half_m + 0.5, "seed {seed}: tunnels at {p} and {q} run together");
            }
        }
    }

    #[test]
    fn pillars_leave_room_to_pass_on_both_sides() {
        for seed in 0..40 {
            let (network, _) = Rooms::MINE.network(&mut generator(seed, "mine"));
            let bare = Network { pillars: Vec::new(), ..network.clone() };
            let surface = Surface::new(&bare, &Texture::SMOOTH, 0);
            for pillar in &network.pillars {
                let gap_m = surface.clearance_m(pillar.centre_m, 10.0) - pillar.radius_m;
                assert!(gap_m > 0.6, "seed {seed}: {gap_m} m between the pillar at {} and the wall", pillar.centre_m);
            }
        }
    }
}
