//! What the navigator answers to a frame.

use nalgebra::{Isometry2, Point2};

use crate::Command;

/// How a mission ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MissionEnd {
    /// The vehicle is home by its own map, and knows of nothing left to explore.
    Home,
    /// The vehicle could not get on.
    Stuck,
    /// Nothing new was found for longer than it takes to fly through the whole map more than twice.
    GaveUp,
}

impl MissionEnd {
    /// Its name in results.
    pub fn name(self) -> &'static str {
        match self {
            Self::Home => "home",
            Self::Stuck => "stuck",
            Self::GaveUp => "gave_up",
        }
    }
}

/// A decision at a place.
#[derive(Clone, Debug, PartialEq)]
pub struct PlaceDecision {
    /// Where it was taken, as tracked.
    pub at_m: Point2<f64>,
    /// The place on the map; `None` where the map has none.
    pub place: Option<usize>,
    /// The direction chosen, in the axes of the tracked poses.
    pub bearing_rad: f64,
    /// Why, in words.
    pub why: String,
}

/// What the navigator answers to a frame.
#[derive(Clone, Debug)]
pub struct PilotStep {
    /// What the vehicle is to do.
    pub command: Command,
    /// Where it is heading for, as tracked.
    pub goal_m: Point2<f64>,
    /// Brings tracked poses into the frame of the map.
    pub correction: Isometry2<f64>,
    /// What it is doing, in a word.
    pub doing: &'static str,
    /// The decision that was taken at this frame.
    pub decision: Option<PlaceDecision>,
    /// Set once the mission is over.
    pub end: Option<MissionEnd>,
}
