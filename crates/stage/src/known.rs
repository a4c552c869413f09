//! How it is known whether a vehicle can pass at a gap.

use std::fmt;
use std::ops::AddAssign;

use serde::{Deserialize, Serialize};

/// What lies behind a gap through which a vehicle can pass is at least this deep, or not seen to be shallower, metres.
pub const DEPTH_M: f64 = 3.0;

/// How it is known whether a vehicle can pass at a gap: from the beams, from the returns, or by a decision.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Known {
    /// Open: the beams show a way as wide as the vehicle and 3 m long behind the gap, whatever a hidden wall does.
    Seen,
    /// Closed: wherever the vehicle's centre crosses the gap, a return is nearer than half of its width.
    Proved,
    /// A hidden wall could make it either; the affinity decides.
    #[default]
    Judged,
}

impl Known {
    /// Its name in results.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Seen => "seen",
            Self::Proved => "proved",
            Self::Judged => "judged",
        }
    }
}

impl fmt::Display for Known {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

/// How many gaps are known in each way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct KnownGaps {
    /// Openings that are seen through.
    pub seen: u64,
    /// Gaps that are proved to be closed.
    pub proved: u64,
    /// Openings and closed gaps that are judged.
    pub judged: u64,
}

impl KnownGaps {
    /// Counts a gap.
    pub fn add(&mut self, known: Known) {
        match known {
            Known::Seen => self.seen += 1,
            Known::Proved => self.proved += 1,
            Known::Judged => self.judged += 1,
        }
    }

    /// All of them.
    pub fn all(&self) -> u64 {
        self.seen + self.proved + self.judged
    }
}

impl AddAssign for KnownGaps {
    fn add_assign(&mut self, other: Self) {
        self.seen += other.seen;
        self.proved += other.proved;
        self.judged += other.judged;
    }
}
