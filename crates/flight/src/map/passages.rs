//! Passages of the map: added, divided by a place that is found later, dropped.

use nalgebra::Point2;

use super::Passage;
use super::draft::{Departure, Draft};
use super::visit::Visit;

/// Between two visits of one node, a passage is longer than this.
const TURN_M: f64 = 8.0;

/// A vehicle that comes back to the node that it left, by a way no longer than this many looks, only turned.
const TURN_LOOKS: f64 = 1.5;

impl Draft {
    /// A new place before the end of a known passage, nearer than this, divides it: what is known of it leads elsewhere.
    fn divide(&mut self, (from, by): (usize, usize), (to, came_by): (usize, usize), nearer_m: f64) {
        let is_first = self.map.nodes[to].visits.len() == 1 && self.map.nodes[to].ways[came_by].passage.is_none();
        let Some(passage) = self.map.nodes[from].ways[by].passage.filter(|_| is_first) else { return };
        if nearer_m < self.map.passages[passage].length_m {
            self.map.nodes[from].ways[by].passage = None;
            self.drop_passages_twice();
        }
    }

    /// Whether the vehicle came back to the node that it left without a way in between that is worth a passage.
    pub(super) fn only_turned(last: &Departure, visit: &Visit, node: usize) -> bool {
        last.node == node && visit.reached_at_m - last.at_m < TURN_M.max(TURN_LOOKS * visit.look_m)
    }

    /// Adds the passage from the last node to this one, unless it is known.
    pub(super) fn join(&mut self, last: &Departure, visit: &Visit, to: (usize, usize)) {
        let from = (last.node, last.way);
        let length_m = (visit.reached_at_m - last.at_m).max(0.0);
        self.divide(from, to, length_m + visit.look_m);
        let known = [from, to].map(|(node, way)| self.map.nodes[node].ways[way].passage);
        if known != [None, None] || from == to {
            return;
        }
        let passage = self.map.passages.len();
        // A node lies where its first visit does, which need not be in the middle of the others.
        let apart_m = |a: &Point2<f64>, b: &Point2<f64>| (a - b).norm();
        let [start, end] =
            [last.visit, self.graph.poses.len() - 1].map(|visit| self.graph.poses[visit] * Point2::origin());
        let [first, second] = [from.0, to.0].map(|node| self.map.nodes[node].position_m);
        let length_m = (length_m + apart_m(&first, &second) - apart_m(&start, &end)).max(0.0);
        // Between two places that touch nothing was measured.
        let narrower_m = || {
            [from, to]
                .map(|(node, way)| self.map.nodes[node].ways[way].width_m)
                .into_iter()
                .fold(f64::INFINITY, f64::min)
        };
        let width_m = self.way.width_m().unwrap_or_else(narrower_m);
        let to_last = last.tracked.inverse();
        let between = self.way.via.iter().filter(|(way_m, _)| (last.at_m..visit.reached_at_m).contains(way_m));
        let via_m = between.map(|(_, place_m)| to_last * place_m).collect();
        self.courses.push((last.visit, via_m));
        self.map.passages.push(Passage {
            from: from.0,
            to: to.0,
            length_m,
            length_sd_m: self.flown_sd_m(last, visit),
            width_m,
            stretch_ns: [last.left_ns, visit.time_ns[0]],
            via_m: Vec::new(),
        });
        for (node, way) in [from, to] {
            self.map.nodes[node].ways[way].passage = Some(passage);
        }
    }

    /// Drops passages that no way leads to: the same one from the same way, seen twice; a turn within one way, between two nodes
    /// that are one.
    pub(super) fn drop_passages_twice(&mut self) {
        while let Some(gone) = (0..self.map.passages.len()).find(|&passage| !self.is_of_both_ends(passage)) {
            self.map.passages.remove(gone);
            self.courses.remove(gone);
            for way in self.map.nodes.iter_mut().flat_map(|node| &mut node.ways) {
                way.passage = match way.passage {
                    Some(passage) if passage > gone => Some(passage - 1),
                    Some(passage) if passage == gone => None,
                    other => other,
                };
            }
        }
    }

    /// Whether a way leads to it at either end: two ways, if it leads from a node back to it.
    fn is_of_both_ends(&self, passage: usize) -> bool {
        let ways = |node: usize| self.map.nodes[node].ways.iter().filter(|way| way.passage == Some(passage)).count();
        let of = &self.map.passages[passage];
        if of.from == of.to { ways(of.from) > 1 } else { ways(of.from) > 0 && ways(of.to) > 0 }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;
    use std::sync::Arc;

    use nalgebra::Isometry2;

    use super::*;
    use crate::HereKind;
    use crate::map::draft::NodeMemory;
    use crate::map::outline::Walls;
    use crate::map::{Node, NodeWay};

    #[test]
    fn a_place_before_the_end_of_a_known_passage_divides_it() {
        let node = |passage: Option<usize>| Node {
            kind: HereKind::Junction,
            position_m: Point2::origin(),
            ways: vec![NodeWay { bearing_rad: 0.0, width_m: 4.0, taken: true, passage }],
            visits: vec![[0, 1]],
        };
        for (nearer_m, left) in [(20.0, 0), (39.0, 0), (41.0, 1)] {
            let mut draft = Draft::default();
            draft.map.nodes = vec![node(Some(0)), node(Some(0)), node(None)];
            let (from, to, length_m, width_m) = (0, 1, 40.0, 4.0);
            let (length_sd_m, stretch_ns, via_m) = (None, [0, 1], Vec::new());
            draft.map.passages = vec![Passage { from, to, length_m, length_sd_m, width_m, stretch_ns, via_m }];
            draft.courses = vec![(0, Vec::new())];
            draft.divide((0, 0), (2, 0), nearer_m);
            let leads = |node: &Node| node.ways[0].passage.is_some();
            assert_eq!(draft.map.passages.len(), left, "nearer than {nearer_m} m");
            assert_eq!(draft.map.nodes.iter().filter(|node| leads(node)).count(), 2 * left);
        }
    }

    #[test]
    fn a_turn_within_a_way_of_a_place_mapped_twice_is_no_passage() {
        let way = |bearing_rad: f64, passage| NodeWay { bearing_rad, width_m: 4.0, taken: true, passage };
        // The second node is the first one, seen again after a turn in its first way; another passage leads to a third.
        let first = vec![way(0.0, Some(0)), way(1.6, Some(1)), way(3.1, None)];
        let mut draft = Draft::default();
        for ways in [first, vec![way(0.0, Some(0))], vec![way(-1.5, Some(1))]] {
            let ways_rad = ways.iter().map(|way| way.bearing_rad).collect();
            let (walls, belief) = (Arc::new(Walls::new(&[])), BTreeMap::new());
            draft.places.push(NodeMemory { walls, ways_rad, first_visit: 0, belief });
            draft.map.nodes.push(Node {
                kind: HereKind::Junction,
                position_m: Point2::origin(),
                ways,
                visits: vec![[0, 1]],
            });
        }
        draft.graph.poses = vec![Isometry2::identity()];
        let (length_sd_m, stretch_ns, via_m) = (None, [0, 1], Vec::new());
        let passage = |to: usize, length_m: f64| Passage {
            from: 0,
            to,
            length_m,
            length_sd_m,
            width_m: 4.0,
            stretch_ns,
            via_m: Vec::clone(&via_m),
        };
        draft.map.passages = vec![passage(1, 6.0), passage(2, 30.0)];
        draft.courses = vec![(0, Vec::new()); 2];
        draft.absorb(1, 0);
        let left: Vec<[usize; 2]> = draft.map.passages.iter().map(|passage| [passage.from, passage.to]).collect();
        assert_eq!(left, [[0, 1]], "{:?}", draft.map);
        let leads: Vec<Option<usize>> = draft.map.nodes[0].ways.iter().map(|way| way.passage).collect();
        assert_eq!(leads, [None, Some(0), None]);
    }
}
