//! The configuration: sections of parameters, resolved from layers.
//!
//! Layers are applied in order, each over the ones before: preset, file, single settings. Within a layer a section's
//! `kind` applies first, and a kind other than before replaces the section by that kind's defaults.

mod error;
mod layer;
mod print;
mod resolve;
mod retired;
mod schema;

pub use error::{ConfigError, nearest_and_all};
pub use layer::{Layer, Preset};
pub use resolve::Config;
pub(crate) use schema::MEMORY_MB;
