//! Third stage: from the embedding U to a partition of the returns.
//!
//! In: [`Spectrum`], of which k and U (n×k) are read; row u_i is return i in the space of the eigenvectors, taken as it
//! is (the paper does not normalise rows). Out: [`Partition`], a label for each of the n returns, clusters numbered by
//! their first return, their centroids (clusters×k) and the objective of the paper's last equation,
//!
//! f(C, U) = Σ_i min_c∈C ‖u_i - c‖².
//!
//! | kind | clusters | for |
//! |---|---|---|
//! | `kmeans++` | k-means: k-means++ seeding, Lloyd's iteration, the best of several restarts | the paper |
//! | `components` | the columns of a U with one entry that is not 0 in each row | blocks of a sparse graph |
//!
//! ```
//! use crosscut_kmeans::kmeans_plus_plus;
//! use crosscut_stage::{KmeansStage, Notes, Partition, Spectrum};
//!
//! let u = faer::mat![[0.7, 0.0], [0.0, 1.0], [0.7, 0.0]];
//! let spectrum = Spectrum { k: 2, u, ..Spectrum::default() };
//! let mut partition = Partition::default();
//! let mut stage = kmeans_plus_plus::KIND.with(&[("restarts", 5.into())])?;
//! stage.partition(&spectrum, &mut partition, &mut Notes::default())?;
//! assert_eq!(partition.labels, [Some(0), Some(1), Some(0)]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! To add one: a file with its parameters, a `KIND` and the stage, and here its `mod` and its entry in [`KINDS`];
//! `tests/kmeans/conformance.rs` then runs over it.
//!
//! [`Spectrum`]: crosscut_stage::Spectrum
//! [`Partition`]: crosscut_stage::Partition

mod lloyd;
mod no_zeros;
mod numbering;
mod rows;
mod seeding;

pub mod components;
pub mod kmeans_plus_plus;

use crosscut_stage::{Kind, KmeansStage};

/// The assignments that crosscut ships, in the order in which messages list them; the first is the default.
pub const KINDS: &[Kind<dyn KmeansStage>] = &[kmeans_plus_plus::KIND, components::KIND];
