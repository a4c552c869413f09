//! What a surveyor would say of a mine: its map, and what kind of place lies at a position.
//!
//! *Places* are the nodes with one tunnel (dead ends) or three and more (junctions). Tunnels that meet at a node of two
//! are one passage. Distances to a place are in widths of its widest tunnel.

use crosscut_messages::{TruthEdge, TruthKind, TruthMap, TruthNode, TruthPlace, TruthPose, TruthWay};
use crosscut_stage::wrap_angle_rad;

use crate::network::{Network, Point};
use crate::pose::Pose;

/// Within this many widths a position is in a junction, or at a dead end.
const IN_JUNCTION: f64 = 0.5;
const AT_DEAD_END: f64 = 0.8;

/// Beyond this many widths from junctions and from dead ends it is in a passage; a look from there does not reach them.
const FROM_JUNCTION: f64 = 2.0;
const FROM_DEAD_END: f64 = 3.0;

/// A dead end that is nearer to its junction, in widths, may be a way or a bay.
const BAY: f64 = 2.5;

/// A round place with one or two tunnels whose diameter is more than this many of their widths is a chamber; one of less
/// than the first of them is none.
const CHAMBER: [f64; 2] = [1.25, 1.75];

/// The direction of a way is that to where its centreline is this many widths away.
const BEARING_AT: f64 = 1.0;

impl Network {
    /// The map of the mine, in the frame of `origin`.
    pub fn map(&self, origin: &Pose) -> TruthMap {
        let places: Vec<usize> = (0..self.nodes.len()).filter(|&node| self.is_place(node)).collect();
        let number = |node: usize| places.binary_search(&node).expect("passages end at places");
        let mut map = TruthMap::default();
        for (id, &node) in places.iter().enumerate() {
            let position = seen_from(origin, self.nodes[node].position_m, 0.0);
            let kind = if self.degree(node) == 1 { TruthKind::DeadEnd } else { TruthKind::Junction };
            map.nodes.push(TruthNode { id, kind, x_m: position.x_m, y_m: position.y_m, ways: Vec::new() });
        }
        for &from in &places {
            for first in self.ends_at(from) {
                let Course { last, length_m, width_m } = self.course(first);
                // Each passage is found from both of its ends.
                if last < first {
                    continue;
                }
                let id = map.edges.len();
                let to = self.tunnels[last.tunnel].ends[last.end];
                map.edges.push(TruthEdge { id, from: number(from), to: number(to), length_m, width_m });
                for end in [first, last] {
                    let node = self.tunnels[end.tunnel].ends[end.end];
                    map.nodes[number(node)].ways.push(self.way(end, id, origin));
                }
            }
        }
        for node in &mut map.nodes {
            node.ways.sort_by(|a, b| a.bearing_rad.total_cmp(&b.bearing_rad));
        }
        map
    }

    /// What lies at a position; `None` between two kinds of place.
    pub fn place_at(&self, at_m: &Point) -> Option<TruthPlace> {
        let nearest = |is: fn(usize) -> bool| {
            let nodes = (0..self.nodes.len()).filter(move |&node| is(self.degree(node)));
            let widths = nodes.map(|node| {
                let off_m = (self.nodes[node].position_m - at_m).norm();
                (off_m / (2.0 * self.half_width_at_m(node)), node)
            });
            widths.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((f64::INFINITY, 0))
        };
        let ((to_junction, junction), (to_end, _)) = (nearest(|degree| degree >= 3), nearest(|degree| degree == 1));
        let place = |kind, ways| Some(TruthPlace { kind, ways });
        if let Some(in_chamber) = self.chamber_at(at_m) {
            return in_chamber;
        }
        match () {
            () if to_junction < FROM_JUNCTION && self.has_bay(junction) => None,
            () if to_junction < IN_JUNCTION => place(TruthKind::Junction, self.degree(junction) as u32),
            () if to_end < AT_DEAD_END && to_junction > FROM_JUNCTION => place(TruthKind::DeadEnd, 1),
            () if to_junction > FROM_JUNCTION && to_end > FROM_DEAD_END => place(TruthKind::Passage, 2),
            () => None,
        }
    }

    /// Whether a position is in or near what may be a chamber with one or two tunnels: then what lies there, if it is clear.
    fn chamber_at(&self, at_m: &Point) -> Option<Option<TruthPlace>> {
        let off_m = |node: usize| (self.nodes[node].position_m - at_m).norm();
        let radius_m = |node: usize| self.nodes[node].chamber_radius_m;
        let width_m = |node: usize| 2.0 * self.half_width_at_m(node);
        let widths = |node: usize| 2.0 * radius_m(node) / width_m(node);
        let may_be_one = |&node: &usize| widths(node) > CHAMBER[0] && (1..3).contains(&self.degree(node));
        let is_near = |&node: &usize| off_m(node) < radius_m(node) + FROM_JUNCTION * width_m(node);
        let node = (0..self.nodes.len()).filter(may_be_one).find(is_near)?;
        let is_clear = widths(node) > CHAMBER[1] && off_m(node) < 0.5 * radius_m(node);
        Some(is_clear.then_some(TruthPlace { kind: TruthKind::Chamber, ways: self.degree(node) as u32 }))
    }

    /// Whether a short dead end leaves from a junction.
    fn has_bay(&self, junction: usize) -> bool {
        let least_m = BAY * 2.0 * self.half_width_at_m(junction);
        self.ends_at(junction).any(|end| {
            let Course { last, length_m, .. } = self.course(end);
            self.degree(self.tunnels[last.tunnel].ends[last.end]) == 1 && length_m < least_m
        })
    }

    fn is_place(&self, node: usize) -> bool {
        ![0, 2].contains(&self.degree(node))
    }

    fn ends_at(&self, node: usize) -> impl Iterator<Item = TunnelEnd> {
        let ends =
            self.tunnels.iter().enumerate().flat_map(|(tunnel, of)| [(tunnel, 0, of.ends[0]), (tunnel, 1, of.ends[1])]);
        ends.filter(move |&(.., at)| at == node).map(|(tunnel, end, _)| TunnelEnd { tunnel, end })
    }

    /// From a tunnel at a place through bends to the next place.
    fn course(&self, first: TunnelEnd) -> Course {
        let (mut at, mut length_m, mut area_m2) = (first, 0.0, 0.0);
        loop {
            let tunnel = &self.tunnels[at.tunnel];
            let mean_half_m = tunnel.half_widths_m.iter().sum::<f64>() / tunnel.half_widths_m.len() as f64;
            length_m += tunnel.length_m();
            area_m2 += 2.0 * mean_half_m * tunnel.length_m();
            let far = TunnelEnd { tunnel: at.tunnel, end: 1 - at.end };
            let node = tunnel.ends[far.end];
            match self.ends_at(node).find(|&end| end != far).filter(|_| !self.is_place(node)) {
                Some(next) => at = next,
                None => return Course { last: far, length_m, width_m: area_m2 / length_m },
            }
        }
    }

    /// The way of a place at the end of a tunnel.
    fn way(&self, end: TunnelEnd, edge: usize, origin: &Pose) -> TruthWay {
        let tunnel = &self.tunnels[end.tunnel];
        let mut line: Vec<(Point, f64)> =
            tunnel.centreline_m.iter().copied().zip(tunnel.half_widths_m.iter().copied()).collect();
        if end.end == 1 {
            line.reverse();
        }
        let (from_m, half_width_m) = line[0];
        let is_away = |(place_m, _): &&(Point, f64)| (place_m - from_m).norm() >= BEARING_AT * 2.0 * half_width_m;
        let away_m = line.iter().find(is_away).unwrap_or(&line[line.len() - 1]).0 - from_m;
        let bearing_rad = wrap_angle_rad(away_m.y.atan2(away_m.x) - origin.heading_rad);
        TruthWay { bearing_rad, width_m: 2.0 * half_width_m, edge }
    }
}

/// A position and a heading in the mine, in the frame of `origin`.
pub(crate) fn seen_from(origin: &Pose, position_m: Point, heading_rad: f64) -> TruthPose {
    let off = nalgebra::Rotation2::new(-origin.heading_rad) * (position_m - origin.position_m);
    TruthPose { x_m: off.x, y_m: off.y, yaw_rad: wrap_angle_rad(heading_rad - origin.heading_rad) }
}

/// One of the two ends of a tunnel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct TunnelEnd {
    tunnel: usize,
    end: usize,
}

/// The tunnels from one place to the next.
struct Course {
    last: TunnelEnd,
    length_m: f64,
    width_m: f64,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::course::swaying;

    /// Dead end 0, 20 m, tee 1, with a ring of three tunnels over the bends 2 and 3 back to it.
    fn ring() -> Network {
        let mut network = Network::new(3.0);
        let places = [(0.0, 0.0), (20.0, 0.0), (35.0, 10.0), (35.0, -10.0)].map(|(x, y)| Point::new(x, y));
        places.iter().for_each(|place_m| {
            network.add_node(*place_m);
        });
        for [from, to] in [[0, 1], [1, 2], [3, 2], [3, 1]] {
            let line = swaying(places[from], places[to], 0.0);
            let widths = vec![1.5; line.len()];
            network.add_tunnel(from, to, line, widths);
        }
        network
    }

    #[test]
    fn bends_are_no_nodes_and_a_ring_is_one_passage() {
        let map = ring().map(&Pose::level(Point::new(10.0, 0.0), std::f64::consts::FRAC_PI_2));
        assert_eq!(
            map.nodes.iter().map(|node| (node.kind, node.ways.len())).collect::<Vec<_>>(),
            [(TruthKind::DeadEnd, 1), (TruthKind::Junction, 3)]
        );
        assert_eq!(map.edges.iter().map(|edge| [edge.from, edge.to]).collect::<Vec<_>>(), [[0, 1], [1, 1]]);
        let ring_m = 20.0 + 2.0 * 15_f64.hypot(10.0);
        assert!((map.edges[1].length_m - ring_m).abs() < 1e-9 && (map.edges[1].width_m - 3.0).abs() < 1e-9, "{map:?}");
        // Seen from (10, 0) facing along y, the tee lies 10 m to the right.
        assert!(map.nodes[1].x_m.abs() < 1e-9 && (map.nodes[1].y_m + 10.0).abs() < 1e-9, "{map:?}");
        assert_eq!(map.nodes[1].ways.iter().map(|way| way.edge).collect::<Vec<_>>(), [1, 1, 0], "{map:?}");
    }

    #[test]
    fn places_are_named_by_the_nodes_around_them() {
        let mut network = ring();
        let at =
            |network: &Network, x_m: f64| network.place_at(&Point::new(x_m, 0.0)).map(|here| (here.kind, here.ways));
        assert_eq!(at(&network, 20.5), Some((TruthKind::Junction, 3)));
        assert_eq!(at(&network, 1.0), Some((TruthKind::DeadEnd, 1)));
        assert_eq!(at(&network, 11.0), Some((TruthKind::Passage, 2)));
        assert_eq!(at(&network, 17.0), None, "before the tee");
        network.nodes[0].chamber_radius_m = 4.0;
        assert_eq!([0.0, 6.0].map(|x_m| at(&network, x_m)), [Some((TruthKind::Chamber, 1)), None]);
    }
}
