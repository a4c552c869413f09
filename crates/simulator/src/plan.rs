//! The plan of a mine, and a flight through all of it.

use std::collections::{BTreeMap, BTreeSet};

use serde::Deserialize;

use crate::course::swaying;
use crate::lidar::Lidar;
use crate::mine::Mine;
use crate::network::{Network, Point};
use crate::scene::Flight;
use crate::surface::{Surface, Texture};
use crate::vehicle::{Handling, Vehicle};
use crate::world::World;

/// Height from floor to roof, m.
const HEIGHT_M: f64 = 3.0;
/// Places that are nearer are one, m.
const LEAST_LENGTH_M: f64 = 0.01;
/// Coordinates are within this, m, and a mine covers no more than this, m²: it is kept as cells of 0.5 m.
const LARGEST_M: f64 = 1e5;
const LARGEST_M2: f64 = 25e6;
/// The vehicle turns back this far from the face of a dead end, m.
const BEFORE_FACE_M: f64 = 2.5;
/// It turns on the spot towards a way that is farther to the side or behind.
const ON_THE_SPOT_RAD: f64 = 1.0;
/// It stays this share of the width from the middle (standard deviation), at most 0.2 m.
const OFFSET_SHARE: f64 = 0.05;

/// A mine as its surveyor draws it: places, and the ways between them.
///
/// ```
/// use crosscut_simulator::Plan;
///
/// let plan = Plan::from_json(
///     r#"{"nodes": [{"id": "portal", "x_m": 0, "y_m": 0}, {"id": 1, "x_m": 30, "y_m": 0}, {"id": 2, "x_m": 30, "y_m": 20}],
///         "edges": [{"from": "portal", "to": 1, "width_m": 3.5}, {"from": 1, "to": 2, "width_m": 3, "via_m": [[34, 10]]}],
///         "roughness_m": 0.1}"#,
/// )?;
/// assert_eq!(plan.fly(1)?.mine().network().nodes.len(), 4, "a bend is a node too");
/// # Ok::<(), crosscut_simulator::PlanError>(())
/// ```
#[derive(Clone, Debug, Deserialize)]
pub struct Plan {
    nodes: Vec<PlanNode>,
    edges: Vec<PlanEdge>,
    /// Standard deviation of the bumps of the walls, m.
    #[serde(default = "default_roughness_m")]
    roughness_m: f64,
    /// Where the vehicle starts.
    start: Option<PlanStart>,
}

fn default_roughness_m() -> f64 {
    0.1
}

#[derive(Clone, Debug, Deserialize)]
struct PlanNode {
    id: Name,
    x_m: f64,
    y_m: f64,
}

#[derive(Clone, Debug, Deserialize)]
struct PlanEdge {
    from: Name,
    to: Name,
    width_m: f64,
    #[serde(default)]
    via_m: Vec<[f64; 2]>,
}

#[derive(Clone, Debug, Deserialize)]
struct PlanStart {
    node: Name,
    /// The node that the vehicle faces, at the other end of an edge.
    towards: Option<Name>,
}

/// A number or a word.
#[derive(Clone, Debug, Deserialize, PartialEq, Eq, PartialOrd, Ord)]
#[serde(untagged)]
enum Name {
    Number(i64),
    Word(String),
}

impl std::fmt::Display for Name {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Number(number) => write!(f, "{number}"),
            Self::Word(word) => write!(f, "{word:?}"),
        }
    }
}

/// Why a plan cannot be flown.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PlanError {
    /// The text has another form.
    #[error("it is no plan: {0}")]
    Form(#[from] serde_json::Error),
    /// Two nodes have one id.
    #[error("two nodes have the id {0}")]
    Twice(String),
    /// An edge or the start names a node that is not there.
    #[error("{what} names the node {node}, which is not there")]
    NoNode {
        /// What names it.
        what: String,
        /// Its node.
        node: String,
    },
    /// The start and the node that the vehicle faces are no ends of one edge.
    #[error("the start is towards node {towards}, to which no edge leads from node {node}")]
    NoWay {
        /// The node of the start.
        node: String,
        /// The node that the vehicle faces.
        towards: String,
    },
    /// A number is not usable.
    #[error("{what} is {value}; it must be {expected}")]
    Number {
        /// Which number.
        what: String,
        /// What it is.
        value: f64,
        /// What it may be.
        expected: &'static str,
    },
    /// There is nothing to fly through.
    #[error("it has no edges")]
    Empty,
    /// The mine is not in one piece.
    #[error("node {node} cannot be reached from node {from}")]
    NotReached {
        /// The first of those nodes.
        node: String,
        /// Where the flight starts.
        from: String,
    },
}

impl Plan {
    /// Reads a plan: `{"nodes":[{"id","x_m","y_m"}],"edges":[{"from","to","width_m","via_m":[[x,y],...]}],
    /// "roughness_m":0.1,"start":{"node","towards"}}`. Ids are numbers or words.
    ///
    /// # Errors
    /// When the text has another form.
    pub fn from_json(text: &str) -> Result<Self, PlanError> {
        Ok(serde_json::from_str(text)?)
    }

    /// A flight through every tunnel, from the start of the plan on, else from the first dead end (or the first node, if there is
    /// none). At each place the vehicle takes the nearest tunnel that it has not flown through. It turns back before the faces of dead ends.
    ///
    /// # Errors
    /// When ids or numbers are not usable, or the mine is not in one piece.
    pub fn fly(&self, seed: u64) -> Result<Flight, PlanError> {
        let (network, start) = self.checked()?;
        let route_m = tour(&network, start).map_err(|node| self.not_reached(node, start))?;
        let (texture, lidar) = (self.texture(), Lidar::ORDINARY);
        let narrowest_m = self.edges.iter().map(|edge| edge.width_m).fold(f64::INFINITY, f64::min);
        let handling = Handling {
            turn_on_spot_rad: ON_THE_SPOT_RAD,
            offset_sd_m: (OFFSET_SHARE * narrowest_m).min(Handling::default().offset_sd_m),
            ..Handling::default()
        };
        let surface = Surface::new(&network, &texture, seed);
        let vehicle = Vehicle::new(handling, route_m, lidar.sweep_s, seed);
        Ok(Flight::new(Mine::new(network, surface), lidar, vehicle, seed))
    }

    /// The mine with a vehicle at the start of the plan, else before the face of the first dead end, or at the first node if there
    /// is none. At a node that is no dead end it faces the way that the plan names, else the first.
    ///
    /// # Errors
    /// As [`Plan::fly`].
    pub fn world(&self, seed: u64) -> Result<World, PlanError> {
        let (network, start) = self.checked()?;
        tour(&network, start).map_err(|node| self.not_reached(node, start))?;
        let towards_m = self.faced_m()?;
        let mut world = World::new(network, &self.texture(), Lidar::ORDINARY, start, seed);
        if let Some(towards) = towards_m.map(|towards_m| towards_m - world.start.position_m) {
            world.start.heading_rad = towards.y.atan2(towards.x);
        }
        Ok(world)
    }

    /// The place that the vehicle faces at the start, if the plan names one: the next one along an edge.
    fn faced_m(&self) -> Result<Option<Point>, PlanError> {
        let Some(PlanStart { node, towards: Some(towards) }) = &self.start else { return Ok(None) };
        let end_m = self.nodes.iter().find(|of| of.id == *towards).map(|of| [of.x_m, of.y_m]);
        let next_m = self.edges.iter().find_map(|PlanEdge { from, to, via_m, .. }| match (from, to) {
            (a, b) if (a, b) == (node, towards) => via_m.first().copied().or(end_m),
            (a, b) if (b, a) == (node, towards) => via_m.last().copied().or(end_m),
            _ => None,
        });
        let no_way = || PlanError::NoWay { node: node.to_string(), towards: towards.to_string() };
        next_m.map(|[x_m, y_m]| Some(Point::new(x_m, y_m))).ok_or_else(no_way)
    }

    /// The tunnels, and the node that a flight starts at.
    fn checked(&self) -> Result<(Network, usize), PlanError> {
        let network = self.network()?;
        let of_degree =
            |is_right: fn(usize) -> bool| (0..self.nodes.len()).find(|&node| is_right(network.degree(node)));
        let first =
            of_degree(|degree| degree == 1).or_else(|| of_degree(|degree| degree > 0)).ok_or(PlanError::Empty)?;
        let Some(PlanStart { node, .. }) = &self.start else { return Ok((network, first)) };
        let start = self.nodes.iter().position(|of| of.id == *node);
        let start = start.ok_or_else(|| PlanError::NoNode { what: "the start".to_owned(), node: node.to_string() })?;
        Ok((network, start))
    }

    fn not_reached(&self, node: usize, from: usize) -> PlanError {
        let [node, from] = [node, from].map(|node| self.nodes[node].id.to_string());
        PlanError::NotReached { node, from }
    }

    fn texture(&self) -> Texture {
        Texture { bump_sd_m: self.roughness_m, bump_length_m: 0.8, ..Texture::SMOOTH }
    }

    /// The tunnels. The first nodes are those of the plan; bends along an edge are nodes of two tunnels.
    fn network(&self) -> Result<Network, PlanError> {
        let mut network = Network::new(HEIGHT_M);
        let mut by_name = BTreeMap::new();
        check("roughness_m", self.roughness_m, (0.0..=1.0).contains(&self.roughness_m), "0 to 1 m")?;
        let place = |what: &dyn Fn() -> String, [x_m, y_m]: [f64; 2]| {
            for value in [x_m, y_m] {
                check(&what(), value, value.abs() <= LARGEST_M, "within 100 km of the origin")?;
            }
            Ok::<_, PlanError>(Point::new(x_m, y_m))
        };
        for PlanNode { id, x_m, y_m } in &self.nodes {
            let node = network.add_node(place(&|| format!("a coordinate of node {id}"), [*x_m, *y_m])?);
            if by_name.insert(id.clone(), node).is_some() {
                return Err(PlanError::Twice(id.to_string()));
            }
        }
        for (edge, PlanEdge { from, to, width_m, via_m }) in self.edges.iter().enumerate() {
            check(&format!("width_m of edge {edge}"), *width_m, (0.5..=100.0).contains(width_m), "0.5 to 100 m")?;
            let node = |name: &Name| {
                let node = by_name.get(name).copied();
                node.ok_or_else(|| PlanError::NoNode { what: format!("edge {edge}"), node: name.to_string() })
            };
            let (from, to) = (node(from)?, node(to)?);
            let mut last = from;
            for via_m in via_m {
                let via_m = place(&|| format!("a coordinate of via_m of edge {edge}"), *via_m)?;
                if (via_m - network.nodes[last].position_m).norm() >= LEAST_LENGTH_M {
                    let next = network.add_node(via_m);
                    straight(&mut network, last, next, *width_m);
                    last = next;
                }
            }
            let length_m = (network.nodes[to].position_m - network.nodes[last].position_m).norm();
            check(&format!("the length of edge {edge}"), length_m, length_m >= LEAST_LENGTH_M, "1 cm or more")?;
            straight(&mut network, last, to, *width_m);
        }
        let positions_m = || network.nodes.iter().map(|node| node.position_m);
        let extent_m = positions_m().reduce(|a, b| a.sup(&b)).zip(positions_m().reduce(|a, b| a.inf(&b)));
        let area_m2 = extent_m.map_or(0.0, |(high, low)| (high - low).product());
        check("the area of the mine in km²", 1e-6 * area_m2, area_m2 <= LARGEST_M2, "25 or less")?;
        Ok(network)
    }
}

fn check(what: &str, value: f64, is_right: bool, expected: &'static str) -> Result<(), PlanError> {
    if is_right { Ok(()) } else { Err(PlanError::Number { what: what.to_owned(), value, expected }) }
}

/// Adds a straight tunnel.
fn straight(network: &mut Network, from: usize, to: usize, width_m: f64) {
    let [from_m, to_m] = [from, to].map(|node| network.nodes[node].position_m);
    let line = swaying(from_m, to_m, 0.0);
    let half_widths_m = vec![0.5 * width_m; line.len()];
    network.add_tunnel(from, to, line, half_widths_m);
}

/// A route through every tunnel: at each node on to the nearest tunnel that was not taken. The error is the first end of the
/// first tunnel that cannot be reached.
fn tour(network: &Network, start: usize) -> Result<Vec<Point>, usize> {
    let mut left: BTreeSet<usize> = (0..network.tunnels.len()).collect();
    let (mut at, mut route_m) = (start, Vec::new());
    while let Some(&first) = left.first() {
        for tunnel in way_to_nearest(network, at, &left).ok_or(network.tunnels[first].ends[0])? {
            left.remove(&tunnel);
            let line = &network.tunnels[tunnel].centreline_m;
            let is_forward = network.tunnels[tunnel].ends[0] == at;
            at = network.tunnels[tunnel].ends[usize::from(is_forward)];
            if is_forward { route_m.extend(line) } else { route_m.extend(line.iter().rev()) }
        }
    }
    route_m.dedup();
    let faces: Vec<Point> = (0..network.nodes.len())
        .filter(|&node| network.degree(node) == 1)
        .map(|node| network.nodes[node].position_m)
        .collect();
    let is_clear = |point: &Point| faces.iter().all(|face| (point - face).norm() >= BEFORE_FACE_M);
    let clear: Vec<Point> = route_m.iter().copied().filter(is_clear).collect();
    // Of a mine that is shorter than that, all is flown.
    Ok(if clear.len() >= 2 { clear } else { route_m })
}

/// The tunnels from a node up to and with the nearest one that is left.
fn way_to_nearest(network: &Network, from: usize, left: &BTreeSet<usize>) -> Option<Vec<usize>> {
    // Dijkstra's shortest ways; mines are small enough to look through all nodes for the nearest.
    let mut ways: BTreeMap<usize, (f64, Vec<usize>)> = BTreeMap::from([(from, (0.0, Vec::new()))]);
    let mut done = BTreeSet::new();
    loop {
        let open = ways.iter().filter(|(node, _)| !done.contains(*node));
        let (&node, (way_m, way)) = open.min_by(|(_, a), (_, b)| a.0.total_cmp(&b.0))?;
        let (way_m, way) = (*way_m, way.clone());
        done.insert(node);
        let touching = (0..network.tunnels.len()).filter(|&tunnel| network.tunnels[tunnel].ends.contains(&node));
        for tunnel in touching {
            let [a, b] = network.tunnels[tunnel].ends;
            let to = if a == node { b } else { a };
            let on: Vec<usize> = way.iter().copied().chain([tunnel]).collect();
            if left.contains(&tunnel) {
                return Some(on);
            }
            let to_m = way_m + network.tunnels[tunnel].length_m();
            if ways.get(&to).is_none_or(|(known_m, _)| to_m < *known_m) {
                ways.insert(to, (to_m, on));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    fn plan(edges: &str) -> Plan {
        let text = format!(
            r#"{{"nodes": [{{"id": 0, "x_m": 0, "y_m": 0}}, {{"id": "a", "x_m": 20, "y_m": 0}}, {{"id": 2, "x_m": 20, "y_m": 15}},
                {{"id": 3, "x_m": 40, "y_m": 0}}], "edges": [{edges}]}}"#
        );
        Plan::from_json(&text).expect("a plan")
    }

    const ALL: &str = r#"{"from": 0, "to": "a", "width_m": 4}, {"from": "a", "to": 2, "width_m": 3},
        {"from": "a", "to": 3, "width_m": 3, "via_m": [[30, -5]]}, {"from": 2, "to": 3, "width_m": 3, "via_m": [[38, 15]]}"#;

    #[test]
    fn a_flight_passes_every_tunnel_and_keeps_clear_of_the_walls() {
        let flight = plan(ALL).fly(3).expect("a flight");
        let mine = flight.mine().clone();
        let places: Vec<Point> = flight.filter_map(|scene| scene.pose.map(|pose| pose.position_m)).collect();
        for tunnel in &mine.network().tunnels {
            let middle = tunnel.centreline_m[tunnel.centreline_m.len() / 2];
            let nearest_m = places.iter().map(|place| (place - middle).norm()).fold(f64::INFINITY, f64::min);
            assert!(nearest_m < 1.0, "{nearest_m} m from the tunnel at {middle}");
        }
        let clear_m = places.iter().map(|place| mine.surface().clearance_m(*place, 9.0)).fold(f64::INFINITY, f64::min);
        assert!(clear_m > 0.4, "{clear_m}");
    }

    #[test]
    fn the_vehicle_turns_back_before_a_face() {
        let flight = plan(
            r#"{"from": 0, "to": "a", "width_m": 2.5}, {"from": "a", "to": 2, "width_m": 2.5}, {"from": "a", "to": 3, "width_m": 2.5}"#,
        );
        let flight = flight.fly(1).expect("a flight");
        let mine = flight.mine().clone();
        let places: Vec<Point> = flight.filter_map(|scene| scene.pose.map(|pose| pose.position_m)).collect();
        let clear_m = places.iter().map(|place| mine.surface().clearance_m(*place, 9.0)).fold(f64::INFINITY, f64::min);
        assert!(clear_m > 0.3, "{clear_m}");
        let last = places.last().expect("places");
        assert!((last - Point::new(40.0, 0.0)).norm() < 6.0, "the last tunnel is flown to its end: {last}");
    }

    #[test]
    fn a_plan_that_cannot_be_flown_says_why() {
        for (edges, words) in [
            (r#"{"from": 0, "to": 7, "width_m": 3}"#, "edge 0 names the node 7"),
            (r#"{"from": 0, "to": "b", "width_m": 3}"#, "the node \"b\""),
            (r#"{"from": 0, "to": "a", "width_m": -3}"#, "width_m of edge 0 is -3"),
            (r#"{"from": 0, "to": 0, "width_m": 3}"#, "the length of edge 0 is 0"),
            (r#"{"from": 0, "to": "a", "width_m": 3, "via_m": [[9e4, 9e4]]}"#, "the area of the mine"),
            ("", "no edges"),
            (r#"{"from": 0, "to": "a", "width_m": 3}, {"from": 2, "to": 3, "width_m": 3}"#, "node 2 cannot be reached"),
        ] {
            let error = plan(edges).fly(1).expect_err("cannot be flown").to_string();
            assert!(error.contains(words), "{error}");
        }
        assert!(Plan::from_json("{}").is_err());
    }

    /// The plan of [`ALL`] with a start.
    fn starting(start: &str) -> Plan {
        Plan { start: Some(serde_json::from_str(start).expect("a start")), ..plan(ALL) }
    }

    #[test]
    fn a_vehicle_starts_where_the_plan_says_and_faces_what_it_says() {
        for (start, at_m, heading_rad) in [
            (r#"{"node": 2, "towards": "a"}"#, [20.0, 15.0], -0.5 * PI),
            (r#"{"node": 2, "towards": 3}"#, [20.0, 15.0], 0.0),
            (r#"{"node": 3, "towards": "a"}"#, [40.0, 0.0], (-5f64).atan2(-10.0)),
            (r#"{"node": 0}"#, [3.0, 0.0], 0.0),
        ] {
            let plan = starting(start);
            let world = plan.world(1).expect("a world");
            assert!((world.start.position_m - Point::from(at_m)).norm() < 0.5, "{start}: {:?}", world.start);
            assert!((world.start.heading_rad - heading_rad).abs() < 0.05, "{start}: {:?}", world.start);
            let first = plan.fly(1).expect("a flight").next().and_then(|scene| scene.pose).expect("a scene");
            assert!((first.position_m - Point::from(at_m)).norm() < 1.0, "{start}: {first:?}");
        }
        for (start, words) in [
            (r#"{"node": 9}"#, "the start names the node 9"),
            (r#"{"node": 0, "towards": 3}"#, "the start is towards node 3, to which no edge leads from node 0"),
        ] {
            let error = starting(start).world(1).expect_err("no start").to_string();
            assert!(error.contains(words), "{error}");
        }
    }
}
