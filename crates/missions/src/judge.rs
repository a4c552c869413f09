//! What is measured of a mission, by the truth.

use nalgebra::Point2;

use crosscut_simulator::{Mine, World};

use crate::ways::{TrueWay, offline_m, ways_of};

/// A way is visited once the vehicle was in both of its halves on one stay; one to a dead end also once its face is in sight
/// from this near, m.
const FACE_IN_SIGHT_M: f64 = 10.0;

/// Before the face, so that the rock itself is not in the way, m.
const BEFORE_FACE_M: f64 = 0.8;

/// A way is entered this far from its ends, m, or at a third of its length.
const ENTERED_M: f64 = 5.0;

/// The vehicle is home within this of its start, m.
const HOME_M: f64 = 5.0;

/// Watches the true places of a vehicle.
#[derive(Clone, Debug)]
pub(crate) struct MissionJudge {
    mine: Mine,
    start_m: Point2<f64>,
    ways: Vec<TrueWay>,
    is_visited: Vec<bool>,
    was_entered: Vec<bool>,
    /// The way that the vehicle was in last, beyond its ends.
    within: Option<usize>,
    /// Which of its halves the vehicle was in since.
    was_in_half: [bool; 2],
    in_vain: u32,
    home_way: Option<usize>,
}

impl MissionJudge {
    pub(crate) fn new(world: &World) -> Self {
        let ways = ways_of(world.mine.network(), world.start_node);
        let home_way = ways.iter().position(|way| way.ends.contains(&world.start_node));
        let [is_visited, was_entered] = [vec![false; ways.len()], vec![false; ways.len()]];
        let start_m = world.start.position_m;
        Self {
            mine: world.mine.clone(),
            start_m,
            ways,
            is_visited,
            was_entered,
            within: None,
            was_in_half: [false; 2],
            in_vain: 0,
            home_way,
        }
    }

    /// The vehicle is at a place.
    pub(crate) fn add(&mut self, place_m: Point2<f64>) {
        if let Some((way, half)) = self.way_at(place_m) {
            if Some(way) != self.within {
                let is_dead_end = self.ways[way].dead_ends.contains(&true) && Some(way) != self.home_way;
                self.in_vain += u32::from(is_dead_end && self.was_entered[way]);
                self.was_entered[way] = true;
                (self.within, self.was_in_half) = (Some(way), [false; 2]);
            }
            self.was_in_half[half] = true;
            self.is_visited[way] |= self.was_in_half == [true; 2];
        }
        for way in 0..self.ways.len() {
            self.is_visited[way] = self.is_visited[way] || self.has_face_in_sight(way, place_m);
        }
    }

    fn has_face_in_sight(&self, way: usize, place_m: Point2<f64>) -> bool {
        let TrueWay { centreline_m, dead_ends, .. } = &self.ways[way];
        let ends = [centreline_m.iter().collect::<Vec<_>>(), centreline_m.iter().rev().collect()];
        ends.iter().zip(dead_ends).filter(|(_, is_dead_end)| **is_dead_end).any(|(line, _)| {
            let before = line.iter().find(|point| (**point - line[0]).norm() >= BEFORE_FACE_M);
            before.is_some_and(|&&face_m| {
                (face_m - place_m).norm() < FACE_IN_SIGHT_M && self.mine.surface().sees(place_m, face_m)
            })
        })
    }

    /// The way that a place is in, beyond its ends, and which of its halves.
    fn way_at(&self, place_m: Point2<f64>) -> Option<(usize, usize)> {
        let is_in = |way: &TrueWay| {
            let beyond_m = ENTERED_M.min(way.length_m / 3.0);
            let (first, last) = (way.centreline_m.first()?, way.centreline_m.last()?);
            let ends = [(first, way.dead_ends[0]), (last, way.dead_ends[1])];
            let is_inside = ends.iter().all(|(end, is_dead)| *is_dead || (*end - place_m).norm() > beyond_m);
            let apart_m = way.centreline_m.iter().map(|point| (point - place_m).norm());
            let (nearest, near_m) = apart_m.enumerate().min_by(|a, b| a.1.total_cmp(&b.1))?;
            let half = usize::from(nearest >= way.centreline_m.len() / 2);
            (is_inside && near_m < way.half_width_m).then_some((near_m, half))
        };
        let near = self.ways.iter().enumerate().filter_map(|(number, way)| Some((number, is_in(way)?)));
        near.min_by(|a, b| a.1.0.total_cmp(&b.1.0)).map(|(number, (_, half))| (number, half))
    }

    pub(crate) fn ways(&self) -> usize {
        self.ways.len()
    }

    pub(crate) fn visited(&self) -> usize {
        self.is_visited.iter().filter(|visited| **visited).count()
    }

    /// The middles of the ways that were not visited.
    pub(crate) fn missed_m(&self) -> Vec<Point2<f64>> {
        let missed = self.ways.iter().zip(&self.is_visited).filter(|(_, visited)| !**visited);
        missed.map(|(way, _)| way.centreline_m[way.centreline_m.len() / 2]).collect()
    }

    /// How often a way to a dead end was entered again.
    pub(crate) fn in_vain(&self) -> u32 {
        self.in_vain
    }

    pub(crate) fn is_home(&self, place_m: Point2<f64>) -> bool {
        (place_m - self.start_m).norm() < HOME_M
    }

    /// The least flight through all ways, and whether that is exact.
    pub(crate) fn offline_m(&self) -> (f64, bool) {
        offline_m(&self.ways)
    }

    /// The flight of depth-first search on the true mine: every way there and back.
    pub(crate) fn depth_first_m(&self) -> f64 {
        2.0 * self.ways.iter().map(|way| way.length_m).sum::<f64>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crosscut_simulator::Plan;

    #[test]
    fn a_bend_that_is_cut_short_counts_and_one_that_is_not_reached_does_not() {
        let plan = Plan::from_json(
            r#"{"nodes": [{"id": "portal", "x_m": 0, "y_m": 0}, {"id": 1, "x_m": 20, "y_m": 0}, {"id": 2, "x_m": 40, "y_m": 20},
                {"id": 3, "x_m": 20, "y_m": 20}], "edges": [{"from": "portal", "to": 1, "width_m": 4},
                {"from": 1, "to": 2, "width_m": 6, "via_m": [[40, 0]]}, {"from": 1, "to": 3, "width_m": 4}]}"#,
        );
        let world = plan.and_then(|plan| plan.world(1)).expect("a world");
        let mut judge = MissionJudge::new(&world);
        let to_bend = [(26.0, 0.0), (30.0, 1.0), (34.0, 2.0)];
        to_bend.into_iter().for_each(|(x, y)| judge.add(Point2::new(x, y)));
        assert_eq!(judge.visited(), 0);
        // More than the half width from the bend's middle, which is that of the way.
        let around_it = [(36.6, 2.6), (37.4, 3.4), (38.0, 6.0), (38.0, 8.0)];
        around_it.into_iter().for_each(|(x, y)| judge.add(Point2::new(x, y)));
        assert_eq!(judge.visited(), 1, "{:?}", judge.missed_m());
    }
}
