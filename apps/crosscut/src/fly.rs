//! A flight on its way through the program, as every command flies it: opened, streamed through the stages, compared with
//! its truth where it has one. What is missing and why it ended is reported in one way.

use std::collections::VecDeque;
use std::io;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use anyhow::Context;
use crosscut_detector::{Config, Registry};
use crosscut_pipeline::{RunEnd, StopFlag, StreamOptions, Summary, stream};
use crosscut_stage::{Failure, FailureCause, Frame, Notes, Observer, Revolution, Source, SourceError, Step, counted};
use indicatif::ProgressBar;

use crate::diagnostics::Diagnostics;
use crate::exit::is_closed_pipe;
use crate::input::{Flight, Judge, Judged, TruthAt};

/// How flights are flown.
#[derive(Clone, Copy)]
pub(crate) struct How<'a> {
    pub(crate) registry: &'a Registry,
    pub(crate) stop: &'a StopFlag,
    pub(crate) bar: &'a ProgressBar,
    /// This multiple of the recorded pace; `None`: as fast as the stages are.
    pub(crate) rate: Option<f64>,
    /// Whether frames get their poses, places and steady answers.
    pub(crate) has_poses: bool,
}

/// What becomes of each finished frame, which has a truth and its score if the flight has.
pub(crate) type Sink<'a> = dyn FnMut(&Frame, Option<&Judged>) -> io::Result<()> + Send + 'a;

/// Streams a flight through the stages of `config`: each frame to `sink`, then to the observers.
pub(crate) fn fly(
    mut flight: Flight,
    config: &Config,
    how: &How<'_>,
    observers: &mut [Box<dyn Observer>],
    sink: &mut Sink<'_>,
) -> anyhow::Result<Flown> {
    let start = Instant::now();
    let (truths, mut judge, mut returns) = (Mutex::default(), Judge::default(), 0);
    let mut results = |frame: &Frame| {
        how.bar.inc(1);
        returns += frame.revolution.len();
        let truth = lock(&truths).pop_front().unwrap_or(Ok(None));
        sink(frame, judge.judged(truth, frame).as_ref())
    };
    let options = StreamOptions { rate: how.rate, stop: how.stop.clone(), flight: how.has_poses };
    let mut source = Scans { flight: &mut flight, truths: &truths };
    let ran = stream(&mut source, config, how.registry, &mut results, observers, &options);
    let summary = ran.context("a thread could not be started")?;
    Ok(Flown { elapsed: start.elapsed(), ..Flown::of(&flight, judge, summary, returns) })
}

/// The scans of a flight. Their truths wait for the answers, which come in the same order.
struct Scans<'a> {
    flight: &'a mut Flight,
    truths: &'a Mutex<VecDeque<TruthAt>>,
}

impl Source for Scans<'_> {
    fn next(&mut self, out: &mut Revolution, notes: &mut Notes) -> Result<bool, SourceError> {
        let truth = self.flight.next(out, notes)?;
        let more = truth.is_some();
        lock(self.truths).extend(truth);
        Ok(more)
    }
}

fn lock(truths: &Mutex<VecDeque<TruthAt>>) -> std::sync::MutexGuard<'_, VecDeque<TruthAt>> {
    truths.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A flight that was flown.
pub(crate) struct Flown {
    pub(crate) summary: Summary,
    pub(crate) elapsed: Duration,
    /// When its first revolution was recorded, seconds after its first scan.
    pub(crate) starts_at_s: f64,
    /// What was lost of it, or could not be compared with its truth.
    pub(crate) losses: Vec<String>,
    left_out: Vec<String>,
    /// Of all revolutions.
    returns: usize,
}

/// A note on a flight in which no scan has a return.
const NO_RETURN: &str =
    "no scan has a usable return: either nothing was in range, or the notes in the results give the reason";

impl Flown {
    /// Of a flight that was read, whose revolutions have so many returns.
    pub(crate) fn of(flight: &Flight, judge: Judge, summary: Summary, returns: usize) -> Self {
        Self {
            summary,
            elapsed: Duration::ZERO,
            starts_at_s: flight.starts_at_s().unwrap_or(0.0),
            losses: flight.losses(judge),
            left_out: flight.left_out(),
            returns,
        }
    }

    /// With the losses of the same flight, read in another way.
    pub(crate) fn with_losses_of(mut self, other: Self) -> Self {
        self.losses.extend(other.losses);
        self.left_out.extend(other.left_out);
        self
    }

    /// Whether it has no revolution.
    pub(crate) fn is_empty(&self) -> bool {
        self.summary.revolutions == 0
    }

    /// Reports what is missing and why the flight ended; `whose` names it where there are several.
    pub(crate) fn report(&self, whose: Option<&str>, diagnostics: &mut Diagnostics) {
        self.report_missing(diagnostics);
        self.report_end(whose, diagnostics);
    }

    /// Reports what was lost, and what is odd.
    pub(crate) fn report_missing(&self, diagnostics: &mut Diagnostics) {
        diagnostics.lost_all(&self.losses);
        diagnostics.lost_all(&self.summary.observer_errors);
        self.left_out.iter().for_each(|note| diagnostics.note(note));
        if !self.is_empty() && self.returns == 0 {
            diagnostics.note(NO_RETURN);
        }
    }

    /// Reports why the flight ended, unless that is its end.
    pub(crate) fn report_end(&self, whose: Option<&str>, diagnostics: &mut Diagnostics) {
        let done = counted(self.summary.revolutions, "revolution");
        let of = whose.map_or_else(String::new, |whose| format!("{whose}: "));
        match &self.summary.end {
            // No revolution is at fault: the reader's error states the place.
            RunEnd::Failed(Failure { step: Step::Ingest, cause: FailureCause::Error(cause), .. })
                if self.is_empty() =>
            {
                diagnostics.error(cause);
            }
            RunEnd::Failed(failure) => diagnostics.error(format_args!("{of}{failure}; before it: {done}")),
            RunEnd::ResultsLost(error) => report_lost_results(&of, error, &done, diagnostics),
            RunEnd::Interrupted => {
                let at = whose.map_or_else(String::new, |whose| format!("at {whose}, "));
                diagnostics.interrupted(format_args!("{at}after {done}; what is written covers what came before"));
            }
            RunEnd::Complete if self.is_empty() => diagnostics.error(format_args!("{of}no scan could be read")),
            RunEnd::Complete => {}
        }
    }

    /// Reports that the results cannot be written to their end.
    pub(crate) fn report_lost(&self, error: &io::Error, diagnostics: &mut Diagnostics) {
        report_lost_results("", error, &counted(self.summary.revolutions, "revolution"), diagnostics);
    }
}

/// A reader of results that closed the pipe wants no more.
fn report_lost_results(of: &str, error: &io::Error, done: &str, diagnostics: &mut Diagnostics) {
    if is_closed_pipe(error) {
        diagnostics.interrupt();
    } else {
        diagnostics.error(format_args!("{of}the results cannot be written after {done}: {error}"));
    }
}
