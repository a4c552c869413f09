//! Missions in closed loop: a vehicle flies into a simulated mine that it does not know, explores all of it, and returns.
//!
//! In: a [`World`](crosscut_simulator::World), a configuration of the detector, a planner, a seed. Out: [`Flown`], what was
//! visited, missed and flown, with the [`Map`](crosscut_flight::Map). Units are metres, radians and seconds; the same seed
//! always gives the same mission.
//!
//! - [`fly`] closes the loop between the simulator's vehicle, [`Driven`](crosscut_simulator::Driven), and a
//!   [`Pilot`](crosscut_navigate::Pilot), which knows nothing of the truth, and judges the flight by the truth.
//! - [`Journal`] keeps what the vehicle sensed, so that a mission that was killed can be resumed.

mod journal;
mod judge;
mod mission;
mod resume_error;
mod scenes;
mod ways;

pub use journal::{About, Journal};
pub use mission::{Flown, Moment, Setup, fly};
pub use resume_error::ResumeError;
pub use scenes::read_journal;
