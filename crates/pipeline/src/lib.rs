//! Streams: the stages of the method, each in a thread of its own, over a whole source, in order and with bounded memory.
//!
//! In: a [`Source`](crosscut_stage::Source) of revolutions and a [`Config`](crosscut_detector::Config). Out: each frame, to
//! the results, then to the observers, and a [`Summary`]. [`stream`] runs it; [`StopFlag`] ends it.
//!
//! ```text
//!          +-> affinity -> spectral -> kmeans -+  lane 0
//! ingest --+-> affinity -> spectral -> kmeans -+--> report -> results, then observers
//!    ^     +-> affinity -> spectral -> kmeans -+  lane N-1              |
//!    +------------------- pool of frames <-----------------------------+
//! ```

mod note_counts;
mod pace;
mod quantiles;
mod stop;
mod stream;
mod summary;

pub use note_counts::{NoteCount, NoteCounts};
pub use quantiles::Quantiles;
pub use stop::StopFlag;
pub use stream::{ResultsSink, StreamOptions, stream};
pub use summary::{Answers, RunEnd, StageTimes, Summary};
