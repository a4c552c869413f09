//! Section `recording` of the configuration: what a recording for the viewer holds. It never changes a result.

use crosscut_stage::{Count, Pairs, ParamSpec, Word};

/// How much of each revolution.
pub const DETAIL: Word = Word::one_of("detail", &["default", "light", "full"]).doc(
    "what is recorded of each revolution: light has no matrix, default W and L as pictures and U, and exact W and U of \
     some, full exact W and U of all",
);

/// How often exact matrices.
pub const EXACT_EVERY: Count = Count::new("exact_every", "revolutions", 0).doc(
    "exact W and U are recorded at every N-th recorded revolution; 0 = 300, or 1 with detail full; never with light",
);

/// Which revolutions.
pub const REVOLUTIONS: Pairs = Pairs::new("revolutions", "")
    .from(0.0)
    .to(f64::INFINITY)
    .doc("only these are recorded, by their seq, both ends included: [[100, 200], [500, inf]]; none = all");

/// Which times.
pub const SPANS_S: Pairs = Pairs::new("spans_s", "s")
    .from(0.0)
    .to(f64::INFINITY)
    .doc("only these times are recorded, after the first revolution, both ends included; none = all");

/// Size of a file.
pub const PART_REVOLUTIONS: Count = Count::new("part_revolutions", "revolutions", 6000)
    .from(1)
    .doc("a new file, FLIGHT-2.rrd, FLIGHT-3.rrd..., begins after this many");

/// All of them.
pub(crate) const PARAMS: &[ParamSpec] =
    &[DETAIL.spec, EXACT_EVERY.spec, REVOLUTIONS.spec, SPANS_S.spec, PART_REVOLUTIONS.spec];
