//! The geometry of one revolution, before anything is decided: what affinity `passage` and the report both look at.
//!
//! In: the beams and points (metres, body frame) of a [`Sweep`](crosscut_stage::Sweep), and three [`Lengths`]. Out: a
//! [`Scan`]:
//!
//! | part | what it is |
//! |---|---|
//! | [`Ring`] | the n returns anticlockwise around the sensor, and what each beam in view saw |
//! | [`Pieces`] | the returns of walls, cut where two neighbours are a passage apart |
//! | [`Islands`] | short pieces that stand free in front of others |
//! | [`Roughness`] | how far returns lie off the line of their wall, and how inexact ranges are |
//! | size | the median range of the walls, at most 4.5 m |
//!
//! At the gap between two pieces, [`Clearance`] measures how far they leave each other's line, [`Doorway`] how wide a
//! door there is, and [`LostBeams`] how many beams a lidar loses where there is a wall.
//!
//! [`direction()`] gives the direction in which a piece ends, and [`Directions`] keeps them while pieces are joined and
//! cut. A cloud has no beams: where it comes in, [`LevelView`] makes the sweep of it that a level
//! vehicle would have.
//!
//! A `Scan` is a function of the sweep alone, made in place and then only read. A stage that needs it holds one and
//! makes it; frames and stage traits do not mention it, so that stages that need no geometry do not know of it.

mod clearance;
mod closed;
mod direction;
mod doorway;
mod dust;
mod islands;
mod lengths;
mod level_view;
mod lost;
pub mod mixed;
mod pieces;
mod ring;
mod roughness;
mod scan;
mod vehicle;

use std::cmp::Ordering;

pub use clearance::Clearance;
pub use closed::is_closed_by_returns;
pub use direction::{Directions, direction};
pub use doorway::{DOORWAY_TIMES, Doorway, beyond, lies_across};
pub use islands::{BEHIND_M, Islands, WIDEST_RAD, faces_dark};
pub use lengths::{ISLAND_M, Lengths};
pub use level_view::LevelView;
pub use lost::LostBeams;
pub use pieces::{End, LEAST_WALL_RETURNS, Pieces};
pub use ring::{Position, Return, Ring, turn_rad};
pub use roughness::Roughness;
pub use scan::Scan;
pub use vehicle::{VEHICLE_HEIGHT_M, VEHICLE_PARAMS, VEHICLE_WIDTH_M};

/// The median of some values by this order, which are reordered; 0 of none.
fn median<T: Copy + Default>(values: &mut [T], order: fn(&T, &T) -> Ordering) -> T {
    let middle = values.len() / 2;
    if values.is_empty() { T::default() } else { *values.select_nth_unstable_by(middle, order).1 }
}
