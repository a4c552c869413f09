//! Mines with known truth, a lidar, flights.

mod course;
mod exits;
mod grid;
mod junction;
pub mod lidar;
mod mines;
pub mod network;
mod noise;
mod outline;
mod recording;
pub mod scenario;
pub mod scene;
mod skeleton;
pub mod suite;
pub mod surface;
pub mod truth;
pub mod vehicle;

pub use recording::{RecordingError, write_mcap};
pub use scenario::{Scenario, scenarios};
pub use scene::{Flight, Scene};
pub use suite::{Split, Suite, suites};
