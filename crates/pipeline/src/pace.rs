//! Playing a recording at the sensor's pace.

use std::time::{Duration, Instant};

use crate::stop::StopFlag;

/// A wait looks this often whether it should stop.
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

    /// Waits until it is time for the revolution with this stamp. One from the past is due at once.
    pub(crate) fn wait_for(&mut self, stamp_ns: u64, stop: &StopFlag) {
        let (start, first_ns) = *self.first.get_or_insert_with(|| (Instant::now(), stamp_ns));
        let due_s = stamp_ns.saturating_sub(first_ns) as f64 / 1e9 / self.rate;
        loop {
            let left_s = due_s - start.elapsed().as_secs_f64();
            if left_s <= 0.0 || stop.is_set() {
                return;
            }
            std::thread::sleep(SLICE.min(Duration::from_secs_f64(left_s)));
        }
    }
}
