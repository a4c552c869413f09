//! The whole program at its process boundary: arguments, outputs and exit codes.

mod comparison;
mod configuration;
mod debugging;
mod documented;
mod evaluation;
mod exploring;
mod field;
mod figures;
mod flight;
mod flying;
mod following;
mod headline;
#[cfg(feature = "rerun")]
mod importing;
mod input;
mod interruption;
mod maps;
mod messages;
mod notes;
mod overwriting;
mod pages;
mod program;
#[cfg(feature = "rerun")]
mod reading;
#[cfg(feature = "rerun")]
mod recording;
mod results;
mod sensors;
#[cfg(feature = "rerun")]
mod serving;
mod simulation;
#[cfg(all(unix, feature = "rerun"))]
mod viewing;
mod writing;
