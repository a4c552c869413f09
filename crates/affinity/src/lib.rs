//! First stage: from the returns of one revolution to a weighted graph over them.
//!
//! In: [`Revolution`], n points in R³, metres (a 2D lidar has z = 0), in message beam order, with or without the beams
//! behind them. Out: [`Affinity`], W (n×n, symmetric, 0 <= W_ij <= 1, W_ii = 1; dense or sparse) and the degrees
//! D_ii = Σ_j W_ij (n entries), summed in a fixed order.
//!
//! | kind | W_ij for i ≠ j | stored |
//! |---|---|---|
//! | `rbf` | exp(-σ ‖x_i - x_j‖²), the paper's equation (1) | dense |
//! | `threshold` | 1 if ‖x_i - x_j‖ <= radius, else 0 | sparse |
//! | `breakpoint` | 1 between neighbouring beams without a jump of the range, else 0; needs beams | sparse |
//! | `clear_width` | 1 between neighbours of one wall, which ends at gaps as wide as a vehicle, else 0; needs beams | sparse |
//! | `directions` | exp(-σ ‖e_i - e_j‖²) between neighbouring *directions* in which the vehicle gets on, else 0 | sparse |
//! | `passage` | Π exp(-cost) over the gaps between i and j along one wall, else 0 | sparse |
//!
//! `threshold`, `breakpoint` and `clear_width` are baselines. Each clusters by the components of its 0/1 graph, and goes
//! through the same stages as the rest: their components are its zero eigenvalues. Their defaults were chosen on the
//! development scenes of the simulator, with small components left out (kmeans `components`, `min_cluster`).
//!
//! A kind states how it stores W, and which changes of the revolution leave W alone ([`Kind`]).
//!
//! ```
//! use crosscut_affinity::rbf;
//! use crosscut_stage::{Affinity, AffinityStage, Notes, Point, Revolution};
//!
//! let one_metre_apart = vec![Point::origin(), Point::new(1.0, 0.0, 0.0)];
//! let revolution = Revolution { points_m: one_metre_apart, ..Default::default() };
//! let mut affinity = Affinity::default();
//! rbf::KIND.with(&[("sigma_per_m2", 1.5.into())])?.affinity(&revolution, &mut affinity, &mut Notes::default())?;
//! assert!((affinity.degrees[0] - (1.0 + (-1.5f64).exp())).abs() < 1e-15);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! To add one: a file with its parameters, a `KIND` and the stage (`threshold.rs` is the shortest example), and here its
//! `mod` and its entry in [`KINDS`]. `tests/affinity/conformance.rs` then runs over it. A kind kept elsewhere is
//! appended to the registry.
//!
//! [`Revolution`]: crosscut_stage::Revolution
//! [`Affinity`]: crosscut_stage::Affinity

mod edges;

pub mod breakpoint;
pub mod clear_width;
pub mod directions;
pub mod passage;
pub mod rbf;
pub mod threshold;

use crosscut_stage::{AffinityStage, Kind};

/// The affinities that crosscut ships, in the order in which messages list them; the first is the default.
pub const KINDS: &[Kind<dyn AffinityStage>] =
    &[rbf::KIND, passage::KIND, clear_width::KIND, threshold::KIND, breakpoint::KIND, directions::KIND];
