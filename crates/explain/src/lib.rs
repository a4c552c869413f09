//! Why the count of a revolution is what it is.
//!
//! In: a finished [`Frame`](crosscut_stage::Frame). Out: the links of W that decide its count ([`Explanation`]), the
//! same in words ([`Explanation::to_markdown`]), and which revolutions of a flight are worth a look ([`Watch`]).
//!
//! A wall is held together by its **weakest link**: the smallest weight on its maximum spanning tree (its bottleneck);
//! without it the wall falls into two sides A and B. It is kept apart from the others by its **strongest link** to a
//! return of another wall. What either does to the eigenvalues is told by the Rayleigh quotient of L on the vector that
//! is constant on each side,
//!
//! ```text
//! q(A, B) = cut(A, B) (1 / vol A + 1 / vol B),   cut(A, B) = Σ W_ij over i in A, j in B,   vol A = Σ D_ii over i in A
//! ```
//!
//! an upper bound of the eigenvalue of that split, and for weights that differ by decades a close one. An eigenvalue is
//! put down to a link only where the two agree within a decade.
//!
//! Cost: O(n²) for a dense W, O(e log e) for a sparse one with e entries.

mod bottleneck;
mod change;
mod closest;
mod links;
mod watch;
mod words;

pub use change::Change;
pub use links::{Explanation, Link, WallLinks};
pub use watch::{Event, Watch};
pub use words::inequality;
