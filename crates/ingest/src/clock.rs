//! What time a scan has, where its time of recording or its stamp cannot be right.
//!
//! A time of recording (log time) is believed if it is near most of the others; 0 is believed if the others begin near
//! it. Where it is not believed, the stamp tells the time, shifted by the usual difference of the two. A stamp that is
//! missing, or is more than a day from where it should be, is replaced the other way round.

use crosscut_stage::NoteCode::{self, N049, N057, N058};

const NS_PER_S: u64 = 1_000_000_000;
/// Times that are this far from where they should be are not believed.
const DAY_NS: u64 = 24 * 3600 * NS_PER_S;
/// In long recordings, times are believed within this many times the span of the middle half of all times.
const SPANS: u64 = 10;
/// A clock that shows 0 has just started if other times are within this.
const START_NS: u64 = 60 * NS_PER_S;
/// This many stamps that are the same, while the times of recording rise, are those of a clock that stands.
const STANDING: usize = 8;

/// Time of recording and stamp of a scan; the stamp is 0 if there is none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Times {
    pub(crate) log_ns: u64,
    pub(crate) stamp_ns: u64,
}

/// The usual times of a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Clock {
    /// From and to when times of recording are believed.
    believed_ns: [u64; 2],
    /// The earliest time of recording that was seen and is believed.
    start_ns: u64,
    /// Time of recording less stamp, usually; `None` if no scan had both.
    offset_ns: Option<i128>,
    /// Whether all times of recording that were seen are believed.
    all_believed: bool,
    /// Whether stamps stand still, so that none is believed.
    stands: bool,
}

impl Clock {
    /// From the first scans of a flight, and from times of recording all over it.
    pub(crate) fn new(first: &[Times], log_times_ns: impl Iterator<Item = u64>) -> Self {
        let mut log_ns: Vec<u64> = first.iter().map(|times| times.log_ns).chain(log_times_ns).collect();
        log_ns.sort_unstable();
        let quantile =
            |quarters: usize| log_ns.get(log_ns.len().saturating_sub(1) * quarters / 4).copied().unwrap_or(0);
        let margin_ns = DAY_NS.saturating_add(SPANS.saturating_mul(quantile(3) - quantile(1)));
        let [low, high] = [quantile(2).saturating_sub(margin_ns), quantile(2).saturating_add(margin_ns)];
        let is_near = |ns: &u64| (low..=high).contains(ns);
        let after_0 = log_ns.iter().copied().find(|ns| *ns > 0);
        let starts_at_0 = after_0.is_none_or(|ns| ns <= START_NS);
        let low = if starts_at_0 { low } else { low.max(1) };
        let start_ns = log_ns.iter().copied().find(|ns| *ns >= low && is_near(ns)).unwrap_or(0);
        let stands = first.len() >= STANDING
            && first[0].stamp_ns > 0
            && first.windows(2).all(|pair| pair[0].stamp_ns == pair[1].stamp_ns && pair[0].log_ns < pair[1].log_ns);
        let mut clock = Self { believed_ns: [low, high], start_ns, offset_ns: None, all_believed: true, stands };
        clock.all_believed = log_ns.iter().all(|ns| clock.believes(*ns));
        let both = first.iter().filter(|times| !stands && times.stamp_ns > 0 && clock.believes(times.log_ns));
        let mut offsets: Vec<i128> = both.map(|times| i128::from(times.log_ns) - i128::from(times.stamp_ns)).collect();
        offsets.sort_unstable();
        clock.offset_ns = offsets.get(offsets.len() / 2).copied();
        clock
    }

    /// Whether a time of recording is near most others.
    pub(crate) fn believes(&self, log_ns: u64) -> bool {
        (self.believed_ns[0]..=self.believed_ns[1]).contains(&log_ns)
    }

    /// Whether all times of recording that were seen are near most others, so that their order can be relied on.
    pub(crate) fn believes_all(&self) -> bool {
        self.all_believed
    }

    /// Whether stamps are of another clock than times of recording, such as that of a simulation.
    pub(crate) fn of_two_clocks(&self) -> bool {
        self.offset_ns.is_some_and(|offset_ns| offset_ns.unsigned_abs() > u128::from(DAY_NS))
    }

    /// The earliest time of recording that is believed.
    pub(crate) fn start_ns(&self) -> u64 {
        self.start_ns
    }

    /// When a scan was recorded, as far as anything tells, with a note if that is not its time of recording.
    pub(crate) fn recorded_ns(&self, times: Times) -> (u64, Option<(NoteCode, &'static str)>) {
        if self.believes(times.log_ns) {
            return (times.log_ns, None);
        }
        let by_stamp = self.offset_ns.filter(|_| times.stamp_ns > 0).map(|offset| i128::from(times.stamp_ns) + offset);
        match by_stamp.and_then(|ns| u64::try_from(ns).ok()).filter(|ns| self.believes(*ns)) {
            Some(ns) => (ns, Some((N058, "implausible time of recording, replaced by the stamp"))),
            None => (self.start_ns, Some((N058, "implausible time of recording, replaced by that of the first scan"))),
        }
    }

    /// The stamp of a scan that was recorded at `recorded_ns`, with a note if it is not its own.
    pub(crate) fn stamp_ns(&self, stamp_ns: u64, recorded_ns: u64) -> (u64, Option<(NoteCode, &'static str)>) {
        let expected = i128::from(recorded_ns) - self.offset_ns.unwrap_or(0);
        let is_off = (expected - i128::from(stamp_ns)).unsigned_abs() > u128::from(DAY_NS);
        let has_started = self.of_two_clocks() && expected.unsigned_abs() < u128::from(START_NS);
        let by_recording = if self.of_two_clocks() { u64::try_from(expected).unwrap_or(0) } else { recorded_ns };
        match stamp_ns {
            0 if has_started => (0, None),
            _ if self.stands && stamp_ns > 0 => {
                (recorded_ns, Some((N049, "the stamps stand still: the time of recording is used")))
            }
            0 => (by_recording, Some((N049, "no stamp: the time of recording is used"))),
            _ if is_off && self.offset_ns.is_some() => {
                (by_recording, Some((N057, "the stamp is more than a day off: the time of recording is used")))
            }
            _ => (stamp_ns, None),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const T0: u64 = 1_700_000_000 * NS_PER_S;

    fn clock(times: &[[u64; 2]]) -> Clock {
        let first: Vec<Times> = times.iter().map(|&[log_ns, stamp_ns]| Times { log_ns, stamp_ns }).collect();
        Clock::new(&first, std::iter::empty())
    }

    fn recorded(clock: &Clock, log_ns: u64, stamp_ns: u64) -> (u64, u64) {
        let (recorded_ns, _) = clock.recorded_ns(Times { log_ns, stamp_ns });
        (recorded_ns, clock.stamp_ns(stamp_ns, recorded_ns).0)
    }

    #[test]
    fn good_times_are_left_alone() {
        let clock = clock(&[[T0, T0 - 5], [T0 + 100, T0 + 90], [T0 + 200, T0 + 195]]);
        for (log_ns, stamp_ns) in [(T0, T0 - 5), (T0 + DAY_NS / 2, T0 + DAY_NS / 2 - 7)] {
            assert_eq!(recorded(&clock, log_ns, stamp_ns), (log_ns, stamp_ns));
        }
        assert_eq!(recorded(&clock, T0 + 100, 0), (T0 + 100, T0 + 100), "no stamp");
        assert_eq!(clock.start_ns(), T0);
    }

    #[test]
    fn the_clock_of_a_simulation_may_start_at_0() {
        let clock = clock(&[[T0, 0], [T0 + 100, 100], [T0 + 200, 200], [T0 + 300, 300]]);
        assert_eq!(recorded(&clock, T0, 0), (T0, 0), "the first stamp is right");
        assert_eq!(
            recorded(&clock, T0 + 400 * NS_PER_S, 0),
            (T0 + 400 * NS_PER_S, 400 * NS_PER_S),
            "a missing one is not"
        );
        let by_itself = self::clock(&[[0, 0], [NS_PER_S, NS_PER_S], [2 * NS_PER_S, 2 * NS_PER_S]]);
        assert!(by_itself.believes(0), "times of recording may start at 0 as well");
    }

    #[test]
    fn scans_before_the_clock_was_set_are_at_the_start() {
        for t0 in [T0, 4000 * NS_PER_S] {
            let clock = clock(&[[0, 0], [0, 0], [t0, t0], [t0 + 100, t0 + 100], [t0 + 200, t0 + 200]]);
            assert_eq!((recorded(&clock, 0, 0), clock.start_ns()), ((t0, t0), t0));
        }
    }

    #[test]
    fn a_broken_time_of_recording_is_told_by_the_stamp() {
        let mut times: Vec<[u64; 2]> = (0..10).map(|i| [T0 + i * 100; 2]).collect();
        (times[1][0], times[2][0]) = (u64::MAX - 25, 12_345);
        let clock = clock(&times);
        for (log_ns, stamp_ns) in [(u64::MAX - 25, T0 + 100), (12_345, T0 + 200)] {
            assert_eq!(recorded(&clock, log_ns, stamp_ns), (stamp_ns, stamp_ns));
        }
        assert_eq!(clock.start_ns(), T0);
    }

    #[test]
    fn stamps_that_stand_still_are_not_believed() {
        let times: Vec<[u64; 2]> = (0..10).map(|i| [T0 + i * 100, 7]).collect();
        assert_eq!(recorded(&clock(&times), T0 + 500, 7), (T0 + 500, T0 + 500));
        assert_eq!(recorded(&clock(&times[..5]), T0 + 500, 7).1, 7, "too few");
    }

    #[test]
    fn a_stamp_that_is_a_day_off_is_replaced() {
        let clock = clock(&[[T0, T0], [T0 + 100, T0 + 100], [T0 + 200, T0 + 200]]);
        assert_eq!(recorded(&clock, T0 + 100, T0 + 2 * DAY_NS), (T0 + 100, T0 + 100));
    }

    #[test]
    fn a_recording_of_many_days_is_believed() {
        let days: Vec<[u64; 2]> = (0..40).map(|day| [T0 + day * DAY_NS; 2]).collect();
        assert!(days.iter().all(|[log_ns, _]| clock(&days).believes(*log_ns)));
    }
}
