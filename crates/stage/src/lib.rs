//! The vocabulary of crosscut: what travels through the pipeline, and the traits that a stage implements.
//!
//! ```text
//! Revolution --affinity--> Affinity --spectral--> Spectrum --kmeans--> Partition --report--> Junction
//!  n points                W (n×n), D             λ, k, U (n×k)        n labels             walls, openings, place
//! ```
//!
//! All five parts of one revolution, with the notes taken on the way, live in a [`Frame`]. A stage borrows the parts
//! that it reads and writes its own part in place, so that buffers are reused from one revolution to the next. A
//! stage knows nothing of channels, threads, files, clocks or recordings.
//!
//! To write a stage of your own: implement [`AffinityStage`], [`SpectralStage`] or [`KmeansStage`], declare its
//! parameters ([`Param`]) and a [`Kind`] (name, parameters, properties, how to build it), and append the kind to the
//! registry. The report that follows them is fixed.

mod affinity;
mod disjoint_sets;
mod evidence;
mod extra;
mod frame;
mod invariance;
mod junction;
mod kind;
mod known;
mod notes;
mod param;
mod params;
mod partition;
mod pose_doubt;
mod revolution;
mod spectrum;
mod traits;
mod unsure;
mod way;

pub use affinity::{Affinity, Csr, Measured, Verdict, Weights};
pub use disjoint_sets::DisjointSets;
pub use evidence::Evidence;
pub use extra::Extra;
pub use frame::{Failure, FailureCause, Frame, Step, Timings};
pub use invariance::Invariance;
pub use junction::{Junction, Opening, Place, SURE, Wall, junction_of};
pub use kind::{AffinityProperties, Eigenvalues, Kind, SpectralProperties, StageKind};
pub use known::{DEPTH_M, Known, KnownGaps};
pub use notes::{NOTES_PAGE, NoteCode, Notes, counted};
pub use param::{
    Count, Flag, Interval, Names, Number, Pairs, Param, ParamError, ParamErrorKind, ParamSpec, Shape, Word, value_text,
};
pub use params::Params;
pub use partition::Partition;
pub use pose_doubt::{MotionDoubt, PoseDoubt};
pub use revolution::{
    Beam, Fan, Revolution, Sweep, View, as_setting_rad, is_finite_pose, unit, widest_run, wrap_angle_rad,
};
pub use spectrum::Spectrum;
pub use traits::{AffinityStage, KmeansStage, Observer, ObserverError, Source, SourceError, SpectralStage, StageError};
pub use unsure::Unsure;
pub use way::{Between, Cell, Dual, Way, WayKind, degrees_words, direction_words};

pub use toml::Value;

/// Points are in R³ (metres); a 2D lidar has z = 0.
pub type Point = nalgebra::Point3<f64>;
