//! Scores one configuration on one recording against the truth in it.

use std::collections::VecDeque;
use std::path::Path;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use anyhow::Context;
use crosscut_detector::{Config, Registry};
use crosscut_evaluate::flights::{FlightFigures, FlightScore};
use crosscut_evaluate::{Evaluation, Score};
use crosscut_flight::Mapper;
use crosscut_ingest::{ReadOptions, Recording, Truths, truth_map};
use crosscut_messages::{Truth, TruthError, TruthMap};
use crosscut_pipeline::{End, StopFlag, StreamOptions, stream};
use crosscut_report::ResultsLine;
use crosscut_sensor::Sensor;
use crosscut_stage::{Frame, Notes, Revolution, Source, SourceError, counted};
use indicatif::ProgressBar;

use crate::wrong::Wrong;

/// The scores of one configuration on one recording.
pub(crate) struct Scored {
    /// Figures over every revolution that has a truth.
    pub(crate) evaluation: Evaluation,
    /// The figures of the flight, and the time that following it took, if its mine is known.
    pub(crate) flight: Option<(FlightFigures, FlightTime)>,
    /// The wrong answers.
    pub(crate) wrong: Wrong,
    /// How the run ended.
    pub(crate) end: End,
    /// Messages about what was lost or could not be compared.
    pub(crate) losses: Vec<String>,
}

/// Opens the scans of a recording.
pub(crate) fn open(path: &Path, options: &ReadOptions, config: &Config) -> anyhow::Result<Recording> {
    Ok(Recording::open(&[path.to_owned()], options, Sensor::new(config.params("ingest")))?)
}

/// Streams the recording through the stages of `config` and scores each result.
pub(crate) fn score(
    path: &Path,
    options: &ReadOptions,
    config: &Config,
    registry: &Registry,
    stop: &StopFlag,
    bar: &ProgressBar,
) -> anyhow::Result<Scored> {
    let queue = TruthQueue::default();
    let mut source = WithTruth { recording: open(path, options, config)?, truths: Truths::open(path)?, queue: &queue };
    let (mut evaluation, mut wrong, mut not_compared) =
        (Evaluation::default(), Wrong::default(), NotCompared::default());
    let mine = truth_map(path)?.transpose();
    let bad_map = mine.as_ref().err().map(|error| format!("{error}, in {}", path.display()));
    let mut followed = mine.ok().flatten().map(|mine| Followed::new(&mine));
    let options = StreamOptions { stop: stop.clone(), flight: followed.is_some(), ..StreamOptions::default() };
    let mut results = |frame: &Frame| {
        match queue.compare(frame) {
            Ok((truth, score)) => {
                if let Some(followed) = &mut followed {
                    followed.add(frame, &truth);
                }
                evaluation.add(&score);
                wrong.take(frame, &truth, &score);
            }
            Err(reason) => not_compared.add(reason),
        }
        bar.inc(1);
        Ok(())
    };
    let summary = stream(&mut source, config, registry, &mut results, &mut [], &options);
    let end = summary.context("a thread could not be started")?.end;
    let lost = source.recording.losses().iter().map(ToString::to_string);
    let losses = lost.chain(not_compared.messages(path)).chain(bad_map).collect();
    Ok(Scored { evaluation, flight: followed.map(Followed::finish), wrong, end, losses })
}

/// A flight that is followed, and its map.
struct Followed {
    score: FlightScore,
    mapper: Mapper,
    time: FlightTime,
}

/// The time that poses, places, steady answers and the map take.
#[derive(Debug, Default)]
pub(crate) struct FlightTime {
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
        self.time.revolutions_ns.push(map_ns.saturating_add(frame.timings.flight_ns().unwrap_or(0)));
        self.score.add(frame, truth);
    }

    fn finish(self) -> (FlightFigures, FlightTime) {
        (self.score.figures(&self.mapper.map()), self.time)
    }
}

impl FlightTime {
    pub(crate) fn merge(&mut self, other: Self) {
        self.revolutions_ns.extend(other.revolutions_ns);
    }

    /// The median and the 99th percentile in words; `None` without revolutions.
    pub(crate) fn words(mut self) -> Option<String> {
        self.revolutions_ns.sort_unstable();
        let last = self.revolutions_ns.len().checked_sub(1)?;
        let [p50, p99] = [50, 99].map(|percent| self.revolutions_ns[last * percent / 100] as f64 * 1e-6);
        Some(format!(
            "pose, place, steady answer and map: {p50:.2} ms a revolution, {p99:.2} ms in the 99th percentile"
        ))
    }
}

/// The truth of each revolution on its way: results leave in the order of the source.
#[derive(Default)]
pub(crate) struct TruthQueue(Mutex<VecDeque<TruthAt>>);

type TruthAt = Result<Option<Truth>, TruthError>;

/// The reason that a result was not compared; `None` if there is no truth.
type NoScore = Option<String>;

impl TruthQueue {
    /// Compares the next result with its truth.
    pub(crate) fn compare(&self, frame: &Frame) -> Result<(Truth, Score), NoScore> {
        let truth = self.0.lock().unwrap_or_else(PoisonError::into_inner).pop_front().unwrap_or(Ok(None));
        let truth =
            truth.map_err(|error| Some(format!("revolution {}: {error}", frame.revolution.seq)))?.ok_or(None)?;
        let score = Score::of(&truth, &ResultsLine::of(frame)).map_err(|error| Some(error.to_string()))?;
        Ok((truth, score))
    }
}

/// A recording that puts the truth of each revolution into a queue.
pub(crate) struct WithTruth<'a> {
    pub(crate) recording: Recording,
    pub(crate) truths: Truths,
    pub(crate) queue: &'a TruthQueue,
}

impl Source for WithTruth<'_> {
    fn next(&mut self, out: &mut Revolution, notes: &mut Notes) -> Result<bool, SourceError> {
        let more = self.recording.next(out, notes)?;
        if more {
            let truth = self.truths.at(self.recording.last_log_time_ns());
            self.queue.0.lock().unwrap_or_else(PoisonError::into_inner).push_back(truth);
        }
        Ok(more)
    }
}

/// Counts the revolutions that could not be compared with a truth.
#[derive(Default)]
pub(crate) struct NotCompared {
    without_truth: u64,
    /// The number of others, and the reason of the first.
    others: Option<(u64, String)>,
}

impl NotCompared {
    pub(crate) fn add(&mut self, reason: NoScore) {
        match reason {
            None => self.without_truth += 1,
            Some(reason) => self.others.get_or_insert((0, reason)).0 += 1,
        }
    }

    pub(crate) fn messages(self, path: &Path) -> Vec<String> {
        let path = path.display();
        let mut losses = Vec::new();
        if self.without_truth > 0 {
            losses.push(format!("no truth has the log time of {}, in {path}", counted(self.without_truth, "scan")));
        }
        if let Some((count, first)) = self.others {
            losses.push(format!(
                "{} cannot be compared with the truth, the first: {first}, in {path}",
                counted(count, "scan")
            ));
        }
        losses
    }
}
