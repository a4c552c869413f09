//! The whole program at its process boundary: what is typed, what comes out, and how it ends.

mod comparison;
mod configuration;
mod corridors;
mod evaluation;
mod figures;
mod flight;
mod input;
mod interruption;
mod over_time;
mod overwriting;
mod paper;
mod program;
#[cfg(feature = "rerun")]
mod reading;
#[cfg(feature = "rerun")]
mod recording;
mod results;
#[cfg(feature = "rerun")]
mod serving;
mod simulation;
#[cfg(all(unix, feature = "rerun"))]
mod viewing;
mod words;
