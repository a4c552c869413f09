//! The places where the centrelines of a mine leave the visible region, found by walking outward from the sensor.

use crate::network::{Point, Vector};
use crate::skeleton::Skeleton;
use crate::surface::Surface;

/// A centreline that becomes visible again within this distance has not left the visible region: a bump hid it.
const HIDDEN_M: f64 = 3.0;

/// The visible region: all places visible from one place up to a range, in all directions.
pub(crate) struct Sight<'a> {
    pub(crate) surface: &'a Surface,
    pub(crate) from_m: Point,
    pub(crate) range_m: f64,
}

/// A place where a centreline leaves the visible region.
#[derive(Clone, Debug)]
pub(crate) struct Exit {
    /// Visible points of the skeleton, from the one nearest to the sensor to the last one before the exit.
    pub(crate) path: Vec<usize>,
    /// The last visible place of the centreline.
    pub(crate) at_m: Point,
    /// Direction of the centreline there, outward.
    pub(crate) outward: Vector,
    /// Half the nominal width there.
    pub(crate) half_width_m: f64,
    /// Length of the edge of the visible region at the exit, if the edge is the shadow of a corner; infinite if it is the
    /// end of the range.
    pub(crate) shadow_m: f64,
}

impl Sight<'_> {
    /// Whether a place of a centreline is visible past pillars. A pillar hides no opening, because the view to its left
    /// and right shows how the tunnel continues behind it.
    fn sees_past_pillars(&self, point_m: Point) -> bool {
        let towards = point_m - self.from_m;
        let distance_m = towards.norm();
        distance_m <= self.range_m
            && (distance_m == 0.0
                || self.surface.cast_past_pillars(self.from_m, towards / distance_m, distance_m).is_none())
    }

    /// Whether a place is visible.
    fn sees(&self, point_m: Point) -> bool {
        (point_m - self.from_m).norm() <= self.range_m && self.surface.sees(self.from_m, point_m)
    }

    /// Length of the shadow line through a place on the edge of the visible region.
    fn shadow_m(&self, at_m: Point) -> f64 {
        let towards = at_m - self.from_m;
        if towards.norm() > self.range_m - 1e-3 {
            return f64::INFINITY;
        }
        let beside = |angle_rad: f64| {
            let direction = nalgebra::Rotation2::new(angle_rad) * towards.normalize();
            self.surface.cast_past_pillars(self.from_m, direction, self.range_m).map_or(self.range_m, |hit| hit.range_m)
        };
        (beside(1e-4) - beside(-1e-4)).abs()
    }
}

/// All exits; each is the first on its path outward.
pub(crate) fn exits(skeleton: &Skeleton, sight: &Sight<'_>) -> Vec<Exit> {
    let Some(start) = nearest_in_sight(skeleton, sight) else { return Vec::new() };
    let n = skeleton.points.len();
    let mut walk = Walk { skeleton, sight, came_from: vec![usize::MAX; n], exits: Vec::new() };
    walk.came_from[start] = start;
    let mut to_visit = vec![start];
    while let Some(at) = to_visit.pop() {
        for &next in &skeleton.points[at].neighbours {
            if walk.came_from[next] != usize::MAX {
                continue;
            }
            if walk.continues_to(next) {
                walk.came_from[next] = at;
                to_visit.push(next);
                continue;
            }
            let (leaves, returns) = walk.beyond(at, next);
            if leaves {
                walk.add_exit(at, next);
            }
            for back in returns {
                walk.came_from[back] = at;
                to_visit.push(back);
            }
        }
    }
    walk.exits
}

fn nearest_in_sight(skeleton: &Skeleton, sight: &Sight<'_>) -> Option<usize> {
    let mut nearest = None;
    let mut nearest_m = f64::INFINITY;
    for (index, point) in skeleton.points.iter().enumerate() {
        let distance_m = (point.position_m - sight.from_m).norm();
        if distance_m < nearest_m && sight.sees_past_pillars(point.position_m) {
            (nearest, nearest_m) = (Some(index), distance_m);
        }
    }
    nearest
}

struct Walk<'a> {
    skeleton: &'a Skeleton,
    sight: &'a Sight<'a>,
    /// The visible point before each visited point; `usize::MAX` for points not visited.
    came_from: Vec<usize>,
    exits: Vec<Exit>,
}

impl Walk<'_> {
    /// Whether the walk can continue to a point. It never continues to the end of a dead end: whether that is closed
    /// depends on the visibility of its face alone.
    fn continues_to(&self, point: usize) -> bool {
        let point = &self.skeleton.points[point];
        point.face_m.is_none() && self.sight.sees_past_pillars(point.position_m)
    }

    /// Follows the centrelines that become invisible from `at` to `next`. Returns whether one of them leaves the visible
    /// region, and the points at which others become visible again.
    fn beyond(&self, at: usize, next: usize) -> (bool, Vec<usize>) {
        let (mut leaves, mut returns) = (false, Vec::new());
        let mut hidden = vec![next];
        let mut to_follow = vec![(next, self.skeleton.distance_m(at, next))];
        while let Some((point, walked_m)) = to_follow.pop() {
            if let Some(face_m) = self.skeleton.points[point].face_m {
                // A dead end whose face is visible is closed; otherwise it is an opening.
                leaves |= !face_m.iter().any(|&place_m| self.sight.sees(place_m));
                continue;
            }
            for &after in &self.skeleton.points[point].neighbours {
                if after == at || hidden.contains(&after) {
                    continue;
                }
                let walked_m = walked_m + self.skeleton.distance_m(point, after);
                if self.continues_to(after) {
                    leaves |= walked_m >= HIDDEN_M;
                    if walked_m < HIDDEN_M && self.came_from[after] == usize::MAX && !returns.contains(&after) {
                        returns.push(after);
                    }
                } else if walked_m >= HIDDEN_M + self.sight.range_m {
                    leaves = true;
                } else {
                    hidden.push(after);
                    to_follow.push((after, walked_m));
                }
            }
        }
        (leaves, returns)
    }

    fn add_exit(&mut self, at: usize, next: usize) {
        let (from, to) = (&self.skeleton.points[at], &self.skeleton.points[next]);
        let edge_m = to.position_m - from.position_m;
        // Bisection: `seen` is visible, `unseen` is not.
        let (mut seen, mut unseen) = (0.0, 1.0);
        while unseen - seen > 1e-7 {
            let middle = 0.5 * (seen + unseen);
            if self.sight.sees_past_pillars(from.position_m + edge_m * middle) {
                seen = middle;
            } else {
                unseen = middle;
            }
        }
        let mut path = vec![at];
        while let Some(&last) = path.last()
            && self.came_from[last] != last
        {
            path.push(self.came_from[last]);
        }
        path.reverse();
        let at_m = from.position_m + edge_m * seen;
        self.exits.push(Exit {
            path,
            at_m,
            outward: edge_m.normalize(),
            half_width_m: from.half_width_m + (to.half_width_m - from.half_width_m) * seen,
            shadow_m: self.sight.shadow_m(at_m),
        });
    }
}
