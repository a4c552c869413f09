//! One body of tests for all planners.

use std::f64::consts::{FRAC_PI_2, PI};

use crosscut_flight::HereKind;
use crosscut_navigate::{KnownPlace, KnownWay, PlannerMap, WayState, planners};
use nalgebra::Point2;

fn way(bearing_rad: f64, state: WayState, leads_to: Option<(usize, f64)>) -> KnownWay {
    KnownWay { bearing_rad, state, leads_to }
}

fn place(x_m: f64, ways: Vec<KnownWay>) -> KnownPlace {
    let kind = if ways.len() > 2 { HereKind::Junction } else { HereKind::DeadEnd };
    KnownPlace { kind, position_m: Point2::new(x_m, 0.0), ways }
}

/// Three junctions in a row, each with a side way; the vehicle is in the middle and came from the first.
fn row(states: [WayState; 3]) -> PlannerMap {
    let taken = WayState::Taken;
    let places = vec![
        place(0.0, vec![way(0.0, taken, Some((1, 20.0))), way(FRAC_PI_2, states[0], None), way(PI, taken, None)]),
        place(
            20.0,
            vec![way(0.0, taken, Some((2, 10.0))), way(FRAC_PI_2, states[1], None), way(PI, taken, Some((0, 20.0)))],
        ),
        place(30.0, vec![way(0.0, taken, None), way(FRAC_PI_2, states[2], None), way(PI, taken, Some((1, 10.0)))]),
    ];
    PlannerMap { places, here: 1, heading_rad: 0.0 }
}

#[test]
fn a_new_way_here_is_taken_first() {
    for planner in planners() {
        let choice = (planner.new)().choose(&row([WayState::New; 3])).expect("there is a new way");
        assert_eq!(choice.way, 1, "{}", planner.name);
        assert!(!choice.why.is_empty());
    }
}

#[test]
fn of_several_new_ways_the_straightest_is_taken() {
    let mut known = row([WayState::Taken; 3]);
    known.places[1].ways =
        vec![way(1.2, WayState::New, None), way(-0.4, WayState::New, None), way(PI, WayState::Taken, None)];
    for planner in planners() {
        assert_eq!((planner.new)().choose(&known).map(|choice| choice.way), Some(1), "{}", planner.name);
    }
}

#[test]
fn without_a_new_way_here_the_route_leads_to_one() {
    for planner in planners() {
        let choose = |states| (planner.new)().choose(&row(states)).map(|choice| choice.way);
        assert_eq!(choose([WayState::New, WayState::Taken, WayState::Ended]), Some(2), "{}", planner.name);
        assert_eq!(choose([WayState::Blocked, WayState::Taken, WayState::New]), Some(0), "{}", planner.name);
    }
}

#[test]
fn nothing_new_and_what_cannot_be_reached_send_the_vehicle_home() {
    let mut cut = row([WayState::New, WayState::Taken, WayState::Taken]);
    cut.places[1].ways[2].leads_to = None;
    for planner in planners() {
        let done = row([WayState::Taken, WayState::Blocked, WayState::Ended]);
        assert_eq!((planner.new)().choose(&done), None, "{}", planner.name);
        assert_eq!((planner.new)().choose(&cut), None, "{}", planner.name);
    }
}
