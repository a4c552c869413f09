//! Frames to Rerun recordings.
//!
//! [`Recorder`] is an observer: it gets every finished [`Frame`](crosscut_stage::Frame), in order, and writes it to an
//! .rrd file that the Rerun viewer opens with a layout, or sends it to a viewer at once, or both. `crosscut-rrd` reads
//! these files.
//!
//! Timelines: `revolution` (the message's index) and `stamp` (the sensor's time). No wall clock.
//!
//! [`schema::ENTITIES`] lists every entity: what it holds, its unit, its precision, and when it is written. Raw ranges
//! and configuration let anybody recompute W, L and U in full precision. L is computed here, from W and the degrees: no
//! stage builds anything for the recording alone.
//!
//! In the pictures of W and L, return i stands at the pixel of its beam, so that walls stay in place and openings are
//! dark bands; rows that are directions share the largest side. Else the side is the number of beams rounded up to a multiple of 64. Without beams, or with more than 1024,
//! return i stands at pixel i of 1024. A value of 1e-16 or more reads back within half a decade.
//!
//! [`Scope`] sets how much of which revolutions is recorded. A wall keeps the class, and so the colour, of the wall that
//! lay in the same directions at the revolution before; results do not depend on it.
//!
//! An empty revolution writes empty values, so that no older ones stay on the screen; a missing picture is dark.
//!
//! The file: chunks are cut by sensor time alone, so that equal flights make equal chunks. A killed process leaves a
//! file that opens and lacks at most the last quarter of the flight so far, 2.5 to 10 s or 64 revolutions, or the last second of a
//! live one. Row ids contain the
//! time of writing, so the bytes of two recordings differ. A failed write (full disk) is an error of the next call, and
//! the file ends with its last whole message. After a set number of revolutions the file is ended and another one
//! begins, which opens alone and together with it: Rerun keeps the footer in memory until the end of a file, and parts
//! bound it. Each part records its number, so that a missing one is noticed.
//!
//! A disk that is slower than the flight: a recorded flight waits for it. A live one (`--rate`) does not: its rows wait
//! in memory. Beyond 16 MB revolutions are recorded without matrices, beyond 40 MB not at all, until the disk has caught
//! up. `/log` reports where, and the end of the run reports how many; the results are complete.
//!
//! To record something new: an entity in [`schema`], a function in the file of its area that takes the frame, and a view
//! in `layout/views.rs` on a page of `layout/pages.rs`. The test `every_entity` then asks for a comparison.

mod as_read;
mod backlog;
mod beam_order;
mod below;
mod colors;
mod debug_view;
mod eigenvectors;
mod exact;
mod file;
mod flight_map;
mod gaps;
mod gate;
mod layout;
mod live;
mod matrices;
mod mine;
mod mission;
mod mounting;
mod notes;
mod numbers;
mod options;
mod outputs;
mod partition;
mod parts;
mod piped;
mod png;
mod polyline;
mod profile;
mod recorder;
mod report;
mod revolution;
mod rows;
mod scan;
mod scope;
mod serving;
mod showing;
mod spectrum;
mod tensors;
mod timing;
mod tracks;
mod truth;
mod viewer;
mod walls;
mod ways;
mod whole;
mod why;
mod words;

pub use crosscut_rrd::schema;
pub use debug_view::{Answered, Beside, DebugView};
pub use layout::Layout;
pub use mission::{MissionDecision, MissionMoment, MissionRecorder};
pub use mounting::Mounting;
pub use options::{RecorderError, RecorderOptions, StoreIds};
pub use recorder::Recorder;
pub use scope::{Detail, Scope};
pub use serving::Served;
pub use showing::{Show, ShowError};
pub use truth::TrueWalls;
pub use why::why;
