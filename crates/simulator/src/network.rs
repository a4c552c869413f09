//! A mine as a graph: tunnels with a centreline and a width along it, which meet at nodes; chambers, alcoves, pillars.

use nalgebra::{Point2, Vector2};

/// Points in the plane of the mine, metres.
pub type Point = Point2<f64>;
/// Directions and offsets in the plane of the mine.
pub type Vector = Vector2<f64>;

/// Free space of a mine: the union of its tunnels, chambers and alcoves, less its pillars.
#[derive(Clone, Debug)]
pub struct Network {
    /// The places where tunnels meet or end.
    pub nodes: Vec<Node>,
    /// Every tunnel runs from one node to another. A node that only one tunnel touches is a dead end.
    pub tunnels: Vec<Tunnel>,
    /// Round pockets in a wall that are too shallow to be an opening.
    pub alcoves: Vec<Disc>,
    /// Free-standing rock; each pillar is an island.
    pub pillars: Vec<Disc>,
    /// Height from floor to roof, metres. The lidar is at half of it.
    pub height_m: f64,
}

/// A place where tunnels meet, or where one ends.
#[derive(Clone, Debug)]
pub struct Node {
    /// Position of the node.
    pub position_m: Point,
    /// Radius of the chamber at the node; 0 for none. Corners where tunnels meet are always rounded.
    pub chamber_radius_m: f64,
}

/// A tunnel between two nodes.
#[derive(Clone, Debug)]
pub struct Tunnel {
    /// The nodes at the first and the last point of the centreline.
    pub ends: [usize; 2],
    /// The centreline, at least two points.
    pub centreline_m: Vec<Point>,
    /// Half the width at each point of the centreline.
    pub half_widths_m: Vec<f64>,
}

/// A disc of free space or of rock.
#[derive(Clone, Copy, Debug)]
pub struct Disc {
    /// Centre of the disc.
    pub centre_m: Point,
    /// Radius of the disc.
    pub radius_m: f64,
}

impl Network {
    /// A mine of solid rock.
    pub fn new(height_m: f64) -> Self {
        Self { nodes: Vec::new(), tunnels: Vec::new(), alcoves: Vec::new(), pillars: Vec::new(), height_m }
    }

    /// Adds a node and returns its number.
    pub fn add_node(&mut self, position_m: Point) -> usize {
        self.nodes.push(Node { position_m, chamber_radius_m: 0.0 });
        self.nodes.len() - 1
    }

    /// Adds a tunnel from node `from` to node `to`, the ends of its centreline, and returns its number.
    ///
    /// # Panics
    /// If the centreline has fewer than two points, another number of widths, or ends farther than a millimetre from its
    /// nodes.
    pub fn add_tunnel(&mut self, from: usize, to: usize, centreline_m: Vec<Point>, half_widths_m: Vec<f64>) -> usize {
        let (Some(first), Some(last)) = (centreline_m.first(), centreline_m.last()) else {
            panic!("a tunnel needs a centreline");
        };
        assert!(
            centreline_m.len() >= 2 && centreline_m.len() == half_widths_m.len(),
            "a tunnel needs at least two points, with one width each"
        );
        assert!((first - self.nodes[from].position_m).norm() < 1e-3, "the tunnel does not begin at node {from}");
        assert!((last - self.nodes[to].position_m).norm() < 1e-3, "the tunnel does not end at node {to}");
        self.tunnels.push(Tunnel { ends: [from, to], centreline_m, half_widths_m });
        self.tunnels.len() - 1
    }

    /// Adds a tunnel from node `from` to a new node, and returns the number of the new node.
    pub fn add_branch(&mut self, from: usize, centreline_m: Vec<Point>, half_widths_m: Vec<f64>) -> usize {
        let to = self.add_node(*centreline_m.last().expect("a tunnel needs a centreline"));
        self.add_tunnel(from, to, centreline_m, half_widths_m);
        to
    }

    /// Number of tunnel ends at a node.
    pub fn degree(&self, node: usize) -> usize {
        self.tunnels.iter().flat_map(|tunnel| tunnel.ends).filter(|&end| end == node).count()
    }

    /// Half the width of the widest tunnel at a node.
    pub fn half_width_at_m(&self, node: usize) -> f64 {
        self.tunnels
            .iter()
            .flat_map(|tunnel| {
                let last = tunnel.half_widths_m.len() - 1;
                [(tunnel.ends[0], tunnel.half_widths_m[0]), (tunnel.ends[1], tunnel.half_widths_m[last])]
            })
            .filter(|&(end, _)| end == node)
            .map(|(_, half_width_m)| half_width_m)
            .fold(0.0, f64::max)
    }

    /// The points of the centrelines along `nodes`, each joined to the next by a tunnel.
    ///
    /// # Panics
    /// If two consecutive nodes are not joined.
    pub fn route_m(&self, nodes: &[usize]) -> Vec<Point> {
        let mut route_m = Vec::new();
        for pair in nodes.windows(2) {
            let forward = self.tunnels.iter().find(|tunnel| tunnel.ends == [pair[0], pair[1]]);
            let backward = self.tunnels.iter().find(|tunnel| tunnel.ends == [pair[1], pair[0]]);
            match (forward, backward) {
                (Some(tunnel), _) => route_m.extend(&tunnel.centreline_m),
                (None, Some(tunnel)) => route_m.extend(tunnel.centreline_m.iter().rev()),
                (None, None) => panic!("no tunnel joins nodes {} and {}", pair[0], pair[1]),
            }
        }
        route_m.dedup();
        route_m
    }

    /// Whether a tunnel from node `from` would have `apart_m` of rock to every other tunnel. For tunnels that meet it at
    /// `from` this is required only beyond four half widths.
    pub(crate) fn has_room_for(&self, from: usize, centreline_m: &[Point], half_width_m: f64, apart_m: f64) -> bool {
        let far = |point: &Point| (point - self.nodes[from].position_m).norm() > 4.0 * half_width_m;
        self.tunnels.iter().all(|tunnel| {
            let meets = tunnel.ends.contains(&from);
            centreline_m.iter().filter(|point| !meets || far(point)).all(|point| {
                let mut others = tunnel.centreline_m.iter().zip(&tunnel.half_widths_m);
                others.all(|(other, other_half_m)| (point - other).norm() > half_width_m + other_half_m + apart_m)
            })
        })
    }
}

impl Tunnel {
    /// Unit direction of the centreline at point `i`.
    pub fn tangent(&self, i: usize) -> Vector {
        tangent(&self.centreline_m, i)
    }

    /// Length of the centreline, metres.
    pub fn length_m(&self) -> f64 {
        self.centreline_m.windows(2).map(|step| (step[1] - step[0]).norm()).sum()
    }
}

/// Unit direction of a polyline at point `i`.
pub(crate) fn tangent(line: &[Point], i: usize) -> Vector {
    (line[(i + 1).min(line.len() - 1)] - line[i.saturating_sub(1)]).normalize()
}

/// The direction turned left by 90°.
pub(crate) fn left_of(direction: Vector) -> Vector {
    Vector::new(-direction.y, direction.x)
}
