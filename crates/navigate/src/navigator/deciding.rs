//! At a place: what the planner is told, what it chooses, and what is noted.

use std::f64::consts::PI;

use crosscut_flight::{FlightAnswer, HereKind, Located};
use crosscut_stage::{Beam, Frame, Revolution, unit, wrap_angle_rad};
use nalgebra::{Isometry2, Point2};

use super::answer::PlaceDecision;
use super::{Doing, Left, Navigator};
use crate::chart::{Noted, WayEnd, in_map};
use crate::known::{PlannerMap, Route, WayState};
use crate::planner::WayChoice;
use crate::trail::way_back_m;

/// If home is no farther, it need not be by one of the ways of the place, m.
const STRAIGHT_HOME_M: f64 = 15.0;

/// After this many decisions in a row without a route to a way that is left, the vehicle flies home.
const MOST_CUT_OFF: u32 = 6;

/// The direction of the way home is that of the place this far along it, m.
const BACK_M: f64 = 8.0;

/// A way without an opening whose end is nearer than this is not entered, m.
const SEEN_TO_END_M: f64 = 6.0;

/// Beams within this of the middle of such a way show its end.
const END_WITHIN_RAD: f64 = 0.15;

impl Navigator {
    /// Asks the planner, and begins to leave.
    pub(super) fn decide(
        &mut self,
        located: Option<Located>,
        kind: HereKind,
        frame: &Frame,
        pose: &Isometry2<f64>,
    ) -> PlaceDecision {
        let steady = FlightAnswer::of(frame).steady_here();
        let here_m = Point2::from(pose.translation.vector);
        let look_m = steady.map_or(3.0, |here| here.look_m);
        let (bearing_rad, place, why) = match &located {
            Some(located) => {
                self.correction = located.correction;
                self.map_m = located.map.passages.iter().map(|passage| passage.length_m).sum();
                let turn_rad = self.correction.rotation.angle();
                let in_view = steady.map_or_else(Vec::new, |here| in_map(&here.ways, pose, &self.correction));
                self.note_ends(located, frame, pose.rotation.angle() + turn_rad);
                let trail_m = self.trail.placed_m(&located.visits);
                self.chart.begins_midway = self.start.leads_on_behind(&trail_m);
                let known = self.chart.known(located, &trail_m, &in_view, self.course_rad + turn_rad);
                let (way, bearing_rad, why) = self.choose(located, &known, &trail_m);
                let way = way.and_then(|way| known.places[known.here].ways.get(way));
                if way.is_some_and(|way| way.state == WayState::New) {
                    self.last_new = self.now;
                }
                (bearing_rad - turn_rad, Some(WayEnd::new(located, bearing_rad)), why)
            }
            None if kind == HereKind::Junction => {
                let on = steady.and_then(|here| self.way_ahead(here, pose));
                let on_rad = on.map_or(self.course_rad, |way| way.bearing_rad + pose.rotation.angle());
                (on_rad, None, "straight on: the map has no place here".to_owned())
            }
            None => {
                let back_rad = self.back_rad(here_m, 2.5).unwrap_or(self.course_rad + PI);
                (back_rad, None, "back: no way ahead".to_owned())
            }
        };
        let bearing_rad = wrap_angle_rad(bearing_rad);
        self.course_rad = bearing_rad;
        (self.is_armed, self.is_elsewhere) = (false, false);
        let at_m = here_m;
        self.left = Some(Left { at_m, bearing_rad, look_m, kind, place });
        self.doing = Doing::Leave { began: self.now };
        self.goal_m = here_m + unit(bearing_rad) * look_m.clamp(1.5, 4.0);
        PlaceDecision { at_m, place: located.map(|located| located.node), bearing_rad, why }
    }

    /// The way to take, its direction in the frame of the map, and why.
    fn choose(
        &mut self,
        located: &Located,
        known: &PlannerMap,
        trail_m: &[Point2<f64>],
    ) -> (Option<usize>, f64, String) {
        let ways = &known.places[known.here].ways;
        let by = |choice: WayChoice| {
            let bearing_rad = ways.get(choice.way).map_or(known.heading_rad + PI, |way| way.bearing_rad);
            (Some(choice.way), bearing_rad, choice.why)
        };
        if let Some(choice) = self.planner.choose(known) {
            (self.goes_home, self.cut_off) = (false, 0);
            return by(choice);
        }
        if !self.goes_home {
            self.last_new = self.now; // the way home has its own limit
        }
        let first = located.map.first_visited().unwrap_or(0);
        // On the way back there may be a place from which a route leads to a way that is left.
        let is_left = (0..known.places.len()).any(|place| known.has_new_way(place));
        let is_cut_off = is_left && known.here != first && self.cut_off < MOST_CUT_OFF;
        self.cut_off += u32::from(is_cut_off);
        self.goes_home = !is_cut_off;
        let none = if is_cut_off { "no known route leads to a way not taken" } else { "no way is left to take" };
        if let Some(Route { way, length_m, .. }) = known.route(|place| place == first) {
            return by(WayChoice { way, why: format!("{none}; home is {length_m:.0} m away") });
        }
        // From the first place on, and where the map knows no route, the vehicle flies back the way that it came. Where that
        // led back to a place, it takes another way.
        let way_m = way_back_m(trail_m);
        let here_m = way_m.first().copied().unwrap_or_default();
        let ahead_m = way_m.iter().find(|place_m| (*place_m - here_m).norm() > BACK_M).or(way_m.last());
        let towards = ahead_m.map_or(-here_m.coords, |ahead_m| ahead_m - here_m);
        let home_rad = towards.y.atan2(towards.x);
        let left_m: f64 = way_m.windows(2).map(|step| (step[1] - step[0]).norm()).sum();
        let mut ways_rad: Vec<f64> = ways.iter().map(|way| way.bearing_rad).collect();
        if left_m < STRAIGHT_HOME_M {
            ways_rad.push(home_rad); // home may lie beside the ways
        }
        match self.chart.homewards(located, &ways_rad, home_rad) {
            Some(way) => {
                (Some(way), ways_rad[way], format!("{none}; back the way that it came, home in {left_m:.0} m"))
            }
            None => (None, home_rad, format!("{none}; straight towards home")),
        }
    }

    /// Notes the ways that are seen to end near by.
    fn note_ends(&mut self, located: &Located, frame: &Frame, yaw_rad: f64) {
        let ways = FlightAnswer::of(frame).here.iter().flat_map(|here| &here.ways);
        for way in ways.filter(|way| way.opening.is_none()) {
            if is_seen_to_end(&frame.revolution, way.bearing_rad) {
                let way = WayEnd::new(located, wrap_angle_rad(way.bearing_rad + yaw_rad));
                self.chart.note(way, Noted::Ended);
            }
        }
    }

    /// Notes whether the vehicle got into the way that it left a place by.
    pub(super) fn note_try(&mut self, left: &Left, led_into: bool) {
        if let Some(way) = left.place {
            self.chart.note(way, if led_into { Noted::Taken } else { Noted::Failed });
        }
    }
}

/// Whether nearly every beam about a bearing returns from near by.
fn is_seen_to_end(revolution: &Revolution, bearing_rad: f64) -> bool {
    let Some(sweep) = revolution.beams() else { return false };
    let about = sweep.bearings_rad.iter().zip(&sweep.beams);
    let about = about.filter(|(beam_rad, _)| wrap_angle_rad(**beam_rad - bearing_rad).abs() < END_WITHIN_RAD);
    let (mut near, mut all) = (0, 0);
    for (_, beam) in about {
        let range_m = match beam {
            Beam::Return(number) => revolution.range_m(*number as usize),
            Beam::NoReturn | Beam::Unknown => f64::INFINITY,
        };
        if range_m.is_finite() && range_m > SEEN_TO_END_M {
            return false;
        }
        all += 1;
        near += u32::from(range_m.is_finite());
    }
    all > 0 && f64::from(near) > 0.8 * f64::from(all)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chart::tests::in_a_row;
    use crate::navigator::homing::tests::navigator;

    #[test]
    fn home_is_beyond_the_place_visited_first_wherever_decided_first() {
        let mut navigator = navigator();
        let trail_m = [Point2::new(-10.0, 0.0), Point2::new(0.0, 0.0), Point2::new(20.0, 0.0)];
        let mut why = |node: usize| {
            let located = Located { node, ..in_a_row() };
            let known = navigator.chart.known(&located, &trail_m, &[], 0.0);
            navigator.choose(&located, &known, &trail_m).2
        };
        assert_eq!(why(1), "no way is left to take; home is 20 m away");
        assert!(why(0).starts_with("no way is left to take; back the way that it came"), "{}", why(0));
    }

    #[test]
    fn a_mission_cut_off_from_a_new_way_does_not_end_at_home() {
        let mut navigator = navigator();
        let trail_m = [Point2::new(-10.0, 0.0), Point2::new(20.0, 0.0)];
        let mut goes_home_from = |node: usize| {
            let mut located = Located { node, ..in_a_row() };
            located.map.nodes[2].ways[1].taken = false;
            let known = navigator.chart.known(&located, &trail_m, &[], 0.0);
            navigator.choose(&located, &known, &trail_m);
            navigator.goes_home
        };
        assert!(!goes_home_from(1), "no route leads to the new way");
        assert!(goes_home_from(0), "nor from the first place");
        let often = (0..MOST_CUT_OFF + 1).map(|_| goes_home_from(1)).collect::<Vec<_>>();
        assert!(often.last() == Some(&true), "{often:?}");
    }
}
