//! Named flights.

use crate::course::{bent, half_widths};
use crate::lidar::Lidar;
use crate::mine::Mine;
use crate::network::{Network, Point};
use crate::noise::generator;
use crate::presets;
use crate::scene::Flight;
use crate::surface::{Surface, Texture};
use crate::vehicle::{Handling, Vehicle};

/// A flight with a name.
#[derive(Clone, Copy, Debug)]
pub struct Scenario {
    /// Name of the scenario.
    pub name: &'static str,
    /// Description in one line.
    pub doc: &'static str,
    /// Starts the flight of a seed.
    pub fly: fn(seed: u64) -> Flight,
}

/// All scenarios.
pub fn scenarios() -> &'static [Scenario] {
    &[
        Scenario { name: "tee", doc: "along a tunnel 3.5 m wide, into a T junction, and left", fly: tee },
        Scenario {
            name: "tunnel",
            doc: "from end to end of a tunnel of 3.5 m x 3 m with branches",
            fly: presets::tunnel,
        },
        Scenario {
            name: "mine",
            doc: "through a mine of 6 m x 4 m with many junctions and wet walls",
            fly: presets::mine,
        },
        Scenario { name: "loops", doc: "through such a mine, back to places seen before", fly: presets::loops },
        Scenario {
            name: "lookalike",
            doc: "through straight corridors of one length and width, back to places seen before",
            fly: presets::lookalike,
        },
        Scenario { name: "close", doc: "through narrow tunnels that meet every 10 m, many times", fly: presets::close },
        Scenario { name: "chambers", doc: "as loops, with chambers where tunnels meet", fly: presets::chambers },
        Scenario { name: "pillars", doc: "as loops, with many pillars", fly: presets::pillars },
    ]
}

fn tee(seed: u64) -> Flight {
    let mut rng = generator(seed, "tee");
    let mut network = Network::new(3.0);
    let start = network.add_node(Point::new(-20.0, 0.0));
    let mut add = |network: &mut Network, from: usize, heading_rad: f64, length_m: f64, bend_rad_per_m: f64| {
        let line = bent(network.nodes[from].position_m, heading_rad, length_m, bend_rad_per_m);
        let widths = half_widths(line.len(), 1.75, 0.04, &mut rng);
        network.add_branch(from, line, widths)
    };
    let tee = add(&mut network, start, 0.1, 34.0, -0.006);
    let left = add(&mut network, tee, 1.5, 25.0, 0.01);
    add(&mut network, tee, -1.6, 25.0, 0.008);
    let texture = Texture { bump_sd_m: 0.06, bump_length_m: 0.8, ..Texture::SMOOTH };
    let surface = Surface::new(&network, &texture, seed);
    let route_m: Vec<Point> = network.route_m(&[start, tee, left]).into_iter().skip(40).take(40).collect();
    let lidar = Lidar { loss: 0.01, ..Lidar::CLEAN };
    let vehicle = Vehicle::new(Handling { speed_m_s: 1.2, ..Handling::default() }, route_m, lidar.sweep_s, seed);
    Flight::new(Mine::new(network, surface), lidar, vehicle, seed)
}
