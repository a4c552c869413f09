//! Breaks in a flight, across which the scans do not lead: a recording that was interrupted, cut or played in a loop, or walls
//! that are not those before.

use std::fmt;

use crosscut_stage::NoteCode::{self, N094, N096};

/// Revolutions farther apart than this, and than this many usual intervals, are no neighbours.
const GAP_S: f64 = 2.0;
const GAP_INTERVALS: f64 = 5.0;

/// Stamps that are earlier than the one before by more than this jump back; by less, two scans came in another order.
const BACK_S: f64 = 1.0;

/// The usual interval follows this share of each difference.
const FOLLOWED: f64 = 0.1;

/// Finds gaps between stamps.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Clock {
    last_ns: Option<u64>,
    usual_s: Option<f64>,
}

/// From one stamp to the next, seconds; below 0 if the stamps jump back.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TimeGap(f64);

/// What a new stretch begins at, unless odometry leads across.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Break {
    Gap(TimeGap),
    /// Too few walls match those before: this share of their line points.
    Lost {
        matched: f64,
    },
}

impl Clock {
    /// The gap before a revolution, if there is one.
    pub(crate) fn gap(&mut self, stamp_ns: u64) -> Option<TimeGap> {
        let last_ns = self.last_ns.replace(stamp_ns)?;
        let since_s = (i128::from(stamp_ns) - i128::from(last_ns)) as f64 * 1e-9;
        // The first interval is taken to be a usual one.
        let usual_s = *self.usual_s.get_or_insert(since_s.max(0.0));
        if since_s < -BACK_S || since_s > GAP_S.max(GAP_INTERVALS * usual_s) {
            return Some(TimeGap(since_s));
        }
        self.usual_s = Some(usual_s + FOLLOWED * (since_s.max(0.0) - usual_s));
        None
    }
}

impl Break {
    /// The flight before it is another: nothing leads there.
    pub(crate) fn is_back(self) -> bool {
        matches!(self, Self::Gap(TimeGap(since_s)) if since_s < 0.0)
    }

    pub(crate) fn code(self) -> NoteCode {
        match self {
            Self::Gap(_) => N096,
            Self::Lost { .. } => N094,
        }
    }
}

impl fmt::Display for Break {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Lost { matched } => {
                write!(f, "lost, as only {:.0} % of the walls match those before", 100.0 * matched)
            }
            Self::Gap(TimeGap(since_s)) if self.is_back() => write!(f, "the stamps jump back by {:.1} s", -since_s),
            Self::Gap(TimeGap(since_s)) => write!(f, "{since_s:.1} s without a scan"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gaps(stamps_s: &[f64]) -> Vec<String> {
        let mut clock = Clock::default();
        let gap = |stamp_s: &f64| clock.gap((stamp_s * 1e9) as u64).map(|gap| Break::Gap(gap).to_string());
        stamps_s.iter().filter_map(gap).collect()
    }

    #[test]
    fn interruptions_and_loops_are_gaps_and_slow_or_swapped_scans_are_none() {
        assert_eq!(gaps(&[1.0, 1.1, 1.2, 13.2, 13.3]), ["12.0 s without a scan"]);
        assert_eq!(gaps(&[20.0, 20.1, 20.2, 1.0, 1.1]), ["the stamps jump back by 19.2 s"]);
        assert!(gaps(&[10.0, 20.0, 30.0, 55.0, 65.0]).is_empty());
        assert!(gaps(&[1.0, 1.1, 1.3, 1.2, 1.4]).is_empty());
    }
}
