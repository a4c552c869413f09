//! Configuration, registry, engine, and the streaming pipeline.
//!
//! - [`Registry`]: which affinity, spectral and kmeans stages there are, by name.
//! - [`Config`]: presets, files and single settings in layers, checked against what the chosen stages declare.
//! - [`Engine`]: all steps on one revolution in the calling thread: for a robot's own program.
//! - [`stream`]: the same steps, each in a thread of its own, over a whole recording, in order and with bounded memory.
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
mod stop;
mod stream;
mod summary;

pub use config::{Config, ConfigError, Layer, PIPELINE_PARAMS, PRESETS, Schema};
pub use engine::Engine;
pub use note_counts::{NoteCount, NoteCounts};
pub use registry::Registry;
pub use stop::StopFlag;
pub use stream::{ResultsSink, StreamOptions, stream};
pub use summary::{End, StageTimes, Summary};
