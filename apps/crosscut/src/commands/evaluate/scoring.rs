//! Scores one configuration on one recording against the truth in it.

use std::path::PathBuf;
use std::time::Instant;

use crosscut_detector::Config;
use crosscut_evaluate::Evaluation;
use crosscut_evaluate::flights::{FlightFigures, FlightScore};
use crosscut_flight::Mapper;
use crosscut_ingest::{Truths, truth_map};
use crosscut_messages::{Truth, TruthMap};
use crosscut_pipeline::End;
use crosscut_stage::{Frame, Timings};

use super::wrong::Wrong;
use crate::cli::InputArgs;
use crate::diagnostics::Diagnostics;
use crate::fly::{Flight, Flown, How, fly};

/// The scores of one configuration on one recording.
pub(super) struct Scored {
    /// Figures over every revolution that has a truth.
    pub(super) evaluation: Evaluation,
    /// The figures of the flight, and the time that following it took, if its mine is known.
    pub(super) flight: Option<(FlightFigures, FlightTime)>,
    /// Each revolution that has a truth.
    pub(super) answered: Vec<Answered>,
    /// The wrong answers.
    pub(super) wrong: Wrong,
    flown: Flown,
    /// Why the map of the mine cannot be read.
    bad_map: Option<String>,
}

/// A revolution, whether its answer is right, and what it took.
pub(super) struct Answered {
    pub(super) seq: u64,
    pub(super) is_right: bool,
    pub(super) timings: Timings,
}

impl Scored {
    /// Reports what is missing, and why it ended early; `whose` names configuration and recording.
    pub(super) fn report(&self, whose: &str, diagnostics: &mut Diagnostics) {
        diagnostics.lost_all(&self.bad_map);
        self.flown.report(Some(whose), diagnostics);
        let is_complete = matches!(self.flown.summary.end, End::Complete) && !self.flown.is_empty();
        if is_complete && self.evaluation.revolutions() == 0 {
            diagnostics.error(format_args!("{whose}: no scan could be compared with its truth"));
        }
    }
}

/// Streams the recording through the stages of `config` and scores each result.
pub(super) fn score(path: &PathBuf, args: &InputArgs, config: &Config, how: &How<'_>) -> anyhow::Result<Scored> {
    let flight = Flight::open(std::slice::from_ref(path), args, config)?;
    let (flight, mine) = if flight.has_truths() {
        (flight, Ok(None)) // the map of the mine is not recorded
    } else {
        (flight.with_truths(Some(Truths::open(path)?)), truth_map(path)?.transpose())
    };
    let (mut evaluation, mut wrong, mut answered) = (Evaluation::default(), Wrong::default(), Vec::new());
    let bad_map = mine.as_ref().err().map(|error| format!("{error}, in {}", path.display()));
    let mut followed = mine.ok().flatten().map(|mine| Followed::new(&mine));
    let how = How { has_poses: followed.is_some(), ..*how };
    let flown = fly(flight, config, &how, &mut [], &mut |frame, judged| {
        if let Some(judged) = judged {
            if let Some(followed) = &mut followed {
                followed.add(frame, &judged.truth);
            }
            evaluation.add(&judged.score);
            let (seq, is_right) = (frame.revolution.seq, judged.score.right);
            answered.push(Answered { seq, is_right, timings: frame.timings });
            wrong.take(frame, &judged.truth, &judged.score);
        }
        Ok(())
    })?;
    Ok(Scored { evaluation, flight: followed.map(Followed::finish), answered, wrong, flown, bad_map })
}

/// A flight that is followed, and its map.
struct Followed {
    score: FlightScore,
    mapper: Mapper,
    time: FlightTime,
}

/// The time that poses, places, steady answers and the map take.
#[derive(Debug, Default)]
pub(super) struct FlightTime {
    revolutions_ns: Vec<u64>,
}

impl Followed {
    fn new(mine: &TruthMap) -> Self {
        Self { score: FlightScore::new(mine), mapper: Mapper::default(), time: FlightTime::default() }
    }

    fn add(&mut self, frame: &Frame, truth: &Truth) {
        let start = Instant::now();
        self.mapper.add(frame);
        let map_ns = u64::try_from(start.elapsed().as_nanos()).unwrap_or(u64::MAX);
        self.time.revolutions_ns.push(map_ns.saturating_add(frame.timings.flight_ns.unwrap_or(0)));
        self.score.add(frame, truth);
    }

    fn finish(self) -> (FlightFigures, FlightTime) {
        (self.score.figures(&self.mapper.map()), self.time)
    }
}

impl FlightTime {
    pub(super) fn merge(&mut self, other: Self) {
        self.revolutions_ns.extend(other.revolutions_ns);
    }

    /// The median and the 99th percentile in words; `None` without revolutions.
    pub(super) fn words(mut self) -> Option<String> {
        self.revolutions_ns.sort_unstable();
        let last = self.revolutions_ns.len().checked_sub(1)?;
        let [p50, p99] = [50, 99].map(|percent| self.revolutions_ns[last * percent / 100] as f64 * 1e-6);
        Some(format!(
            "pose, place, steady answer and map: {p50:.2} ms a revolution, {p99:.2} ms in the 99th percentile"
        ))
    }
}
