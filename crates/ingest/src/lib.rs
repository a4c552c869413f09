//! Recordings to revolutions.

mod sensor;

pub use sensor::{PARAMS, Sensor};
