//! The centrelines of a mine as a graph of closely spaced points, for walking along them.

use crate::network::{Network, Point, Vector, left_of, tangent};
use crate::surface::Surface;

/// Largest distance between neighbouring points, metres.
const STEP_M: f64 = 0.25;

/// The centrelines of a mine.
#[derive(Clone, Debug)]
pub(crate) struct Skeleton {
    pub(crate) points: Vec<SkeletonPoint>,
}

/// A point of a centreline.
#[derive(Clone, Debug)]
pub(crate) struct SkeletonPoint {
    pub(crate) position_m: Point,
    pub(crate) half_width_m: f64,
    /// Indices of the neighbouring points.
    pub(crate) neighbours: Vec<usize>,
    /// At a dead end, three places across its face, just before the rock.
    pub(crate) face_m: Option<[Point; 3]>,
}

impl Skeleton {
    pub(crate) fn new(network: &Network, surface: &Surface) -> Self {
        // The first points are the nodes, with the same numbers.
        let points = (0..network.nodes.len())
            .map(|node| SkeletonPoint {
                position_m: network.nodes[node].position_m,
                half_width_m: network.half_width_at_m(node),
                neighbours: Vec::new(),
                face_m: None,
            })
            .collect();
        let mut skeleton = Self { points };
        for tunnel in &network.tunnels {
            let mut last = tunnel.ends[0];
            let edges = tunnel.centreline_m.windows(2).zip(tunnel.half_widths_m.windows(2));
            for (edge, (line, half_widths)) in edges.enumerate() {
                let pieces = ((line[1] - line[0]).norm() / STEP_M).ceil().max(1.0);
                for piece in 1..=pieces as usize {
                    let share = piece as f64 / pieces;
                    let at_the_end = edge + 2 == tunnel.centreline_m.len() && share == 1.0;
                    let next = if at_the_end { tunnel.ends[1] } else { skeleton.points.len() };
                    if !at_the_end {
                        skeleton.points.push(SkeletonPoint {
                            position_m: line[0] + (line[1] - line[0]) * share,
                            half_width_m: half_widths[0] + (half_widths[1] - half_widths[0]) * share,
                            neighbours: Vec::new(),
                            face_m: None,
                        });
                    }
                    skeleton.points[last].neighbours.push(next);
                    skeleton.points[next].neighbours.push(last);
                    last = next;
                }
            }
            let n = tunnel.centreline_m.len();
            let outward = [-tangent(&tunnel.centreline_m, 0), tangent(&tunnel.centreline_m, n - 1)];
            for (node, outward) in tunnel.ends.into_iter().zip(outward) {
                if network.degree(node) == 1 && network.nodes[node].chamber_radius_m == 0.0 {
                    let point = &mut skeleton.points[node];
                    point.face_m = Some(face_m(surface, point.position_m, point.half_width_m, outward));
                }
            }
        }
        skeleton
    }

    /// Distance between two points.
    pub(crate) fn distance_m(&self, a: usize, b: usize) -> f64 {
        (self.points[a].position_m - self.points[b].position_m).norm()
    }
}

/// Three places across the face at the end of a tunnel, 5 cm before the rock.
fn face_m(surface: &Surface, end_m: Point, half_width_m: f64, outward: Vector) -> [Point; 3] {
    [-0.7, 0.0, 0.7].map(|share| {
        let before_m = end_m - outward * 2.0 + left_of(outward) * (share * half_width_m);
        let to_rock_m = surface.cast(before_m, outward, 4.0).map_or(2.0, |hit| hit.range_m);
        before_m + outward * (to_rock_m - 0.05)
    })
}
