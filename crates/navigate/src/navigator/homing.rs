//! The last metres: home is in reach, and the vehicle is there.

use nalgebra::Point2;

use crosscut_flight::Here;

use super::Navigator;
use crate::surround::Field;

/// The vehicle is home within this of where it started, by its own map, m.
const HOME_M: f64 = 3.0;

/// After this many revolutions there it is home whatever the place looks like; in passing it takes fewer.
const MOST_NEAR_HOME: u64 = 50;

/// The way over free cells to what is in reach is no longer than this many times the distance; near walls it counts more.
const MOST_DETOUR: f64 = 3.0;

impl Navigator {
    /// Whether the vehicle flies home and is there. The place looks as it did at the start; a map that is wrong may take
    /// another place for home in passing.
    pub(super) fn is_home(&mut self, here_m: Point2<f64>, steady: Option<&Here>) -> bool {
        let kind = steady.map(|here| here.kind);
        self.home_kind = self.home_kind.or(kind);
        if !self.goes_home || (self.correction * here_m).coords.norm() > HOME_M {
            self.near_home = 0;
            return false;
        }
        self.near_home += 1;
        kind == self.home_kind || self.near_home > MOST_NEAR_HOME
    }

    /// Where home is, as tracked, once the vehicle flies there and free cells lead to it: home need not be a place.
    pub(super) fn home_in_reach(&self, here_m: Point2<f64>, field: &Field) -> Option<Point2<f64>> {
        let home_m = self.correction.inverse() * Point2::origin();
        let far_m = (home_m - here_m).norm();
        let is_in_reach = |cost_m: f64| cost_m < MOST_DETOUR * far_m + 1.0;
        (self.goes_home && field.cost_at_m(home_m).is_some_and(is_in_reach)).then_some(home_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Limits;
    use crate::planner::planners;
    use crosscut_stage::{Point, Revolution};
    use nalgebra::Isometry2;

    /// A vehicle on its way home in a room of 12 m about home, 4.5 m beside it, with a wall in between or without.
    fn in_reach(has_wall: bool) -> bool {
        let limits = Limits { speed_max_m_s: 1.5, turn_rate_max_rad_s: 1.0, radius_m: 0.3 };
        let mut navigator = Navigator::new((planners()[0].new)(), limits);
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
}
