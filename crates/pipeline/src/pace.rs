//! Playing a recording at the sensor's pace.

use std::time::{Duration, Instant};

/// A wait checks this often whether it is over.
const SLICE: Duration = Duration::from_millis(20);

/// A longer pause of the stamps is not waited for: the clock was set, or another recording begins.
const LONGEST_PAUSE_NS: u64 = 10_000_000_000;
/// A longer step back of the stamps is not made up for, for the same reasons.
const LONGEST_STEP_BACK_NS: u64 = 1_000_000_000;

/// The longest wait for a revolution, at a very low rate: a century, which every clock can reach.
const LONGEST_WAIT: Duration = Duration::from_secs(100 * 365 * 24 * 3600);

/// Releases revolutions at a multiple of the pace at which the sensor stamped them.
pub(crate) struct Pace {
    rate: f64,
    /// When the previous revolution was due, and its stamp.
    previous: Option<(Instant, u64)>,
}

impl Pace {
    /// `rate` 1 is the sensor's own pace, 2 twice as fast; it is positive.
    pub(crate) fn new(rate: f64) -> Self {
        Self { rate, previous: None }
    }

    /// Waits until it is time for the revolution with this stamp, and returns that time: earlier than now if the wait
    /// began too late. A revolution from long before or after the previous one is due at once. `is_over` ends the wait.
    pub(crate) fn wait_for(&mut self, stamp_ns: u64, is_over: impl Fn() -> bool) -> Instant {
        let due = self.due(stamp_ns).unwrap_or_else(Instant::now);
        self.previous = Some((due, stamp_ns));
        loop {
            let now = Instant::now();
            if due <= now {
                return due;
            }
            if is_over() {
                return now;
            }
            std::thread::sleep(SLICE.min(due - now));
        }
    }

    /// When the revolution with this stamp is due; `None` if that is unknown.
    fn due(&self, stamp_ns: u64) -> Option<Instant> {
        let (due, previous_ns) = self.previous?;
        let (is_ahead, pause_ns) = (stamp_ns >= previous_ns, stamp_ns.abs_diff(previous_ns));
        if pause_ns > if is_ahead { LONGEST_PAUSE_NS } else { LONGEST_STEP_BACK_NS } {
            return None;
        }
        let pause = Duration::try_from_secs_f64(pause_ns as f64 / 1e9 / self.rate);
        let pause = pause.map_or(LONGEST_WAIT, |pause| pause.min(LONGEST_WAIT));
        if is_ahead { due.checked_add(pause) } else { due.checked_sub(pause) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clock_that_is_set_forward_or_back_is_not_waited_for_and_the_pace_is_kept_after_it() {
        const PERIOD_NS: u64 = 10_000_000;
        let (mut pace, start) = (Pace::new(1.0), Instant::now());
        let set_ns = 1_700_000_000_000_000_000;
        let back_ns = set_ns - 2_000_000_000;
        let stamps_ns =
            [10, 10 + PERIOD_NS, set_ns, set_ns + PERIOD_NS, back_ns, back_ns + PERIOD_NS, 50, 50 + PERIOD_NS];
        let due = stamps_ns.map(|stamp_ns| pace.wait_for(stamp_ns, || start.elapsed().as_secs() > 20));
        assert!(start.elapsed().as_secs() < 20, "it waits for years");
        for pair in [1, 3, 5, 7] {
            assert_eq!(due[pair] - due[pair - 1], Duration::from_nanos(PERIOD_NS));
        }
        assert!(due.is_sorted(), "after a step back revolutions are due at once, not in the past");
    }

    #[test]
    fn at_a_rate_too_low_for_any_clock_a_revolution_is_waited_for_and_not_due_at_once() {
        for rate in [1e-300, 1e-12] {
            let (mut pace, start) = (Pace::new(rate), Instant::now());
            pace.wait_for(0, || false);
            let asked = std::cell::Cell::new(0);
            pace.wait_for(1_000_000, || asked.replace(asked.get() + 1) > 0);
            assert!(asked.get() > 0 && start.elapsed().as_secs() < 20, "rate {rate}");
        }
    }
}
