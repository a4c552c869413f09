//! From scans to commands: a vehicle explores an unknown mine with one 2D lidar, all of it, and returns.
//!
//! In: scans with the vehicle's odometry, a configuration of the detector, a planner. Out: a [`Command`] after each scan, and
//! the [`Map`](crosscut_flight::Map). Units are metres, radians and seconds; the same scans always give the same commands.
//!
//! ```text
//! scan, odometry --> Engine --> Flight --> Mapper --> Navigator --> Command
//!               walls, openings  pose, place  map      |     ^
//!                                               PlannerMap  WayChoice
//!                                                       v     |
//!                                                      Planner
//! ```
//!
//! - [`Navigator`] follows passages along the ways that the flight sees, goes to the middle of junctions and to the faces of
//!   dead ends, asks the planner there, and leaves by the way that it chose. It reads the returns of the scan, the place,
//!   the pose and the map.
//! - [`Planner`] chooses among the ways of a place, [`PlannerMap`]. [`planners`] has those that ship; another one is a file
//!   beside them with its entry there.
//! - [`Pilot`] is all of it for one vehicle, simulated or real: a scan and its odometry in, a command out.
//!
//! Between the places the vehicle flies over a grid of what the last scans saw to be free, along the middle between walls.

mod chart;
mod command;
mod known;
mod navigator;
mod pilot;
mod planner;
mod steering;
mod surround;
mod trail;

pub use command::{Command, Limits};
pub use known::{KnownPlace, KnownWay, PlannerMap, Route, WayState};
pub use navigator::{MissionEnd, Navigator, PilotStep, PlaceDecision};
pub use pilot::Pilot;
pub use planner::{Planner, PlannerKind, WayChoice, planners};
