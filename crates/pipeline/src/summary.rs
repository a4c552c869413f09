//! What a run amounts to.

use std::collections::BTreeMap;

use crosscut_stage::{Failure, Frame, Step};

/// Counts and times of one run.
#[derive(Debug, Default)]
pub struct Summary {
    /// Revolutions whose results were written.
    pub revolutions: u64,
    /// How many of them had each number of junctions.
    pub junctions: BTreeMap<usize, u64>,
    /// How many of them carried a note.
    pub noted: u64,
    /// How long each step took.
    pub times: StageTimes,
    /// How the run ended.
    pub end: End,
    /// Observers that gave up on the way, and why.
    pub observer_errors: Vec<String>,
}

/// How a run ended. What was written before stays.
#[derive(Debug, Default)]
pub enum End {
    /// The source was read to its end.
    #[default]
    Complete,
    /// Somebody asked it to stop.
    Interrupted,
    /// A step failed on a revolution; every revolution before it was written.
    Failed(Failure),
    /// The results could not be written.
    ResultsLost(std::io::Error),
}

/// Time per step over a run.
#[derive(Debug, Default)]
pub struct StageTimes([Vec<u64>; Step::ALL.len()]);

impl StageTimes {
    /// Median and 99th percentile of a step in nanoseconds, nearest rank; `None` if it never ran.
    pub fn median_and_p99_ns(&self, step: Step) -> Option<(u64, u64)> {
        let mut times = self.0[step as usize].clone();
        times.sort_unstable();
        let rank = |percent: usize| times.get((times.len() * percent).div_ceil(100).saturating_sub(1)).copied();
        Some((rank(50)?, rank(99)?))
    }

    fn add(&mut self, frame: &Frame) {
        for step in Step::ALL {
            self.0[step as usize].push(frame.timings.ns(step));
        }
    }
}

impl Summary {
    pub(crate) fn add(&mut self, frame: &Frame) {
        self.revolutions += 1;
        *self.junctions.entry(frame.junction.junctions).or_default() += 1;
        self.noted += u64::from(!frame.notes.is_empty());
        self.times.add(frame);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_of_the_nearest_rank() {
        let mut times = StageTimes::default();
        assert_eq!(times.median_and_p99_ns(Step::Report), None);
        times.0[Step::Report as usize] = (1..=100).rev().collect();
        assert_eq!(times.median_and_p99_ns(Step::Report), Some((50, 99)));
        times.0[Step::Report as usize] = vec![7];
        assert_eq!(times.median_and_p99_ns(Step::Report), Some((7, 7)));
    }
}
