//! Partition of the returns -> walls, openings, the name of the place, and the line of results.
//!
//! In: a [`Revolution`](crosscut_stage::Revolution) of n returns, its [`Spectrum`](crosscut_stage::Spectrum) and its
//! [`Partition`](crosscut_stage::Partition) into clusters.
//! Out: a [`Junction`](crosscut_stage::Junction): walls with their bearings (rad, anticlockwise), openings with
//! bearing (rad), clear width (m) and evidence, the place, and a confidence in [0, 1].
//!
//! - A **wall** is a cluster (`walls.rs`); `junctions`, the paper's count, is the number of walls, islands left out.
//! - An **island** is a short wall in front of others (`islands.rs`), if `report.island_m` is more than 0.
//! - An **opening** is a gap where the affinity decided that a wall ends. For an affinity that decides nothing, it is an
//!   edge of the visible free space between two returns that follow each other around the sensor, through which the
//!   vehicle fits and behind which at least 3 m are not seen to be closed ([`openings`]).
//! - Each gap is **known** in one of three ways (`known.rs`): seen through, proved to be closed, or judged.
//! - A **way** is a cluster of directions, of affinities whose rows these are (`ways.rs`); the level ones are openings too.
//! - The **place** is named by the number of openings and by the angle between two (`place.rs`).
//! - **Confidence** is taken from the zero rule, 1 - 10^-margin, or from the scene, a share of right answers fitted to
//!   the odds of its gaps and to how clear the most doubtful ones are ([`confidence`], [`odds`]).
//!
//! [`ResultsLine`] is the one JSON object that a revolution becomes.

pub mod confidence;
mod doorway;
mod islands;
mod known;
pub mod odds;
pub mod openings;
mod place;
mod reporter;
mod results;
mod wall_ring;
mod walls;
mod ways;

pub use crosscut_scan::{VEHICLE_PARAMS, VEHICLE_WIDTH_M};
pub use reporter::{CONFIDENCE, PARAMS, Reporter};
pub use results::{
    HereLine, MAX_EIGENVALUES, OpeningLine, PoseLine, RESULTS_SCHEMA_NAME, RESULTS_SCHEMA_TEXT, ResultsLine,
    SteadyLine, WallLine, WayLine,
};
pub use wall_ring::WallRing;
