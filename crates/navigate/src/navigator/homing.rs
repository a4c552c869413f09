//! Home: the last metres of the way back, and whether the vehicle is there.

use nalgebra::{Isometry2, Point2};

use crosscut_flight::{Here, Mapper};
use crosscut_stage::Frame;

use super::Navigator;
use crate::surround::Field;

/// The vehicle is home within this of where it started, m.
const HOME_M: f64 = 3.0;

/// At home, the walls in view lie on those of the start by this share. In the simulated mines it was 0.95 and more; 9 m and more
/// away it was 0.84 or less in all but one of 5,000 scans, and up to 0.93 in a straight passage.
const LEAST_SHARE: f64 = 0.87;

/// The walls in view are compared with those of the start at every n-th revolution where the vehicle may be at home.
const COMPARED_EVERY: u64 = 5;

/// The vehicle may be at home where the map has home within [`HOME_M`] and this many standard deviations of the pose.
const DEVIATIONS: f64 = 3.0;

/// The vehicle is not at home where the map has home farther away than this, m.
const FARTHEST_M: f64 = 30.0;

/// Where the map says home is elsewhere, the walls in view lie on those of the start by at least this share.
const SURE_SHARE: f64 = 0.96;

/// Where the map says home is elsewhere, this many fits have to agree.
const SEEN_HOME: usize = 4;

/// Fits of the walls around the start are taken at places farther apart than this, m.
const MOVED_M: f64 = 0.3;

/// Fits of the walls around the start agree if their positions of home differ by less than this, m.
const SAME_HOME_M: f64 = 0.5;

/// After this many revolutions there, what cannot be compared is home, and what does not look like it is not.
const MOST_NEAR_HOME: u64 = 50;

/// The way over free cells to what is in reach is no longer than this many times the distance; near walls it counts more.
const MOST_DETOUR: f64 = 3.0;

impl Navigator {
    /// Whether the vehicle flies home and is there: by the walls in view, which lie as they did at the start. They also show how
    /// far the map is off there.
    pub(super) fn is_home(
        &mut self,
        frame: &Frame,
        seen: Option<&Here>,
        pose: &Isometry2<f64>,
        mapper: &Mapper,
    ) -> bool {
        self.start.add(frame, seen, pose);
        if !self.goes_home || self.is_elsewhere {
            self.near_home = 0;
            return false;
        }
        let off_m = |correction: &Isometry2<f64>| (correction * pose).translation.vector.norm();
        let by_map_m = off_m(&self.correction);
        self.near_home = if by_map_m < HOME_M { self.near_home + 1 } else { 0 };
        let is_all_around = frame.revolution.beams().is_none_or(|sweep| sweep.full_turn);
        if is_all_around && (self.near_home == 1 || self.now.is_multiple_of(COMPARED_EVERY)) {
            let reach_m = || HOME_M + DEVIATIONS * mapper.from_start_sd_m(pose).unwrap_or(0.0);
            if by_map_m < FARTHEST_M && by_map_m < reach_m() && self.sees_home(frame, pose, by_map_m) {
                return off_m(&self.correction) < HOME_M;
            }
        }
        let is_over = self.near_home > MOST_NEAR_HOME;
        self.is_elsewhere = is_over && is_all_around;
        is_over && !is_all_around
    }

    /// Whether the walls in view lie on those of the start; the map is then corrected by them. Farther away by the map than home may
    /// be, they must do so several times on the way, and show the same place: walls of a passage look much the same.
    fn sees_home(&mut self, frame: &Frame, pose: &Isometry2<f64>, by_map_m: f64) -> bool {
        let is_near = by_map_m < HOME_M;
        let least_share = if is_near { LEAST_SHARE } else { SURE_SHARE };
        let again = self.start.look.seen_again(frame, &(self.correction * pose));
        let Some(again) = again.filter(|again| again.share >= least_share) else {
            self.seen_home.clear();
            return false;
        };
        let correction = again.pose * pose.inverse();
        let is_same = |other: &(Isometry2<f64>, Point2<f64>)| {
            (other.0 * pose).translation.vector.metric_distance(&again.pose.translation.vector) < SAME_HOME_M
        };
        let here_m = Point2::from(pose.translation.vector);
        self.seen_home.retain(|other| is_same(other) && (other.1 - here_m).norm() > MOVED_M);
        self.seen_home.push((correction, here_m));
        let sees = is_near || self.seen_home.len() >= SEEN_HOME;
        if sees {
            self.correction = correction;
        }
        sees
    }

    /// Where home is, as tracked, once the vehicle flies there and free cells lead to it: home need not be a place.
    pub(super) fn home_in_reach(&self, here_m: Point2<f64>, field: &Field) -> Option<Point2<f64>> {
        let home_m = self.correction.inverse() * Point2::origin();
        let far_m = (home_m - here_m).norm();
        let is_in_reach = |cost_m: f64| cost_m < MOST_DETOUR * far_m + 1.0;
        (self.goes_home && !self.is_elsewhere && field.cost_at_m(home_m).is_some_and(is_in_reach)).then_some(home_m)
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::Limits;
    use crate::planner::planners;
    use crosscut_stage::{Point, Revolution};

    pub(crate) fn navigator() -> Navigator {
        let limits = Limits { speed_max_m_s: 1.5, turn_rate_max_rad_s: 1.0, radius_m: 0.3 };
        Navigator::new((planners()[0].new)(), limits)
    }

    /// A vehicle on its way home in a room of 12 m about home, 4.5 m beside it, with a wall in between or without.
    fn in_reach(has_wall: bool) -> bool {
        let mut navigator = navigator();
        navigator.goes_home = true;
        let pose = Isometry2::translation(4.5, 0.0);
        let along = || (-60..=60).map(|i| 0.1 * f64::from(i));
        let sides = along().flat_map(|m| [[m, 6.0], [m, -6.0], [6.0, m], [-6.0, m]]);
        let wall = along().map(|m| [2.0, m]).filter(|_| has_wall);
        let is_seen = |[x, _]: &[f64; 2]| !has_wall || *x >= 2.0;
        let points_m = sides.chain(wall).filter(is_seen).map(|[x, y]| Point::new(x - 4.5, y, 0.0)).collect();
        let revolution = Revolution { points_m, ..Revolution::default() };
        (0..4).for_each(|_| navigator.surround.add(&revolution, &pose));
        let here_m = Point2::new(4.5, 0.0);
        navigator.home_in_reach(here_m, &navigator.surround.field(here_m)).is_some()
    }

    #[test]
    fn home_beside_the_way_is_in_reach_and_behind_a_wall_it_is_not() {
        assert!(in_reach(false));
        assert!(!in_reach(true));
    }

    /// What is seen in a room of 8 m by 6 m with a corner cut off, `x_m` and `y_m` from its middle.
    fn in_room(x_m: f64, y_m: f64, corner: [f64; 2]) -> Frame {
        let corners = [[4.0, -3.0], corner, [-4.0, 3.0], [-4.0, -3.0], [4.0, -3.0]];
        let side = |ends: &[[f64; 2]]| {
            let [from, to] = [ends[0], ends[1]];
            (0..60).map(move |step| [0, 1].map(|axis| from[axis] + (to[axis] - from[axis]) * f64::from(step) / 60.0))
        };
        let points_m = corners.windows(2).flat_map(side).map(|[x, y]| Point::new(x - x_m, y - y_m, 0.0)).collect();
        Frame { revolution: Revolution { points_m, ..Revolution::default() }, ..Frame::default() }
    }

    #[test]
    fn home_by_the_map_is_home_only_where_it_looks_like_the_start() {
        let start = in_room(0.0, 0.0, [2.0, 3.0]);
        for (there, is_home) in [(in_room(1.0, 0.5, [2.0, 3.0]), true), (in_room(1.0, 0.5, [6.0, 9.0]), false)] {
            let mut navigator = navigator();
            let mapper = Mapper::default();
            navigator.is_home(&start, None, &Isometry2::identity(), &mapper);
            navigator.goes_home = true;
            let pose = Isometry2::translation(0.4, 0.1); // it has drifted
            let ends = (0..60).any(|_| navigator.is_home(&there, None, &pose, &mapper));
            assert_eq!((ends, navigator.is_elsewhere), (is_home, !is_home));
            let off_m = (navigator.correction * pose).translation.vector - nalgebra::Vector2::new(1.0, 0.5);
            assert!(!is_home || off_m.norm() < 0.1, "{off_m}: the map is corrected");
        }
    }
}
