//! Missions in closed loop: a vehicle flies into an unknown mine with one 2D lidar, explores all of it, and returns.
//!
//! In: a [`World`](crosscut_simulator::World), a configuration of the detector, a planner, a seed. Out: [`Flown`], what was
//! visited, missed and flown, with the [`Map`](crosscut_flight::Map). Units are metres, radians and seconds; the same seed
//! always gives the same mission.
//!
//! ```text
//! Driven --scan, odometry--> Engine --> Flight --> Mapper --> Navigator --command--> Driven
//!                        walls, openings  pose, place  map      |     ^
//!                                                            Known  Choice
//!                                                               v     |
//!                                                              Planner
//! ```
//!
//! - [`Navigator`] follows passages along the ways that the flight sees, goes to the middle of junctions and to the faces of
//!   dead ends, asks the planner there, and leaves by the way that it chose. It reads the returns of the scan, the place,
//!   the pose and the map, and nothing of the truth.
//! - [`Planner`] chooses among the ways of a place, [`Known`]. [`planners`] has those that ship; another one is a file
//!   beside them with its entry there.
//! - [`Pilot`] is all of it for one vehicle, simulated or real: a scan and its odometry in, a command out.
//! - [`fly`] closes the loop over the simulator's vehicle, and judges by the truth.
//!
//! Between the places the vehicle flies over a grid of what the last scans saw to be free, along the middle between walls.

mod chart;
mod journal;
mod judge;
mod known;
mod mission;
mod navigator;
mod pilot;
mod planner;
mod steering;
mod surround;
mod trail;
mod ways;

pub use journal::{JournalError, read_journal};
pub use known::{Known, KnownPlace, KnownWay, Route, WayState};
pub use mission::{Flown, Moment, Setup, fly};
pub use navigator::{Decision, End, Navigator, Step};
pub use pilot::Pilot;
pub use planner::{Choice, Planner, PlannerKind, planners};
pub use steering::Limits;
