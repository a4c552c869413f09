//! Mines with known truth, a lidar, and flights.
//!
//! In: the name of a scenario or of a suite, and a seed. Out: [`Scene`]s, each with a `LaserScan`, the [`Truth`] of its
//! noise-free view and, on a flight, the odometry. [`write_mcap`] writes them to a recording. Units are metres, radians
//! and seconds; the same seed always gives the same bytes.
//!
//! ```text
//! Network --union, bumps--> Surface --cast--> view (echo per beam) --loss, noise, dust--> readings --> LaserScan
//!    |                         |                     |                                       |
//!    +--centrelines------------+--walk outward--> Scenery (walls, openings) -----------------+-------> Truth
//! ```
//!
//! - [`network`]: a mine is a graph of tunnels with a centreline and a width along it, chambers, alcoves, pillars.
//!   Free space is the union of the swept tunnels.
//! - [`surface`]: the outline of free space in segments of 10 cm, displaced along the normal by Gaussian noise of
//!   standard deviation σ and correlation exp(-s²/2ℓ²) along the wall. A grid of 0.5 m limits the search of a ray.
//! - [`lidar`]: beams, field of view, range, noise, quantisation; loss at random, with range (∝ r²), at grazing
//!   incidence, on wet rock and in patches; dust; tilt (floor and roof); the distortion of a sweep while the vehicle moves.
//! - [`truth`]: openings and walls by the definitions of the vocabulary, stated there.
//! - [`vehicle`]: follows a route by pure pursuit, with disturbances of course, yaw, roll and pitch, and drifting
//!   odometry.
//! - [`Plan`]: a mine as its surveyor draws it, and a flight through all of it.
//! - [`network::Network::map`]: the map of a mine, and [`network::Network::place_at`]: what kind of place lies where.
//! - [`scenarios`]: flights by name. [`suites`]: families of scenes by name, with seeds for development and for
//!   reports.
//!
//! - [`Driven`]: a vehicle that obeys commands, with limits, disturbances and contact with the rock, in a [`World`];
//!   [`families`] has worlds to explore by name.
//!
//! [`Suite::clouds`] gives the places of a suite as seen by a lidar of many rings: [`Cloud`]s without beams.
//!
//! To add a scenario or a suite, add an entry to its list, and the function that the entry names.
//!
//! ```
//! use crosscut_simulator::{Split, scenarios, suites};
//!
//! let tee = scenarios().iter().find(|scenario| scenario.name == "tee").expect("there is one");
//! let first = (tee.fly)(1).next().expect("a flight has scans");
//! assert_eq!((first.scan.ranges.len(), first.truth.walls), (360, 2));
//!
//! let clean = suites().iter().find(|suite| suite.name == "clean6").expect("there is one");
//! let walls: Vec<u32> = clean.scenes(Split::Dev).take(5).map(|scene| scene.truth.walls).collect();
//! assert_eq!(walls, [1, 2, 3, 4, 5]);
//! ```
//!
//! [`Truth`]: crosscut_messages::Truth

mod cloud;
mod course;
mod driven;
mod exits;
mod grid;
mod junction;
pub mod lidar;
mod mine;
pub mod network;
mod noise;
mod outline;
mod plan;
pub mod pose;
mod presets;
pub mod reading;
mod recording;
mod scenario;
mod scene;
mod segment;
mod skeleton;
mod suite;
pub mod surface;
mod survey;
pub mod truth;
pub mod vehicle;
mod world;

pub use cloud::{Cloud, Rings};
pub use driven::{Agility, Driven};
pub use junction::Places;
pub use mine::Mine;
pub use plan::{Plan, PlanError};
pub use recording::{DESCRIPTION, RecordingError, SceneRecorder, write_mcap};
pub use scenario::{Scenario, scenarios};
pub use scene::{Flight, Scene};
pub use suite::{SCENES, Split, Suite, suites};
pub use world::{Family, World, families};
