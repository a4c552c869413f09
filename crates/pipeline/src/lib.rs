//! Configuration, registry, engine, and the streaming pipeline.
//!
//! - [`Registry`]: which affinity, spectral and kmeans stages there are, by name.
//! - [`Settings`]: a preset and what is to be different from it, for a robot's own program.
//! - [`Config`]: presets, files and single settings in layers, checked against what the chosen stages declare.
//! - [`Engine`]: all stages on one revolution in the calling thread.
//! - [`Variants`]: several configurations on one revolution, each stage run once for all that share it.
//! - [`stream`]: the same stages, each in a thread of its own, over a whole recording, in order and with bounded memory.
//!
//! A robot's own program needs no other crate: see the example of [`Settings`].
//!
//! ```text
//!          +-> affinity -> spectral -> kmeans -+  lane 0
//! ingest --+-> affinity -> spectral -> kmeans -+--> report -> results, then observers
//!    ^     +-> affinity -> spectral -> kmeans -+  lane N-1              |
//!    +------------------- pool of frames <-----------------------------+
//! ```

mod config;
mod engine;
mod memory;
mod note_counts;
mod pace;
mod quantiles;
mod registry;
mod settings;
mod stop;
mod stream;
mod summary;
mod variants;

pub use crosscut_flight::Flight;
pub use crosscut_messages::LaserScan;
pub use crosscut_sensor::Sensor;
pub use crosscut_spectral::ZERO_TOLERANCE;
pub use crosscut_stage as stage;
pub use crosscut_stage::{Failure, Frame};

pub use config::{Config, ConfigError, Layer, Preset, nearest_and_all};
pub use engine::Engine;
pub use note_counts::{NoteCount, NoteCounts};
pub use registry::Registry;
pub use settings::Settings;
pub use stop::StopFlag;
pub use stream::{ResultsSink, StreamOptions, stream};
pub use summary::{Answers, End, StageTimes, Summary};
pub use variants::{Variants, settings_of_step};
