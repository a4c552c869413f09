//! Playing a recording at the sensor's pace.

use std::time::{Duration, Instant};

/// A wait looks this often whether it is over.
const SLICE: Duration = Duration::from_millis(20);

/// Releases revolutions at a multiple of the pace at which the sensor stamped them.
pub(crate) struct Pace {
    rate: f64,
    first: Option<(Instant, u64)>,
}

impl Pace {
    /// `rate` 1 is the sensor's own pace, 2 twice as fast; it is positive.
    pub(crate) fn new(rate: f64) -> Self {
        Self { rate, first: None }
    }

    /// Waits until it is time for the revolution with this stamp, and says when that was: earlier than now if the wait
    /// began too late. One from the past is due at once. `is_over` ends the wait.
    pub(crate) fn wait_for(&mut self, stamp_ns: u64, is_over: impl Fn() -> bool) -> Instant {
        let (start, first_ns) = *self.first.get_or_insert_with(|| (Instant::now(), stamp_ns));
        let due_s = stamp_ns.saturating_sub(first_ns) as f64 / 1e9 / self.rate;
        let due = Duration::try_from_secs_f64(due_s).ok().and_then(|after| start.checked_add(after));
        loop {
            let now = Instant::now();
            match due {
                Some(due) if due <= now => return due,
                _ if is_over() => return now,
                Some(due) => std::thread::sleep(SLICE.min(due - now)),
                None => std::thread::sleep(SLICE),
            }
        }
    }
}
