//! Frames to Rerun recordings.
//!
//! [`Recorder`] is an observer: it sees every finished [`Frame`](crosscut_stage::Frame), in order, and writes all of it
//! to an .rrd file that the Rerun viewer opens with a layout, or to a viewer at once, or to both. `crosscut-rrd` reads
//! these files.
//!
//! Timelines: `revolution` (the message's index) and `stamp` (the sensor's time). No wall clock.
//!
//! | entity | what | shape, unit | precision |
//! |---|---|---|---|
//! | `/scan/returns`, `/scan/count` | returns, coloured by wall; how many | n points, m, body frame | f32; exact |
//! | `/scan/ranges`, `/scan/seen` | ranges as on the wire; what each beam saw | beams, m | exact |
//! | `/scan/beams`, `/scan/beams/wire` | bearings and wire geometry, logged when they change | beams, rad | exact |
//! | `/scan/mounting` | frame of the sensor by its name, turned in the body frame | | f32 |
//! | `/scan/walls` | lines along the walls, broken at gaps | m | within 3 cm |
//! | `/scan/openings` | arrows and widths; bearing and width as a tensor | openings × 2, rad and m | f32; exact |
//! | `/scan/links`, `/scan/links/edges` | the links that decide the count | m | drawing |
//! | `/affinity/W`, `/spectral/L` | pictures of log10 of the absolute value over [-16, 0], upper triangle | by beam, up to n = 1024 | a decade a level |
//! | `/affinity/W/exact`, `/spectral/U/exact` | W (upper triangle) and U, at some revolutions | n×n, n×k | exact |
//! | `/affinity/degrees` | D | n | f32 |
//! | `/affinity/links` | the links of a sparse W | m | drawing |
//! | `/spectral/eigenvalues`, `/tolerance`, `/k`, `/margin` | λ (the 32 smallest, or k + 1), τ, k, margin | | exact |
//! | `/spectral/chart/...` | λ, τ and k drawn on a logarithmic scale | | drawing |
//! | `/spectral/U` | U | n×k | f16 |
//! | `/spectral/embedding` | the first three columns of U, scaled to reach 1 | n points | drawing |
//! | `/kmeans/labels`, `/kmeans/centroids` | labels (-1: none), centres; both also drawn | n; clusters×k | exact |
//! | `/kmeans/blocks`, `/kmeans/profile/...` | walls as frames on W; ranges, clusters and walls by beam | | drawing |
//! | `/report/junctions`, `/confidence`, `/place`, `/summary` | the answer | | exact; words |
//! | `/report/labels`, `/report/walls` | wall of each beam; id, returns, bearings, island and class of each wall | beams; walls × 6 | exact |
//! | `/report/why` | why the count is what it is, with all notes | | words |
//! | `/affinity/scale`, `/report/axis` | what the colours of the pictures stand for; what plots of counts reach at least | | drawing |
//! | `/timing/<stage>`, `/timing/total`, `/timing/summary` | time of each step; of all, and from scan to scan; a table | ms | exact; words |
//! | `/recording/part` | which part of a long recording the file is, and whether another follows | | exact |
//! | `/log`, `/config`, `/about` | what is worth a look; configuration as TOML; what is exact | | words |
//!
//! In the pictures, return i stands at the pixel of its beam, so that walls stay in place and openings are dark bands;
//! the side is the number of beams rounded up to a multiple of 64. Without beams, or with more than 1024, return i
//! stands at pixel i of 1024. A value of 1e-16 or more reads back within half a decade. Raw ranges and configuration
//! let anybody recompute W, L and U in full precision. L is computed here, from W and the degrees: no stage builds
//! anything for the recording alone.
//!
//! [`Scope`] says how much of which revolutions is recorded. A wall has the class, and so the colour, of the wall that
//! lay in the same directions at the revolution before; results know nothing of it.
//!
//! An empty revolution writes empty values, so that nothing of the one before stays on the screen; a picture that is
//! not there is dark.
//!
//! The file: chunks are cut by sensor time alone, so that equal flights make equal chunks; what a killed process leaves
//! behind lacks at most the last 2.5 s of the flight, of a live one the last second, and opens. Row ids hold the time
//! of writing, so the bytes of two recordings differ. A write that fails (full disk) is an error of the next call, and
//! the file ends with its last whole message. After so many revolutions the file is ended and another begins, which
//! opens alone and together with it: the footer grows in memory with the file, and so memory stays flat. Each says which
//! it is, so that a missing one is noticed.
//!
//! A disk that is slower than the flight: a recorded flight waits for it. A live one (`--rate`) does not: what the disk
//! has not taken waits in memory, beyond 16 MB revolutions are recorded without matrices, beyond 40 MB not at all,
//! until the disk has caught up. `/log` says where, and the end says how many; the results are complete.
//!
//! To log something new: a function in the file of its area, taking the stream and the frame; a line in `about.md` and
//! in the table above; a view in `layout/views.rs`, on a page of `layout/pages.rs`.

mod backlog;
mod beam_order;
mod colors;
mod exact;
mod file;
mod layout;
mod live;
mod matrices;
mod mounting;
mod notes;
mod options;
mod partition;
mod parts;
mod polyline;
mod profile;
mod recorder;
mod report;
mod scan;
mod scope;
mod serving;
mod showing;
mod spectrum;
mod tensors;
mod timing;
mod tracks;
mod viewer;
mod why;

pub use crosscut_rrd::schema;
pub use layout::Layout;
pub use mounting::Mounting;
pub use options::{RecorderError, RecorderOptions};
pub use recorder::Recorder;
pub use scope::{Detail, Scope};
pub use serving::Served;
pub use showing::{Show, ShowError};
