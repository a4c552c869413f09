//! Explains the count of a revolution.
//!
//! In: a finished [`Frame`](crosscut_stage::Frame). Out: the edges of W that decide its count ([`Explanation`]), their
//! description in words ([`Explanation::to_markdown`]), and the revolutions of a flight to look at first ([`Watch`]).
//!
//! The **weakest edge** of a wall is the smallest weight on its maximum spanning tree (the bottleneck): without it the wall
//! breaks into two sides A and B. The **strongest edge** of a wall to a return of another wall nearly joins the two. The
//! effect of either on the eigenvalues is estimated by the Rayleigh quotient of L on the vector that is constant on each
//! side,
//!
//! ```text
//! q(A, B) = cut(A, B) (1 / vol A + 1 / vol B),   cut(A, B) = Σ W_ij over i in A, j in B,   vol A = Σ D_ii over i in A
//! ```
//!
//! an upper bound of the eigenvalue of that split, and a close one for weights that differ by decades. An eigenvalue is
//! attributed to an edge only where the two agree within a decade.
//!
//! Cost: O(e log e) for a W with e entries.

mod bottleneck;
mod change;
mod closest;
mod doubtful;
mod edges;
mod judged;
mod nearest;
mod sentence;
mod wall_edges;
mod watch;
mod ways;
mod words;

pub use change::Change;
pub use edges::Explanation;
pub use judged::{Judged, judged};
pub use nearest::Nearest;
pub use wall_edges::{Edge, WallEdges};
pub use watch::{Doubt, Event, Watch};
pub use ways::ways;
pub use words::{inequality, wall, widths};
