//! Planners: which way to take at a place.

mod depth_first;
mod nearest_frontier;

use crosscut_stage::wrap_angle_rad;

use crate::known::{PlannerMap, WayState};

/// Chooses ways.
pub trait Planner: Send {
    /// The way of the present place to take next; `None` once nothing is left to explore: the vehicle then flies home.
    fn choose(&mut self, known: &PlannerMap) -> Option<WayChoice>;
}

/// The way to take.
#[derive(Clone, Debug, PartialEq)]
pub struct WayChoice {
    /// Number of the way at the present place.
    pub way: usize,
    /// Why, in words.
    pub why: String,
}

impl WayChoice {
    /// The way of the present place that was not taken and is nearest to straight ahead.
    fn here(known: &PlannerMap) -> Option<Self> {
        let way = known.straightest_new_way()?;
        let ways = &known.places[known.here].ways;
        let turn_deg = wrap_angle_rad(ways[way].bearing_rad - known.heading_rad).to_degrees();
        let side = if turn_deg > 0.0 { "left" } else { "right" };
        let turn = if turn_deg.abs() < STRAIGHT_DEG {
            "straight ahead".to_owned()
        } else {
            format!("{:.0}° to the {side}", turn_deg.abs())
        };
        let new = ways.iter().filter(|way| way.state == WayState::New).count();
        let of_several = if new > 1 { format!(": the straightest of {new} here") } else { String::new() };
        Some(Self { way, why: format!("a way not taken, {turn}{of_several}") })
    }
}

/// Turns that are smaller are straight ahead.
const STRAIGHT_DEG: f64 = 10.0;

/// A planner with a name.
#[derive(Clone, Copy, Debug)]
pub struct PlannerKind {
    /// Its name.
    pub name: &'static str,
    /// Description in one line.
    pub doc: &'static str,
    /// Makes one.
    pub new: fn() -> Box<dyn Planner>,
}

/// All planners.
pub fn planners() -> &'static [PlannerKind] {
    &[nearest_frontier::KIND, depth_first::KIND]
}
