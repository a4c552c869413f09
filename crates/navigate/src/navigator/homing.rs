//! Home: what was seen there at the start, the last metres of the way back, and whether the vehicle is there.

use nalgebra::{Isometry2, Point2};

use crosscut_flight::{Here, HereKind, Look, Mapper};
use crosscut_stage::{Frame, wrap_angle_rad};

use super::Navigator;
use crate::surround::Field;

/// The vehicle is home within this of where it started, m.
const HOME_M: f64 = 3.0;

/// The walls around the start are those in view within this of it, from places this far apart, m.
const START_WITHIN_M: f64 = 1.5;
const START_EVERY_M: f64 = 0.7;

/// At home, the walls in view lie on those of the start by this share. In the simulated mines it was 0.95 and more; 9 m and more
/// away it was 0.84 or less in all but one of 5,000 scans, and up to 0.93 in a straight passage.
const LEAST_SHARE: f64 = 0.87;

/// They are compared at every n-th revolution where the vehicle may be at home: within this many standard deviations of where
/// it is by the map, and within this, m.
const COMPARED_EVERY: u64 = 5;
const DEVIATIONS: f64 = 3.0;
const FARTHEST_M: f64 = 30.0;

/// Farther away by the map than home may be, they lie so by this share this often, from places that are farther apart than this, m, and
/// within this of each other, m.
const SURE_SHARE: f64 = 0.96;
const SEEN_HOME: usize = 4;
const MOVED_M: f64 = 0.3;
const SAME_HOME_M: f64 = 0.5;

/// After this many revolutions there, what cannot be compared is home, and what does not look like it is not.
const MOST_NEAR_HOME: u64 = 50;

/// The way over free cells to what is in reach is no longer than this many times the distance; near walls it counts more.
const MOST_DETOUR: f64 = 3.0;

/// The vehicle left the start towards where it was this far from it first, m.
const LEFT_M: f64 = 5.0;

/// A way of the start that is farther than this from the direction in which the vehicle left is another one.
const OTHER_WAY_RAD: f64 = 1.0;

/// What the vehicle saw where it started, which is home.
#[derive(Clone, Debug, Default)]
pub(super) struct Start {
    look: Look,
    /// Where the walls were seen from.
    from_m: Vec<Point2<f64>>,
    /// Of each revolution: how sure its place is, and the directions of the ways of a passage that are not seen to end.
    open_rad: Vec<(f64, Vec<f64>)>,
    has_left: bool,
}

impl Start {
    /// Takes what is seen around the start, until the vehicle has left it.
    fn add(&mut self, frame: &Frame, seen: Option<&Here>, pose: &Isometry2<f64>) {
        let here_m = Point2::from(pose.translation.vector);
        self.has_left |= here_m.coords.norm() > START_WITHIN_M;
        if self.has_left {
            return;
        }
        if self.from_m.iter().all(|from_m| (from_m - here_m).norm() >= START_EVERY_M) {
            self.from_m.push(here_m);
            self.look.add(frame, pose);
        }
        if let Some(here) = seen {
            let is_passage = here.kind == HereKind::Passage;
            let open = here.ways.iter().filter(|way| is_passage && way.opening.is_some());
            let open_rad = open.map(|way| wrap_angle_rad(way.bearing_rad + pose.rotation.angle())).collect();
            self.open_rad.push((here.confidence, open_rad));
        }
    }

    /// Whether the start is in a passage that leads on behind the vehicle, whose trail this is.
    pub(super) fn leads_on_behind(&self, trail_m: &[Point2<f64>]) -> bool {
        let Some(left) = trail_m.iter().find(|place_m| place_m.coords.norm() > LEFT_M) else { return false };
        let left_rad = left.y.atan2(left.x);
        let is_other = |way_rad: &f64| wrap_angle_rad(way_rad - left_rad).abs() > OTHER_WAY_RAD;
        let votes =
            self.open_rad.iter().map(|(sure, open_rad)| if open_rad.iter().any(is_other) { *sure } else { -sure });
        votes.sum::<f64>() > 0.0
    }
}

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
    use crosscut_flight::Way;
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

    #[test]
    fn a_start_in_a_passage_leads_on_behind_unless_its_end_is_seen() {
        let way = |bearing_rad: f64, opening: Option<usize>| Way { bearing_rad, width_m: 3.0, opening };
        let trail_m = [0.0, 3.0, 6.0].map(|x_m| Point2::new(x_m, 0.0));
        for (kind, behind, leads_on) in
            [(HereKind::Passage, Some(1), true), (HereKind::Passage, None, false), (HereKind::Junction, Some(1), false)]
        {
            let ways = vec![way(0.1, Some(0)), way(3.0, behind)];
            let here = Here { kind, look_m: 4.5, ways, is_middle: false, confidence: 0.9 };
            let mut start = Start::default();
            start.add(&in_room(0.0, 0.0, [4.0, 3.0]), Some(&here), &Isometry2::identity());
            assert_eq!(start.leads_on_behind(&trail_m), leads_on, "{kind:?} {behind:?}");
        }
    }
}
