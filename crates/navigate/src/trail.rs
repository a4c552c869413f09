//! Where the vehicle was, in order.

use std::collections::BTreeMap;

use nalgebra::{Isometry2, Point2};

use crosscut_flight::{Anchored, Mapper};

/// Places of the trail are this far apart, m.
const STEP_M: f64 = 0.4;

/// Where the trail comes this near to itself, the loop in between is cut out of the way back, m.
const SAME_SPOT_M: f64 = 1.0;

/// The places that the vehicle passed. They move with the map when its drift is corrected.
#[derive(Clone, Debug, Default)]
pub(crate) struct Trail {
    passed: Vec<TrailPoint>,
    /// The first place that is anchored to the latest visit.
    since: usize,
}

#[derive(Clone, Copy, Debug)]
struct TrailPoint {
    tracked: Isometry2<f64>,
    anchored: Anchored,
}

impl Trail {
    /// Adds a pose as it was tracked. Between two visits, each place is anchored to the nearer one.
    pub(crate) fn add(&mut self, tracked: Isometry2<f64>, mapper: &Mapper) {
        let far_m = |last: &TrailPoint| (tracked.translation.vector - last.tracked.translation.vector).norm();
        if self.passed.last().is_some_and(|last| far_m(last) <= STEP_M) {
            return;
        }
        let anchored = mapper.anchored(tracked);
        if self.passed.last().is_some_and(|last| last.anchored.visit != anchored.visit) {
            let half = self.since.midpoint(self.passed.len());
            self.passed[half..].iter_mut().for_each(|passed| passed.anchored = mapper.anchored(passed.tracked));
            self.since = self.passed.len();
        }
        self.passed.push(TrailPoint { tracked, anchored });
    }

    /// The place about this far back, as it was tracked.
    pub(crate) fn back_m(&self, from_m: Point2<f64>, far_m: f64) -> Option<Point2<f64>> {
        let mut places_m = self.passed.iter().rev().map(|passed| Point2::from(passed.tracked.translation.vector));
        places_m.find(|place_m| (place_m - from_m).norm() >= far_m)
    }

    /// All places on the map, where its visits were at these poses.
    pub(crate) fn placed_m(&self, visits: &[Isometry2<f64>]) -> Vec<Point2<f64>> {
        self.passed.iter().map(|passed| Point2::from(passed.anchored.placed(visits).translation.vector)).collect()
    }
}

/// The way back to where a trail begins, without its loops.
pub(crate) fn way_back_m(trail_m: &[Point2<f64>]) -> Vec<Point2<f64>> {
    let mut in_squares: BTreeMap<[i64; 2], Vec<usize>> = BTreeMap::new();
    for (at, place_m) in trail_m.iter().enumerate() {
        in_squares.entry(square_of(place_m)).or_default().push(at);
    }
    let earliest_beside = |at: usize| {
        let [x, y] = square_of(&trail_m[at]);
        let squares = (x - 1..=x + 1).flat_map(|x| (y - 1..=y + 1).map(move |y| [x, y]));
        let is_here = |other: &usize| (trail_m[*other] - trail_m[at]).norm() < SAME_SPOT_M;
        let of_square = |square| in_squares.get(&square)?.iter().copied().find(is_here);
        squares.filter_map(of_square).min()
    };
    let mut at = trail_m.len().saturating_sub(1);
    let mut way_m: Vec<Point2<f64>> = trail_m.get(at).copied().into_iter().collect();
    while at > 0 {
        at = earliest_beside(at).map_or(at - 1, |earliest| earliest.min(at - 1));
        way_m.push(trail_m[at]);
    }
    way_m
}

/// The square that a place is in: what is nearer than [`SAME_SPOT_M`] is in it, or in one of the eight around it.
fn square_of(place_m: &Point2<f64>) -> [i64; 2] {
    // `as` saturates; one off the last number, so that there are squares around.
    [place_m.x, place_m.y].map(|along_m| ((along_m / SAME_SPOT_M).floor() as i64).clamp(i64::MIN + 1, i64::MAX - 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 10 m ahead, around a square of 20 m, then 10 m to the side.
    fn around_a_square() -> Vec<Point2<f64>> {
        let corners = [[0.0, 0.0], [10.0, 0.0], [30.0, 0.0], [30.0, 20.0], [10.0, 20.0], [10.0, 0.0], [10.0, -10.0]];
        let corners = corners.map(|[x, y]| Point2::new(x, y));
        let side = |ends: &[Point2<f64>]| {
            let [from, to] = [ends[0], ends[1]];
            (0..20).map(move |step| from + (to - from) * (f64::from(step) / 20.0))
        };
        corners.windows(2).flat_map(side).collect()
    }

    #[test]
    fn the_way_back_is_the_trail_without_its_loops() {
        let way_m = way_back_m(&around_a_square());
        let length_m: f64 = way_m.windows(2).map(|step| (step[1] - step[0]).norm()).sum();
        assert!((17.0..21.0).contains(&length_m), "{length_m} m");
        assert_eq!(way_m.last(), Some(&Point2::origin()));
    }

    #[test]
    fn the_way_back_is_the_one_that_a_search_of_the_whole_trail_finds() {
        let place = |step: i32| {
            let along = f64::from(step) * 0.05;
            Point2::new(20.0 * (0.31 * along).sin(), 20.0 * (0.17 * along).sin())
        };
        let trail_m: Vec<Point2<f64>> = (0..3000).map(place).collect();
        let mut at = trail_m.len() - 1;
        let mut searched_m = vec![trail_m[at]];
        while at > 0 {
            let is_here = |place_m: &Point2<f64>| (place_m - trail_m[at]).norm() < SAME_SPOT_M;
            at = trail_m.iter().position(is_here).map_or(at - 1, |earliest| earliest.min(at - 1));
            searched_m.push(trail_m[at]);
        }
        assert!(searched_m.len() < 500, "the trail has loops");
        assert_eq!(way_back_m(&trail_m), searched_m);
    }

    #[test]
    fn places_are_kept_a_step_apart_and_looked_up_backwards() {
        let mut trail = Trail::default();
        let mapper = Mapper::default();
        around_a_square().iter().for_each(|place_m| trail.add(Isometry2::new(place_m.coords, 0.0), &mapper));
        assert_eq!(trail.back_m(Point2::new(10.0, -10.0), 5.0), Some(Point2::new(10.0, -5.0)));
        assert!(trail.placed_m(&[]).windows(2).all(|step| (step[1] - step[0]).norm() > STEP_M));
    }
}
