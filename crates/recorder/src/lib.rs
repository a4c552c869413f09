//! Frames to Rerun recordings.
//!
//! [`Recorder`] is an observer: it sees every finished [`Frame`](crosscut_stage::Frame), in order, and writes all of it
//! to an .rrd file that the Rerun viewer opens with a layout, or to a viewer at once, or to both. No other crate knows
//! of Rerun.
//!
//! Timelines: `revolution` (the message's index) and `stamp` (the sensor's time). No wall clock.
//!
//! | entity | what | shape, unit | precision |
//! |---|---|---|---|
//! | `/scan/returns` | returns, class = wall | n points, m, body frame | f32 |
//! | `/scan/ranges`, `/scan/seen` | ranges as on the wire; what each beam saw | beams, m | exact |
//! | `/scan/beams`, `/scan/beams/wire` | bearings and wire geometry, logged when they change | beams, rad | exact |
//! | `/scan/walls` | lines along the walls, broken at gaps | m | within 3 cm |
//! | `/scan/openings` | arrows and widths; bearing and width as a tensor | openings × 2, rad and m | f32; exact |
//! | `/affinity/W`, `/spectral/L` | pictures of log10 of the absolute value over [-16, 0] | by beam, up to n = 1024 | a decade a level |
//! | `/affinity/degrees` | D | n | f32 |
//! | `/spectral/eigenvalues`, `/tolerance`, `/k`, `/margin` | λ (the 64 smallest, or k + 1), τ, k, margin | | exact |
//! | `/spectral/chart/...` | λ and τ drawn on a logarithmic scale | | drawing |
//! | `/spectral/U` | U | n×k | f32 |
//! | `/spectral/embedding` | the first three columns of U, scaled to reach 1 | n points | drawing |
//! | `/kmeans/labels`, `/kmeans/centroids` | labels (-1: none), centres; both also drawn | n; clusters×k | exact |
//! | `/report/junctions`, `/confidence`, `/place`, `/summary` | the answer | | exact; words |
//! | `/timing/<stage>` | time of each step | ms | exact |
//! | `/log`, `/config`, `/about` | notes; configuration as TOML; what is exact | | words |
//!
//! In the pictures, return i stands at the pixel of its beam, so that walls stay in place and openings are dark bands; the
//! side is the number of beams rounded up to a multiple of 64. Without beams, or with more than 1024, return i stands at
//! pixel i of 1024. A value of 1e-16 or more reads back within half a decade. Raw ranges and configuration let anybody
//! recompute W, L and U in full precision, so exact matrices need not be stored; where they are wanted, they go to an
//! entity of their own, `/affinity/W/exact`. L is computed here, from W and the degrees: no stage builds anything for
//! the recording alone.
//!
//! An empty revolution writes empty values, so that nothing of the one before stays on the screen; a picture that is not
//! there is dark.
//!
//! The file: chunks are cut by sensor time alone, so that equal flights make equal chunks; what a killed process leaves
//! behind lacks at most the last 1.5 s of the flight, and opens. Row ids hold the time of writing, so the bytes of two
//! recordings differ. A write that fails (full disk) is an error of the next call, and the file ends with its last whole
//! message.
//!
//! To log something new: a function in the file of its area, taking the stream and the frame; a line in `about.md` and
//! in the table above; a view in `layout.rs`.

mod beam_order;
mod colors;
mod file;
mod layout;
mod live;
mod matrices;
mod partition;
mod parts;
mod reading;
mod recorder;
mod report;
mod scan;
mod serving;
mod spectrum;
mod tensors;
mod viewer;

pub use reading::{
    Array, Component, Damage, Difference, Differences, Entity, Numbers, ReadError, Recording, Row, Rows, Value,
    differences,
};
pub use recorder::{Recorder, RecorderError, RecorderOptions};
pub use serving::Served;
