//! Scores one configuration on one recording against the truth in it.

use std::collections::VecDeque;
use std::path::Path;
use std::sync::{Mutex, PoisonError};

use anyhow::Context;
use crosscut_evaluate::{Evaluation, Score};
use crosscut_ingest::{ReadOptions, Recording, Sensor, Truths};
use crosscut_messages::{Truth, TruthError};
use crosscut_pipeline::{Config, End, Registry, StopFlag, StreamOptions, stream};
use crosscut_report::ResultsLine;
use crosscut_stage::{Frame, Notes, Revolution, Source, SourceError, counted};
use indicatif::ProgressBar;

use crate::wrong::Wrong;

/// The scores of one configuration on one recording.
pub(crate) struct Scored {
    /// Figures over every revolution that has a truth.
    pub(crate) evaluation: Evaluation,
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
    let mut results = |frame: &Frame| {
        match queue.compare(frame) {
            Ok((truth, score)) => {
                evaluation.add(&score);
                wrong.take(frame, &truth, &score);
            }
            Err(reason) => not_compared.add(reason),
        }
        bar.inc(1);
        Ok(())
    };
    let options = StreamOptions { stop: stop.clone(), ..StreamOptions::default() };
    let summary = stream(&mut source, config, registry, &mut results, &mut [], &options);
    let end = summary.context("a thread could not be started")?.end;
    let lost = source.recording.losses().iter().map(ToString::to_string);
    Ok(Scored { evaluation, wrong, end, losses: lost.chain(not_compared.messages(path)).collect() })
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
struct NotCompared {
    without_truth: u64,
    /// The number of others, and the reason of the first.
    others: Option<(u64, String)>,
}

impl NotCompared {
    fn add(&mut self, reason: NoScore) {
        match reason {
            None => self.without_truth += 1,
            Some(reason) => self.others.get_or_insert((0, reason)).0 += 1,
        }
    }

    fn messages(self, path: &Path) -> Vec<String> {
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
