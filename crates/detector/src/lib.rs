//! Junction detection for a program of one's own: a scan in, walls and openings out.
//!
//! - [`Detector`]: the door. It owns the sensor, the method and its buffers.
//! - [`Settings`]: a preset with overrides, and stages of one's own, as values.
//! - [`Engine`]: all stages on one revolution in the calling thread, without a sensor.
//! - [`Registry`]: which affinity, spectral and kmeans stages there are, by name.
//! - [`Config`]: presets, files and single settings in layers, checked against what the chosen stages declare.
//!
//! ```text
//! LaserScan --Sensor--> Revolution --Engine: affinity -> spectral -> kmeans -> report--> Junction
//! ```
//!
//! [`stage`] has the vocabulary: what a [`Frame`] holds, and the traits of the stages.

mod config;
mod detector;
mod engine;
mod memory;
pub mod recording;
mod registry;
mod settings;

pub use crosscut_messages::LaserScan;
pub use crosscut_sensor::Sensor;
pub use crosscut_stage as stage;
pub use crosscut_stage::{Failure, Frame, Junction};

pub use config::{Config, ConfigError, Layer, Preset, nearest_and_all};
pub use detector::Detector;
pub use engine::{Engine, Worker, elapsed_ns, panic_text};
pub use registry::Registry;
pub use settings::Settings;
