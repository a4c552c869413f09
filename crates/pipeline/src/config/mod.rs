//! The configuration: sections of parameters, resolved from layers.
//!
//! Layers are applied in order, each over the ones before: preset, file, single settings. Within a layer a section's
//! `kind` applies first, and a kind other than before replaces the section by that kind's defaults.

mod layer;
mod print;
mod resolve;
mod schema;

pub use layer::{Layer, PRESETS};
pub use resolve::{Config, ConfigError};
pub use schema::{PIPELINE_PARAMS, Schema};
