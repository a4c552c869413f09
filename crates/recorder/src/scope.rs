//! How much is recorded of which revolution.

use std::num::NonZeroU64;
use std::ops::RangeInclusive;

use crosscut_stage::Frame;

/// A change of the count causes exact matrices at most this often in [`EVENTS_WITHIN`] revolutions; those of every N-th
/// revolution are not counted. With both, 6000 revolutions of 360 beams stay below 200 MB.
const MOST_EVENTS: u64 = 16;
/// Revolutions after which the count of events starts again. It does not depend on the parts of the recording.
const EVENTS_WITHIN: u64 = 6000;

/// How much of each revolution is recorded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Detail {
    /// Ranges, returns, eigenvalues, labels, answer, explanation and times; no matrix.
    Light,
    /// W and L as pictures and U of every revolution; exact W and U of some.
    #[default]
    Default,
    /// Exact W and U of every revolution as well.
    Full,
}

impl Detail {
    /// The N of "exact W and U at every N-th revolution" unless the user set one.
    fn exact_every(self) -> Option<NonZeroU64> {
        match self {
            Self::Light => None,
            Self::Default => NonZeroU64::new(300),
            Self::Full => Some(NonZeroU64::MIN),
        }
    }
}

/// What is recorded of a flight. The default is all of it.
#[derive(Clone, Debug)]
pub struct Scope {
    /// How much of each revolution.
    pub detail: Detail,
    /// Exact matrices at every N-th recorded revolution; `None`: the N of `detail`.
    pub exact_every: Option<NonZeroU64>,
    /// Revolutions that are recorded, by their `seq`; without a range all.
    pub revolutions: Vec<RangeInclusive<u64>>,
    /// Sensor time that is recorded, in seconds since the first revolution, which are negative after a clock was set back;
    /// without a range all.
    pub seconds: Vec<RangeInclusive<f64>>,
    /// Revolutions in one file; after them the recording continues in another.
    pub part_revolutions: NonZeroU64,
}

impl Scope {
    /// Ten minutes at 10 Hz.
    pub const PART_REVOLUTIONS: NonZeroU64 = NonZeroU64::new(6000).expect("not 0");

    fn contains(&self, seq: u64, since_first_s: f64) -> bool {
        (self.revolutions.is_empty() || self.revolutions.iter().any(|range| range.contains(&seq)))
            && (self.seconds.is_empty() || self.seconds.iter().any(|range| range.contains(&since_first_s)))
    }
}

impl Default for Scope {
    fn default() -> Self {
        Self {
            detail: Detail::default(),
            exact_every: None,
            revolutions: Vec::new(),
            seconds: Vec::new(),
            part_revolutions: Self::PART_REVOLUTIONS,
        }
    }
}

/// What is recorded of one revolution in addition to what always is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Share {
    /// Degrees, the pictures of W and L, links, U and the embedding.
    pub(crate) matrices: bool,
    /// Exact W and U.
    pub(crate) exact: bool,
    /// The count changed, but [`MOST_EVENTS`] is reached. Set at the first such revolution alone.
    pub(crate) exact_refused: bool,
    /// This is the first revolution of a later part of the recording.
    pub(crate) new_part: bool,
}

/// Decides what is recorded of each revolution, in the order of the flight.
pub(crate) struct Plan {
    scope: Scope,
    first_stamp_ns: Option<u64>,
    recorded: u64,
    junctions: Option<usize>,
    events: u64,
}

impl Plan {
    pub(crate) fn new(scope: Scope) -> Self {
        Self { scope, first_stamp_ns: None, recorded: 0, junctions: None, events: 0 }
    }

    /// What is recorded of this revolution; `None` if nothing is.
    pub(crate) fn share_of(&mut self, frame: &Frame) -> Option<Share> {
        let (seq, stamp_ns) = (frame.revolution.seq, frame.revolution.stamp_ns);
        let first_ns = *self.first_stamp_ns.get_or_insert(stamp_ns);
        let since_first_s = (i128::from(stamp_ns) - i128::from(first_ns)) as f64 * 1e-9;
        if !self.scope.contains(seq, since_first_s) {
            return None;
        }
        let part = self.scope.part_revolutions.get();
        let new_part = self.recorded > 0 && self.recorded.is_multiple_of(part);
        if self.recorded.is_multiple_of(EVENTS_WITHIN) {
            self.events = 0;
        }
        let junctions = frame.junction.junctions;
        let changed = self.junctions.replace(junctions).is_some_and(|before| before != junctions);
        let (exact, exact_refused) = self.exact(changed);
        self.recorded += 1;
        Some(Share { matrices: self.scope.detail != Detail::Light, exact, exact_refused, new_part })
    }

    /// Whether exact matrices are due, and whether they are refused for the first time.
    fn exact(&mut self, changed: bool) -> (bool, bool) {
        let every = self.scope.exact_every.or(self.scope.detail.exact_every());
        if every.is_some_and(|every| self.recorded.is_multiple_of(every.get())) {
            return (true, false);
        }
        if !changed || self.scope.detail == Detail::Light {
            return (false, false);
        }
        self.events += 1;
        (self.events <= MOST_EVENTS, self.events == MOST_EVENTS + 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(seq: u64, junctions: usize) -> Frame {
        let mut frame = Frame::default();
        frame.revolution.seq = seq;
        frame.revolution.stamp_ns = 5_000_000_000 + 100_000_000 * seq;
        frame.junction.junctions = junctions;
        frame
    }

    /// The shares of revolutions 0, 1, 2... with these counts.
    fn shares(scope: Scope, junctions: &[usize]) -> Vec<Option<Share>> {
        let mut plan = Plan::new(scope);
        (0..).zip(junctions).map(|(seq, &junctions)| plan.share_of(&frame(seq, junctions))).collect()
    }

    fn exact(scope: Scope, junctions: &[usize]) -> Vec<usize> {
        let shares = shares(scope, junctions);
        (0..shares.len()).filter(|&i| shares[i].is_some_and(|share| share.exact)).collect()
    }

    #[test]
    fn exact_matrices_at_every_nth_revolution_and_changed_count() {
        let every = |n| Scope { exact_every: NonZeroU64::new(n), ..Scope::default() };
        assert_eq!(exact(every(4), &[2, 2, 3, 3, 3, 3, 2, 2, 2]), [0, 2, 4, 6, 8]);
        assert_eq!(exact(Scope { detail: Detail::Full, ..Scope::default() }, &[2; 4]), [0, 1, 2, 3]);
        assert_eq!(exact(Scope { detail: Detail::Light, ..Scope::default() }, &[2, 3, 2]), [0; 0]);
    }

    #[test]
    fn a_flickering_count_does_not_fill_the_disk() {
        let flicker: Vec<usize> = (0..2 * EVENTS_WITHIN as usize).map(|i| i % 2).collect();
        let half = flicker.len() / 2;
        for part in [50, 6000, 100_000] {
            let part_revolutions = NonZeroU64::new(part).unwrap();
            let shares =
                shares(Scope { part_revolutions, exact_every: NonZeroU64::new(6000), ..Scope::default() }, &flicker);
            let in_halves = |what: fn(Share) -> bool| {
                [0..half, half..2 * half].map(|of| of.filter(|&i| shares[i].is_some_and(what)).count() as u64)
            };
            assert_eq!(in_halves(|share| share.exact), [MOST_EVENTS + 1; 2]);
            assert_eq!(in_halves(|share| share.exact_refused), [1, 1]);
            assert_eq!(in_halves(|share| share.new_part).iter().sum::<u64>(), (2 * EVENTS_WITHIN - 1) / part);
        }
    }

    #[test]
    fn only_the_chosen_revolutions_and_seconds_are_recorded_and_counted() {
        let recorded = |scope| -> Vec<usize> {
            let shares = shares(scope, &[2; 20]);
            (0..20).filter(|&i| shares[i].is_some()).collect()
        };
        assert_eq!(
            recorded(Scope { revolutions: vec![4..=6, 17..=u64::MAX], ..Scope::default() }),
            [4, 5, 6, 17, 18, 19]
        );
        assert_eq!(recorded(Scope { seconds: vec![0.25..=0.5], ..Scope::default() }), [3, 4, 5]);
        assert_eq!(recorded(Scope { revolutions: vec![4..=9], seconds: vec![0.75..=9.0], ..Scope::default() }), [8, 9]);
        let mut plan = Plan::new(Scope { seconds: vec![0.0..=0.5], ..Scope::default() });
        let set_back = [3, 4, 0, 1, 5].map(|seq| plan.share_of(&frame(seq, 2)).is_some());
        assert_eq!(set_back, [true, true, false, false, true], "a stamp before the first one is no second 0");
        let two = NonZeroU64::new(2).unwrap();
        let shares = shares(Scope { revolutions: vec![3..=9], part_revolutions: two, ..Scope::default() }, &[2; 20]);
        let parts: Vec<usize> = (0..20).filter(|&i| shares[i].is_some_and(|share| share.new_part)).collect();
        assert_eq!(parts, [5, 7, 9]);
    }
}
