//! Second stage: from the weighted graph to the eigenvalues of its Laplacian, how many are zero, and the embedding U.
//!
//! In: [`Affinity`], W (n×n, dense or sparse) and the degrees D. Out: [`Spectrum`], λ ascending, the number k of zeros
//! with its margin, and U (n×k), whose columns are unit eigenvectors of the k smallest eigenvalues of
//!
//! L = I - D^-1/2 W D^-1/2 (the paper's equation 2). In exact arithmetic 0 = λ_1 <= … <= λ_n <= 2 (equation 3), and as
//! many eigenvalues are 0 as the graph has components. Computed ones carry rounding errors of some n·2.2e-16: a zero
//! may come out as -3e-16, and is kept as computed. Eigenvalues below τ ([`ZERO_TOLERANCE`]) count as zero.
//!
//! | kind | method | λ | for |
//! |---|---|---|---|
//! | `faer` | full decomposition, one thread, working memory kept | all n | the reference, and all eigenvalues |
//! | `slicing` | inertia of L - τI, then block Krylov spaces of its inverse, connected part by part | as many as asked for | the paper |
//! | `blocks` | weak edges set aside with a bound, banded factorisation of each block | the k zeros and the next | sparse graphs |
//! | `components` | weak edges left out, union-find, no decomposition | the k zeros, exact | the baselines, and what the spectrum adds |
//!
//! Each eigenvector is scaled by ±1 so that its entry of largest magnitude (the first of equals) is positive. With a
//! repeated eigenvalue, which k > 1 zeros always are, only the span of the eigenvectors is defined: compare U·Uᵀ.
//!
//! ```
//! use crosscut_spectral::faer_evd;
//! use crosscut_stage::{Affinity, Notes, Spectrum, SpectralStage};
//!
//! // Two returns with W_12 = 1/2, and one on its own.
//! let mut affinity = Affinity::default();
//! affinity.weights.make_dense(3).copy_from(faer::mat![[1.0, 0.5, 0.0], [0.5, 1.0, 0.0], [0.0, 0.0, 1.0]]);
//! affinity.sum_degrees();
//! let mut spectrum = Spectrum::default();
//! faer_evd::KIND.with(&[("zero_tolerance", 1e-8.into())])?.spectrum(&affinity, &mut spectrum, &mut Notes::default())?;
//! assert_eq!(spectrum.k, 2);
//! assert!((spectrum.eigenvalues[2] - 2.0 / 3.0).abs() < 1e-15);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! To add one: a file with its parameters, a `KIND` and the stage, and here its `mod` and its entry in [`KINDS`];
//! `tests/spectral/conformance.rs` then runs over it. [`Laplacian`] makes L; what follows a decomposition is shared.
//!
//! [`Affinity`]: crosscut_stage::Affinity
//! [`Spectrum`]: crosscut_stage::Spectrum

mod decomposition;
mod degrees;
mod dot;
mod embedding;
mod laplacian;
mod zeros;

pub mod blocks;
pub mod components;
pub mod faer_evd;
pub mod slicing;

use crosscut_stage::{Kind, SpectralStage};

pub use laplacian::Laplacian;
pub use zeros::{ZERO_TOLERANCE, recount};

/// A solver with working memory of n×n takes no more than this many such matrices: L, its factors, its eigenvectors and the
/// scratch of their decomposition.
pub const MOST_MATRICES: u64 = 6;

/// The solvers that crosscut ships, in the order in which messages list them; the first is the default.
pub const KINDS: &[Kind<dyn SpectralStage>] = &[faer_evd::KIND, slicing::KIND, blocks::KIND, components::KIND];
