//! Planners: which way to take at a place.

mod depth_first;
mod nearest_frontier;

use crate::known::Known;

/// Chooses ways.
pub trait Planner: Send {
    /// The way of the present place to take next; `None` once nothing is left to explore: the vehicle then flies home.
    fn choose(&mut self, known: &Known) -> Option<Choice>;
}

/// The way to take.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// Number of the way at the present place.
    pub way: usize,
    /// Why, in words.
    pub why: String,
}

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
