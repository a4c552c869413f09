//! Counts and times of a run.

use std::collections::BTreeMap;

use crosscut_stage::{Failure, Frame, KnownGaps, SURE, Step, Way};

use crate::note_counts::NoteCounts;
use crate::quantiles::Quantiles;

/// Counts and times of one run.
#[derive(Debug, Default)]
pub struct Summary {
    /// Revolutions whose results were written.
    pub revolutions: u64,
    /// Revolutions with each count: of ways on where these are counted, else of walls.
    pub counts: BTreeMap<usize, Answers>,
    /// The ways on of the last revolution, where these are counted.
    pub ways: Option<Vec<Way>>,
    /// How their gaps are known.
    pub gaps: KnownGaps,
    /// Number of them with a note.
    pub noted: u64,
    /// Their notes.
    pub notes: NoteCounts,
    /// Time of each step.
    pub times: StageTimes,
    /// How the run ended.
    pub end: RunEnd,
    /// Observers that gave up on the way, and why.
    pub observer_errors: Vec<String>,
}

/// Revolutions of one count.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Answers {
    /// All of them.
    pub revolutions: u64,
    /// Revolutions with a confidence of [`SURE`] or more.
    pub sure: u64,
    /// Revolutions with a confidence.
    pub rated: u64,
}

/// How a run ended. What was written before stays.
#[derive(Debug, Default)]
pub enum RunEnd {
    /// The source was read to its end.
    #[default]
    Complete,
    /// The run was asked to stop.
    Interrupted,
    /// A step failed on a revolution; every revolution before it was written.
    Failed(Failure),
    /// The results could not be written.
    ResultsLost(std::io::Error),
}

/// Times of each step over a run and latency, nanoseconds.
#[derive(Debug, Default)]
pub struct StageTimes {
    /// Of each step, in the order of [`Step::ALL`].
    pub steps: [Quantiles; Step::ALL.len()],
    /// Of the flight.
    pub flight: Quantiles,
    /// From a scan's arrival to its written results.
    pub latency: Quantiles,
}

impl StageTimes {
    fn add(&mut self, frame: &Frame) {
        for step in Step::ALL {
            self.steps[step as usize].add(frame.timings.ns(step));
        }
        frame.timings.flight_ns.into_iter().for_each(|ns| self.flight.add(ns));
        frame.timings.latency_ns.into_iter().for_each(|ns| self.latency.add(ns));
    }
}

impl Summary {
    /// The answers of all revolutions, whatever their count.
    pub fn answers(&self) -> Answers {
        self.counts.values().fold(Answers::default(), |all, of| Answers {
            revolutions: all.revolutions + of.revolutions,
            sure: all.sure + of.sure,
            rated: all.rated + of.rated,
        })
    }

    pub(crate) fn add(&mut self, frame: &Frame) {
        self.revolutions += 1;
        self.ways.clone_from(&frame.junction.ways);
        let count = self.ways.as_ref().map_or(frame.junction.junctions, Vec::len);
        let answers = self.counts.entry(count).or_default();
        answers.revolutions += 1;
        answers.rated += u64::from(frame.junction.confidence.is_some());
        answers.sure += u64::from(frame.junction.confidence.is_some_and(|confidence| confidence >= SURE));
        self.gaps += frame.junction.gaps;
        self.noted += u64::from(!frame.notes.is_empty());
        self.notes.add(self.revolutions, &frame.notes);
        self.times.add(frame);
    }
}
